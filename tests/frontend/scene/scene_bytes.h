// SPDX-License-Identifier: Apache-2.0
// Builds small scene and camera files byte by byte and loads them.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"

namespace grtx::test {}

namespace grtx::frontend::test {

using namespace grtx::test;  // test:: is one place, whoever says it

/// Bytes of numbers in the machine's (little-endian) order, one after the other.
class Bytes {
 public:
  template <typename T>
  Bytes& add(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    text_.append(raw, sizeof(T));
    return *this;
  }
  template <typename T>
  Bytes& add_swapped(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    std::reverse(raw, raw + sizeof(T));
    text_.append(raw, sizeof(T));
    return *this;
  }
  Bytes& u8(unsigned value) { return add(static_cast<std::uint8_t>(value)); }
  Bytes& f32(double value) { return add(static_cast<float>(value)); }
  Bytes& text(std::string_view value) {
    text_ += value;
    return *this;
  }
  const std::string& str() const { return text_; }
  std::size_t size() const { return text_.size(); }

 private:
  std::string text_;
};

/// Base64 of RFC 4648.
inline std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  unsigned word = 0;
  int bits = 0;
  for (const char c : bytes) {
    word = word << 8 | static_cast<unsigned char>(c);
    for (bits += 8; bits >= 6; bits -= 6) text += kDigits[word >> (bits - 6) & 63U];
  }
  if (bits > 0) text += kDigits[word << (6 - bits) & 63U];
  text.resize((text.size() + 3) / 4 * 4, '=');
  return text;
}

/// A file or folder name that no other test process uses; removed at the end of its scope.
class TemporaryPath {
 public:
  explicit TemporaryPath(const std::string& suffix) {
    static int counter = 0;
    path_ = testing::TempDir() + "grtx_reader_" + std::to_string(::getpid()) + "_" + std::to_string(counter++) + suffix;
  }
  ~TemporaryPath() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryPath(const TemporaryPath&) = delete;
  TemporaryPath& operator=(const TemporaryPath&) = delete;
  const std::string& str() const { return path_; }

 private:
  std::string path_;
};

inline Scene scene_from(std::string_view bytes, const SceneReadOptions& options = {}) {
  const TemporaryPath path(".scene");
  write_file(path.str(), bytes);
  return load_scene(path.str(), options);
}

inline std::vector<Camera> cameras_from(std::string_view bytes) {
  const TemporaryPath path(".json");
  write_file(path.str(), bytes);
  return load_cameras(path.str());
}

/// "place: rule" of the Error that `load` throws; fails the test when it throws none.
template <typename Load>
std::string error_of(const Load& load) {
  try {
    load();
  } catch (const Error& error) {
    EXPECT_FALSE(error.file().empty());
    return error.place() + ": " + error.rule();
  }
  ADD_FAILURE() << "no Error was thrown";
  return "";
}

inline std::string scene_error(std::string_view bytes) {
  return error_of([bytes] { scene_from(bytes); });
}

inline std::string camera_error(std::string_view bytes) {
  return error_of([bytes] { cameras_from(bytes); });
}

inline void expect_same_scene(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.rotation, b.rotation);
  EXPECT_EQ(a.opacity, b.opacity);
  EXPECT_EQ(a.sh, b.sh);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.report.dropped, b.report.dropped);
  EXPECT_EQ(a.report.clamped, b.report.clamped);
}

/// Centre of Gaussian i in the file's coordinates.
inline glm::dvec3 centre_of(const Scene& scene, std::size_t i) { return glm::dvec3(scene.mean[i]) + scene.offset; }

}  // namespace grtx::frontend::test
