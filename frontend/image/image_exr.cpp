// SPDX-License-Identifier: Apache-2.0
// OpenEXR with three 32-bit float channels R, G, B. Works on memory and without OpenEXR's thread pool, so that a file's
// bytes never depend on the host.
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <new>

#include "grtx/base/error.h"
#include "grtx/frontend/image/image_formats.h"

namespace grtx::frontend {
namespace {

constexpr int kNoThreads = 0;
constexpr int kMaxExrSide = 1 << 16;  // pixels

class MemoryOut : public Imf::OStream {
 public:
  explicit MemoryOut(const char* name) : Imf::OStream(name) {}
  void write(const char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ + size > file_.size()) file_.resize(at_ + size);
    std::memcpy(file_.data() + at_, bytes, size);
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override { at_ = position; }
  std::string& file() { return file_; }

 private:
  std::string file_;
  std::size_t at_ = 0;
};

class MemoryIn : public Imf::IStream {
 public:
  MemoryIn(const char* name, const std::string& bytes) : Imf::IStream(name), bytes_(bytes) {}
  bool read(char out[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ > bytes_.size() || bytes_.size() - at_ < size)
      throw Error(fileName(), fmt::format("byte {}", at_), "ends early");
    std::memcpy(out, bytes_.data() + at_, size);
    at_ += size;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override { at_ = position; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

/// Slices that map the channels of the data window to a packed vec3 array.
Imf::FrameBuffer rgb_frame(glm::vec3* pixels, unsigned width, int min_x, int min_y) {
  const std::size_t x_stride = sizeof(glm::vec3);
  const std::size_t y_stride = x_stride * width;
  Imf::FrameBuffer frame;
  const char* names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    // OpenEXR addresses pixel (x, y) as base + x * x_stride + y * y_stride in data-window coordinates.
    char* base = reinterpret_cast<char*>(pixels) + c * sizeof(float);
    base -= static_cast<std::ptrdiff_t>(min_x) * static_cast<std::ptrdiff_t>(x_stride);
    base -= static_cast<std::ptrdiff_t>(min_y) * static_cast<std::ptrdiff_t>(y_stride);
    frame.insert(names[c], Imf::Slice(Imf::FLOAT, base, x_stride, y_stride));
  }
  return frame;
}

std::uint32_t u32_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

/// Whether an attribute's claimed size is the one that OpenEXR reads for its type ("OpenEXR File Layout", attributes).
bool has_size_of_type(const std::string& type, const std::string& value) {
  static const std::map<std::string, std::size_t> sizes = {{"box2i", 16},
                                                           {"box2f", 16},
                                                           {"v2i", 8},
                                                           {"v2f", 8},
                                                           {"v2d", 16},
                                                           {"v3i", 12},
                                                           {"v3f", 12},
                                                           {"v3d", 24},
                                                           {"int", 4},
                                                           {"float", 4},
                                                           {"double", 8},
                                                           {"m33f", 36},
                                                           {"m33d", 72},
                                                           {"m44f", 64},
                                                           {"m44d", 128},
                                                           {"rational", 8},
                                                           {"envmap", 1},
                                                           {"keycode", 28},
                                                           {"timecode", 8},
                                                           {"tiledesc", 9},
                                                           {"lineOrder", 1},
                                                           {"compression", 1},
                                                           {"chromaticities", 32},
                                                           {"deepImageState", 1}};
  if (const auto known = sizes.find(type); known != sizes.end()) return value.size() == known->second;
  if (type == "preview") {  // width, height, four bytes per pixel
    return value.size() >= 8 && value.size() == 8 + 4 * std::uint64_t{u32_at(value, 0)} * u32_at(value, 4);
  }
  if (type == "chlist") {  // names, each followed by 16 bytes; an empty one ends the list
    constexpr std::size_t kOfChannel = 16;
    std::size_t at = 0;
    while (at < value.size() && value[at] != '\0') {
      const std::size_t end = value.find('\0', at);
      if (end == std::string::npos) return false;
      at = end + 1 + kOfChannel;
    }
    return at + 1 == value.size();
  }
  return true;  // texts and unknown types: read in the size that the file claims
}

/// Checks that each attribute fits in the file (name, type, size, value; an empty name ends the header), because
/// OpenEXR allocates the claimed size before it reads.
void check_attributes(const std::string& path, const std::string& bytes) {
  constexpr std::size_t kMagicAndVersion = 8;
  constexpr std::uint32_t kDeepOrSeveral = 0x1800;  // flags of the version: files with several headers
  if (bytes.size() >= kMagicAndVersion && (u32_at(bytes, 4) & kDeepOrSeveral) != 0) {
    throw Error(path, "version", "must be a file of one flat image");
  }
  std::size_t at = kMagicAndVersion;
  const auto fail = [&] { throw Error(path, fmt::format("byte {}", at), "is no attribute that fits in the file"); };
  while (at < bytes.size() && bytes[at] != '\0') {
    const std::size_t name_end = bytes.find('\0', at);
    const std::size_t type_end = name_end == std::string::npos ? name_end : bytes.find('\0', name_end + 1);
    if (type_end == std::string::npos || bytes.size() - type_end <= sizeof(std::uint32_t)) fail();
    const std::size_t value = type_end + 1 + sizeof(std::uint32_t);
    const std::uint32_t size = u32_at(bytes, type_end + 1);
    if (size > bytes.size() - value) fail();
    if (!has_size_of_type(bytes.substr(name_end + 1, type_end - name_end - 1), bytes.substr(value, size))) fail();
    at = value + size;
  }
}

Image decode(const std::string& path, const std::string& bytes) {
  check_attributes(path, bytes);
  // OpenEXR allocates line buffers when it opens a file, before a caller can check the header.
  Imf::Header::setMaxImageSize(kMaxExrSide, kMaxExrSide);
  Imf::Header::setMaxTileSize(kMaxExrSide, kMaxExrSide);
  MemoryIn stream(path.c_str(), bytes);
  Imf::InputFile file(stream, kNoThreads);
  const Imf::Header& header = file.header();
  for (const char* name : {"R", "G", "B"}) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    if (channel == nullptr || channel->xSampling != 1 || channel->ySampling != 1) {
      throw Error(path, "channels", "must hold full-resolution channels R, G and B");
    }
  }
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  const auto limit = static_cast<std::int64_t>(kMaxImagePixels);
  if (width <= 0 || height <= 0 || width > limit || height > limit / width) {
    throw Error(path, "data window", fmt::format("must have 1 to {} pixels", kMaxImagePixels));
  }
  Image image(static_cast<unsigned>(width), static_cast<unsigned>(height));
  file.setFrameBuffer(rgb_frame(image.pixels.data(), image.width, window.min.x, window.min.y));
  file.readPixels(window.min.y, window.max.y);
  return image;
}

}  // namespace

std::string encode_exr(const std::string& path, const Image& image) {
  try {
    Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const char* name : {"R", "G", "B"}) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    MemoryOut stream(path.c_str());
    {
      Imf::OutputFile file(stream, header, kNoThreads);
      Image copy = image;  // a Slice needs a non-const pointer
      file.setFrameBuffer(rgb_frame(copy.pixels.data(), image.width, 0, 0));
      file.writePixels(static_cast<int>(image.height));
    }  // the line offset table is completed by the destructor
    return std::move(stream.file());
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {  // says nothing of the file
    throw;
  } catch (const std::exception& problem) {
    throw Error(path, "", fmt::format("cannot be encoded as OpenEXR: {}", problem.what()));
  }
}

Image decode_exr(const std::string& path, const std::string& bytes) {
  try {
    return decode(path, bytes);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {  // says nothing of the file
    throw;
  } catch (const std::exception& problem) {
    throw Error(path, "", fmt::format("must be a complete OpenEXR file: {}", problem.what()));
  }
}

}  // namespace grtx::frontend
