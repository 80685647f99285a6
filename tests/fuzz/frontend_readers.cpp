// SPDX-License-Identifier: Apache-2.0
// Readers of scenes, cameras, object lists, images and traces.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "frontend/scene/scene_bytes.h"
#include "fuzz/readers.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/convert/scene_writer.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "paths.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::fuzzing {
namespace {

namespace fs = std::filesystem;
using frontend::test::Bytes;

using Seeds = std::vector<std::string>;
Seeds one(const std::string& text) { return {text}; }

/// The converters' files of tests/data with an extension.
Seeds converted(const std::string& end) {
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(grtx::paths::source_dir() + "/tests/data/converters")) {
    const std::string path = entry.path().string();
    if (path.ends_with(end)) paths.push_back(path);
  }
  std::sort(paths.begin(), paths.end());  // a folder has no order of its own
  Seeds files;
  for (const std::string& path : paths) files.push_back(read_file(path));
  return files;
}

template <class Number>
Number number_at(const std::string& bytes, std::size_t at) {
  Number value = 0;
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

/// The .glb files of tests/data as text with their buffer inside.
Seeds gltf_texts() {
  Seeds files;
  for (const std::string& glb : converted(".glb")) {
    const std::size_t size = number_at<std::uint32_t>(glb, 12);
    nlohmann::json document = nlohmann::json::parse(glb.substr(20, size));
    document["buffers"][0]["uri"] =
        "data:application/octet-stream;base64," + frontend::test::base64(glb.substr(28 + size));
    files.push_back(document.dump());
  }
  return files;
}

/// As the 3DGS authors' program writes it, SH degree 0.
Seeds plain_ply() {
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n";
  Bytes rows;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0",
                           "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    header += std::string("property float ") + name + "\n";
    for (int i = 0; i < 3; ++i) rows.add(0.25F * static_cast<float>(i + 1));
  }
  return {header + "end_header\n" + rows.str()};
}

/// As grtx convert writes it, SH degree 1.
Seeds usda_text() {
  frontend::RawRows rows;
  rows.sh_degree = 1;
  rows.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    rows.x[i] = 0.25 * static_cast<double>(i + 1);
    rows.rotation[4 * i] = 1.0F;
  }
  const std::string path = folder() + "/seed.usda";
  (void)frontend::write_usda(rows, path);
  return {read_file(path)};
}

void put_hash(std::string& bytes, std::size_t at, std::size_t from, std::size_t count) {
  if (at + 8 > bytes.size() || from > bytes.size() || count > bytes.size() - from) return;
  const std::uint64_t hash = xxh3(bytes.data() + from, count);
  std::memcpy(&bytes[at], &hash, sizeof hash);
}

/// docs/model/trace-format.md, "File".
void repair_trace(std::string& bytes) {
  if (bytes.size() < 60) return;
  put_hash(bytes, 16, 24, number_at<std::uint32_t>(bytes, 12));
  const auto footer = number_at<std::uint64_t>(bytes, bytes.size() - 16);
  const std::size_t end = bytes.size() - 16;
  if (footer > end || end - footer < 28) return;
  const auto chunks = number_at<std::uint64_t>(bytes, footer);
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(chunks, (end - footer - 8) / 8); ++i) {
    const auto chunk = number_at<std::uint64_t>(bytes, footer + 8 + 8 * i);
    if (chunk < footer) put_hash(bytes, chunk + 4, chunk + 12, number_at<std::uint32_t>(bytes, chunk));
  }
  put_hash(bytes, end - 16, 0, end - 16);
  put_hash(bytes, end - 8, footer, end - 8 - footer);
}

std::uint32_t big_endian_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// A chunk of a PNG is a length, four letters, the data, and a CRC of the letters and the data.
void repair_png(std::string& bytes) {
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::size_t length = big_endian_at(bytes, at);
    if (length > bytes.size() - at - 12) return;
    std::uint32_t crc = 0xffffffff;
    for (std::size_t i = at + 4; i < at + 8 + length; ++i) {
      crc ^= static_cast<unsigned char>(bytes[i]);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xedb88320 & (0U - (crc & 1)));
    }
    for (unsigned i = 0; i < 4; ++i) bytes[at + 8 + length + i] = static_cast<char>(~crc >> (24 - 8 * i));
    at += 12 + length;
  }
}

std::string trace_of(bool two_level) {
  traces::testing::RandomOptions options{.seed = 3};
  options.two_level = options.checkpoint = two_level;
  options.capacity = two_level ? 1000 : 0;
  const traces::testing::RandomTrace trace = traces::testing::random_trace(options);
  const std::string path = folder() + "/seed.grtx";
  traces::testing::write_trace(path, trace.header, trace.groups);
  return read_file(path);
}

