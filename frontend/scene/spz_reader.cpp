// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/readers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/free_memory.h"
#include "grtx/frontend/scene/decompress.h"
#include "grtx/frontend/scene/raw_encoding.h"

namespace grtx::frontend {
namespace {

constexpr std::uint32_t kMagic = 0x5053474e;  // "NGSP"
constexpr std::size_t kGzipHeaderBytes = 16;  // versions 1 to 3, inside the gzip stream
constexpr std::size_t kZstdHeaderBytes = 32;  // version 4, plain
constexpr unsigned kHasExtensions = 2;        // flag
constexpr unsigned kAntialiased = 1;          // flag

// Blocks of one attribute each, in file order.
enum SpzBlock : std::size_t { positions, alphas, colours, scales, rotations, harmonics };
constexpr std::size_t kBlocks = 6;

struct Header {
  std::uint32_t version = 0;
  std::uint32_t points = 0;
  unsigned sh_degree = 0;
  int fractional_bits = 0;
  unsigned flags = 0;

  std::size_t sh_coefficients() const { return (sh_degree + 1) * (sh_degree + 1) - 1; }  // without the constant
  std::array<std::size_t, kBlocks> bytes_per_point() const {
    return {version == 1 ? std::size_t{6} : std::size_t{9},
            1,
            3,
            3,
            version <= 2 ? std::size_t{3} : std::size_t{4},
            3 * sh_coefficients()};
  }
};

unsigned byte_at(std::string_view bytes, std::size_t at) { return static_cast<unsigned char>(bytes[at]); }

// The 16 bytes that all versions share. Precondition: at least 16 bytes.
Header parse_header(std::string_view bytes, const std::string& file) {
  Header header;
  header.version = load<std::uint32_t>(bytes, 4);
  header.points = load<std::uint32_t>(bytes, 8);
  header.sh_degree = byte_at(bytes, 12);
  header.fractional_bits = static_cast<int>(byte_at(bytes, 13));
  header.flags = byte_at(bytes, 14);
  if (header.sh_degree > 4) {
    throw Error(file, "header byte 12", "the SH degree must be 0 to 4, not " + std::to_string(header.sh_degree));
  }
  if ((header.flags & kHasExtensions) != 0) {
    throw Error(file, "header byte 14", "files with extensions are not supported: they may use other axes");
  }
  return header;
}

// 24 bits, least significant byte first, two's complement.
std::int32_t load_i24(std::string_view bytes, std::size_t at) {
  const std::uint32_t bits = byte_at(bytes, at) | byte_at(bytes, at + 1) << 8 | byte_at(bytes, at + 2) << 16;
  return static_cast<std::int32_t>(bits << 8) >> 8;
}

// Versions 1 and 2: x, y, z as bytes; w completes the norm to 1.
std::array<double, 4> rotation_from_xyz(std::string_view block, std::size_t point) {
  std::array<double, 4> wxyz{};
  double squares = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    wxyz[c + 1] = byte_at(block, point * 3 + c) / 127.5 - 1.0;
    squares += wxyz[c + 1] * wxyz[c + 1];
  }
  wxyz[0] = std::sqrt(std::max(0.0, 1.0 - squares));
  return wxyz;
}

// Versions 3 and 4: bits 31-30 name the largest component in the order x, y, z, w; the other three in ascending order,
// the last in the lowest 10 bits, each a sign (bit 9) and a magnitude of 9 bits.
std::array<double, 4> rotation_from_smallest_three(std::string_view block, std::size_t point) {
  std::uint32_t bits = load<std::uint32_t>(block, point * 4);
  const std::size_t largest = bits >> 30;
  std::array<double, 4> xyzw{};
  double squares = 0.0;
  for (std::size_t c = 4; c-- > 0;) {
    if (c == largest) continue;
    const double magnitude = (bits & 511) / 511.0 * (0.5 * std::numbers::sqrt2);
    xyzw[c] = (bits & 512) != 0 ? -magnitude : magnitude;
    squares += magnitude * magnitude;
    bits >>= 10;
  }
  xyzw[largest] = std::sqrt(std::max(0.0, 1.0 - squares));
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

RawRows decode(const Header& header, const std::array<std::string_view, kBlocks>& blocks, bool raw_axes,
               const std::string& file) {
  const std::size_t n = header.points;
  const std::size_t coefficients = header.sh_coefficients() + 1;
  const float flip = raw_axes ? 1.0f : -1.0f;  // right, up, back to right, down, forward: y and z change sign
  RawRows rows;
  rows.sh_degree = header.sh_degree;
  rows.require_memory_for(n, file);
  rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, 3> position{};
    for (std::size_t c = 0; c < 3; ++c) {
      position[c] = header.version == 1
                        ? half_to_double(load<std::uint16_t>(blocks[positions], (i * 3 + c) * 2))
                        : std::ldexp(load_i24(blocks[positions], (i * 3 + c) * 3), -header.fractional_bits);
    }
    rows.x[i] = position[0];
    rows.y[i] = static_cast<double>(flip) * position[1];
    rows.z[i] = static_cast<double>(flip) * position[2];
    rows.opacity_logit[i] = logit_of(byte_at(blocks[alphas], i) / 255.0);
    for (std::size_t c = 0; c < 3; ++c) {
      rows.sh[i * coefficients * 3 + c] =
          static_cast<float>((byte_at(blocks[colours], i * 3 + c) / 255.0 - 0.5) / 0.15);
      rows.log_scale[i * 3 + c] = static_cast<float>(byte_at(blocks[scales], i * 3 + c)) / 16.0f - 10.0f;
    }
    const std::array<double, 4> q = header.version <= 2 ? rotation_from_xyz(blocks[rotations], i)
                                                        : rotation_from_smallest_three(blocks[rotations], i);
    for (std::size_t c = 0; c < 4; ++c) rows.rotation[i * 4 + c] = static_cast<float>(q[c]) * (c >= 2 ? flip : 1.0f);
    for (std::size_t j = 1; j < coefficients; ++j) {
      const float sign = raw_axes ? 1.0f : kSpzShSign[j - 1];
      for (std::size_t c = 0; c < 3; ++c) {
        const unsigned byte = byte_at(blocks[harmonics], (i * (coefficients - 1) + j - 1) * 3 + c);
        rows.sh[(i * coefficients + j) * 3 + c] = sign * (static_cast<float>(byte) - 128.0f) / 128.0f;
      }
    }
  }
  if ((header.flags & kAntialiased) != 0) rows.noticed["trained with an anti-aliasing filter (header flag)"] = n;
  return rows;
}

RawRows read_gzip_version(std::string_view bytes, bool raw_axes, const std::string& file) {
  const std::string head = inflate_gzip(bytes, kGzipHeaderBytes, file);
  if (head.size() < kGzipHeaderBytes || load<std::uint32_t>(head, 0) != kMagic) {
    throw Error(file, "inflated byte 0", "must be \"NGSP\": a gzip file that is no .spz");
  }
  const std::uint32_t version = load<std::uint32_t>(head, 4);
  if (version < 1 || version > 3) {
    throw Error(file, "inflated byte 4", "a gzip .spz must be of version 1, 2 or 3, not " + std::to_string(version));
  }
  const Header header = parse_header(head, file);
  std::array<std::string_view, kBlocks> blocks;
  const std::array<std::size_t, kBlocks> per_point = header.bytes_per_point();
  std::size_t total = kGzipHeaderBytes;
  for (const std::size_t size : per_point) total += size * header.points;
  require_memory(std::min(total, bytes.size() * kMostInflation), file, "");
  const std::string plain = inflate_gzip(bytes, total + 1, file);
  if (plain.size() != total) {
    throw Error(file, "inflated byte " + std::to_string(std::min(plain.size(), total)),
                std::to_string(header.points) + " points of SH degree " + std::to_string(header.sh_degree) +
                    " must end at byte " + std::to_string(total));
  }
  std::size_t at = kGzipHeaderBytes;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    blocks[b] = std::string_view(plain).substr(at, per_point[b] * header.points);
    at += blocks[b].size();
  }
  return decode(header, blocks, raw_axes, file);
}

RawRows read_zstd_version(std::string_view bytes, bool raw_axes, const std::string& file) {
  if (bytes.size() < kZstdHeaderBytes)
    throw Error(file, "byte " + std::to_string(bytes.size()), "the file ends within its header");
  const std::uint32_t version = load<std::uint32_t>(bytes, 4);
  if (version != 4) throw Error(file, "byte 4", "a plain .spz must be of version 4, not " + std::to_string(version));
  const Header header = parse_header(bytes, file);
  const std::array<std::size_t, kBlocks> per_point = header.bytes_per_point();
  std::vector<std::size_t> present;  // empty streams are left out
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (per_point[b] * header.points > 0) present.push_back(b);
  }
  const std::size_t streams = byte_at(bytes, 15);
  if (streams != present.size()) {
    throw Error(file, "byte 15",
                "must be " + std::to_string(present.size()) + " streams, not " + std::to_string(streams));
  }
  constexpr std::size_t kEntryBytes = 16;  // u64 compressed size, u64 plain size
  const std::size_t table = load<std::uint32_t>(bytes, 16);
  if (table < kZstdHeaderBytes || table > bytes.size() || bytes.size() - table < streams * kEntryBytes) {
    throw Error(file, "byte 16", "the table of streams must lie behind the header and within the file");
  }
  std::array<std::string, kBlocks> plain;
  std::size_t at = table + streams * kEntryBytes;
  for (std::size_t s = 0; s < streams; ++s) {
    const std::size_t entry = table + s * kEntryBytes;
    const std::uint64_t compressed = load<std::uint64_t>(bytes, entry);
    const std::size_t expected = per_point[present[s]] * header.points;
    if (load<std::uint64_t>(bytes, entry + 8) != expected) {
      throw Error(file, "byte " + std::to_string(entry + 8),
                  "the stream's plain size must be " + std::to_string(expected));
    }
    if (compressed > bytes.size() - at) {
      throw Error(file, "byte " + std::to_string(entry), "the stream must end within the file");
    }
    plain[present[s]] = inflate_zstd(bytes.substr(at, static_cast<std::size_t>(compressed)), expected, at, file);
    at += static_cast<std::size_t>(compressed);
  }
  if (at != bytes.size()) throw Error(file, "byte " + std::to_string(at), "the file must end with its last stream");
  std::array<std::string_view, kBlocks> blocks;
  for (std::size_t b = 0; b < kBlocks; ++b) blocks[b] = plain[b];
  return decode(header, blocks, raw_axes, file);
}

}  // namespace

bool is_spz(std::string_view bytes) {
  return bytes.starts_with("\x1f\x8b") || (bytes.size() >= 4 && load<std::uint32_t>(bytes, 0) == kMagic);
}

RawRows read_spz(std::string_view bytes, bool raw_axes, const std::string& file) {
  return bytes.starts_with("\x1f\x8b") ? read_gzip_version(bytes, raw_axes, file)
                                       : read_zstd_version(bytes, raw_axes, file);
}

}  // namespace grtx::frontend