std::string image_of(const std::string& end) {
  frontend::Image image(7, 5);
  for (unsigned i = 0; i < 35; ++i) image.pixels[i] = glm::vec3(0.02f * static_cast<float>(i));
  frontend::write_image(folder() + "/seed." + end, image);
  return read_file(folder() + "/seed." + end);
}

std::string colmap_cameras() {
  Bytes cameras;
  cameras.add(std::uint64_t{1}).add(std::int32_t{7}).add(std::int32_t{1});
  cameras.add(std::uint64_t{640}).add(std::uint64_t{480});
  for (const double p : {500.0, 501.0, 320.0, 240.0}) cameras.add(p);
  return cameras.str();
}
std::string colmap_images() {
  Bytes images;
  images.add(std::uint64_t{1}).add(std::int32_t{1});
  for (const double v : {1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0}) images.add(v);
  images.add(std::int32_t{7}).text("a.png").u8(0).add(std::uint64_t{1});
  images.add(1.0).add(2.0).add(std::int64_t{-1});
  return images.str();
}

void scene(const std::string& path) { (void)frontend::load_scene(path); }
void cameras(const std::string& path) { (void)frontend::load_cameras(path); }
void image(const std::string& path) { (void)frontend::read_image(path); }
void colmap(const std::string& path) {
  const std::string own = fs::path(path).parent_path().string();
  if (!fs::exists(own + "/cameras.bin")) write_file(own + "/cameras.bin", colmap_cameras());
  if (!fs::exists(own + "/images.bin")) write_file(own + "/images.bin", colmap_images());
  (void)frontend::load_cameras(own);
}

}  // namespace

const std::vector<InputReader>& frontend_readers() {
  static const std::vector<InputReader> all = {
      {"ply", "s.ply", scene, nullptr, plain_ply},
      {"compressed_ply", "p.ply", scene, nullptr, [] { return converted(".compressed.ply"); }},
      {"splat", "s.splat", scene, nullptr, [] { return converted(".splat"); }},
      {"spz", "s.spz", scene, nullptr, [] { return converted(".spz"); }},
      {"glb", "s.glb", scene, nullptr, [] { return converted(".glb"); }},
      {"gltf", "s.gltf", scene, nullptr, gltf_texts},
      {"ksplat", "s.ksplat", scene, nullptr, [] { return converted(".ksplat"); }},
      {"usda", "s.usda", scene, nullptr, usda_text},
      {"sog", "s.sog", scene, nullptr, [] { return converted(".sog"); }},
      {"cameras_json", "cameras.json", cameras, nullptr,
       [] {
         return one(R"([{"id": 0, "img_name": "a", "width": 64, "height": 48, "position": [0.5, 1, -2], )"
                    R"("rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fy": 50.5, "fx": 50.25}])");
       }},
      {"transforms_json", "transforms.json", cameras, nullptr,
       [] {
         return one(R"({"fl_x": 50, "fl_y": 51, "cx": 32, "cy": 24, "w": 64, "h": 48, "frames": [{"file_path": )"
                    R"("a", "transform_matrix": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]})");
       }},
      {"colmap_cameras", "cameras.bin", colmap, nullptr, [] { return Seeds{colmap_cameras()}; }},
      {"colmap_images", "images.bin", colmap, nullptr, [] { return Seeds{colmap_images()}; }},
      {"object_list", "objects.json", [](const std::string& path) { (void)frontend::load_object_list(path); }, nullptr,
       [] {
         return one(R"([{"file": "a.ply", "translate": [0, 1, 2.5], "rotate": [1, 0, 0, 0], "scale": 2}, )"
                    R"({"file": "b.ply"}])");
       }},
      {"png", "i.png", image, repair_png, [] { return Seeds{image_of("png")}; }},
      {"exr", "i.exr", image, nullptr, [] { return Seeds{image_of("exr")}; }},
      {"pfm", "i.pfm", image, nullptr, [] { return Seeds{image_of("pfm")}; }},
      {"trace", "t.grtx", [](const std::string& path) { traces::check(traces::Reader(path), true); }, repair_trace,
       [] { return Seeds{trace_of(true)}; }},
      {"trace_monolithic", "m.grtx", [](const std::string& path) { traces::check(traces::Reader(path), true); },
       repair_trace, [] { return Seeds{trace_of(false)}; }},
  };
  return all;
}

}  // namespace grtx::fuzzing
