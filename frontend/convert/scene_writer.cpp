// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/convert/scene_writer.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/convert/writable_rows.h"
#include "grtx/frontend/scene/ply_writer.h"
#include "grtx/frontend/scene/readers.h"

namespace grtx::frontend {
namespace {

constexpr unsigned kMostDegree = 3;  // that readers of these formats accept

bool is_finite(const RawRows& rows, std::size_t i, std::size_t harmonics) {
  const auto finite = [](const float* values, std::size_t count) {
    return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
  };
  return std::isfinite(rows.x[i]) && std::isfinite(rows.y[i]) && std::isfinite(rows.z[i]) &&
         !std::isnan(rows.opacity_logit[i]) && finite(&rows.log_scale[i * 3], 3) && finite(&rows.rotation[i * 4], 4) &&
         finite(&rows.sh[i * harmonics], harmonics);
}

char byte_of(double value) {
  return static_cast<char>(static_cast<unsigned char>(std::clamp(std::nearbyint(value), 0.0, 255.0)));
}

template <typename T>
void add(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// Bits 31-30 name the largest of x, y, z, w, which is positive; the others follow in that order, ten bits each: sign,
/// magnitude / sqrt(1/2).
std::uint32_t smallest_three(std::array<double, 4> xyzw) {
  const double norm = std::hypot(std::hypot(xyzw[0], xyzw[1]), std::hypot(xyzw[2], xyzw[3]));
  const auto by_magnitude = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto largest =
      static_cast<std::size_t>(std::max_element(xyzw.begin(), xyzw.end(), by_magnitude) - xyzw.begin());
  const double sign = xyzw[largest] < 0.0 ? -1.0 : 1.0;
  auto bits = static_cast<std::uint32_t>(largest);
  for (std::size_t c = 0; c < 4; ++c) {
    if (c == largest) continue;
    const double value = norm > 0.0 ? sign * xyzw[c] / norm : 0.0;
    const auto magnitude =
        static_cast<std::uint32_t>(std::min(511.0, std::nearbyint(std::abs(value) * std::numbers::sqrt2 * 511.0)));
    bits = bits << 10 | (value < 0.0 ? 512U : 0U) | magnitude;
  }
  return bits;
}

std::string gzip(const std::string& plain, const std::string& path) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw Error(path, "", "cannot start to compress it: no memory");
  }
  std::string packed;
  std::string piece(1 << 20, '\0');
  std::size_t fed = 0;
  int status = Z_OK;
  while (status != Z_STREAM_END) {
    if (stream.avail_in == 0 && fed < plain.size()) {
      const std::size_t size = std::min<std::size_t>(plain.size() - fed, std::numeric_limits<uInt>::max());
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data() + fed));
      stream.avail_in = static_cast<uInt>(size);
      fed += size;
    }
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    status = deflate(&stream, fed == plain.size() ? Z_FINISH : Z_NO_FLUSH);
    packed.append(piece.data(), piece.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  return packed;
}

}  // namespace

std::size_t harmonics_of(const RawRows& rows, const std::string& path) {
  if (rows.sh_degree > kMostDegree) throw Error(path, "SH degree", "must be at most 3 to be written");
  return std::size_t{rows.sh_degree + 1} * (rows.sh_degree + 1) * 3;
}

std::vector<std::size_t> writable_rows(const RawRows& rows, std::size_t harmonics) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rows.x.size(); ++i) {
    if (is_finite(rows, i, harmonics)) kept.push_back(i);
  }
  return kept;
}

void write_ply(const RawRows& rows, const std::string& path) {
  const std::size_t harmonics = harmonics_of(rows, path);
  PlyWriter file(path, rows.x.size(), rows.sh_degree);
  for (std::size_t i = 0; i < rows.x.size(); ++i) {
    PlyRow row;
    row.position = {static_cast<float>(rows.x[i]), static_cast<float>(rows.y[i]), static_cast<float>(rows.z[i])};
    std::copy_n(&rows.log_scale[i * 3], 3, row.log_scale.begin());
    std::copy_n(&rows.rotation[i * 4], 4, row.rotation.begin());
    row.opacity_logit = rows.opacity_logit[i];
    std::copy_n(&rows.sh[i * harmonics], harmonics, row.sh.begin());
    file.add(row);
  }
  file.commit();
}

std::uint64_t write_spz(const RawRows& rows, const std::string& path) {
  const std::size_t harmonics = harmonics_of(rows, path);
  const std::vector<std::size_t> kept = writable_rows(rows, harmonics);
  double largest = 0.0;
  for (const std::size_t i : kept) {
    largest = std::max({largest, std::abs(rows.x[i]), std::abs(rows.y[i]), std::abs(rows.z[i])});
  }
  constexpr double kSteps = 8388607.0;  // 2^23 - 1
  int bits = 12;
  while (bits > 0 && std::ldexp(largest, bits) > kSteps) --bits;
  if (largest > kSteps) throw Error(path, "position", "must be at most 2^23 to be written as .spz");

  std::string plain;
  add<std::uint32_t>(plain, 0x5053474e);
  add<std::uint32_t>(plain, 3);
  add(plain, static_cast<std::uint32_t>(kept.size()));
  plain += {static_cast<char>(rows.sh_degree), static_cast<char>(bits), 0, 0};
  for (const std::size_t i : kept) {
    for (const double value : {rows.x[i], -rows.y[i], -rows.z[i]}) {  // right, up, back
      const auto steps = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::nearbyint(std::ldexp(value, bits))));
      for (const unsigned shift : {0U, 8U, 16U}) plain += static_cast<char>(steps >> shift & 255U);
    }
  }
  for (const std::size_t i : kept)
    plain += byte_of(255.0 / (1.0 + std::exp(-static_cast<double>(rows.opacity_logit[i]))));
  for (const std::size_t i : kept) {
    for (std::size_t c = 0; c < 3; ++c)
      plain += byte_of((static_cast<double>(rows.sh[i * harmonics + c]) * 0.15 + 0.5) * 255.0);
  }
  for (const std::size_t i : kept) {
    for (std::size_t c = 0; c < 3; ++c)
      plain += byte_of((static_cast<double>(rows.log_scale[i * 3 + c]) + 10.0) * 16.0);
  }
  for (const std::size_t i : kept) {
    const float* wxyz = &rows.rotation[i * 4];
    add(plain, smallest_three({wxyz[1], -static_cast<double>(wxyz[2]), -static_cast<double>(wxyz[3]), wxyz[0]}));
  }
  for (const std::size_t i : kept) {
    for (std::size_t k = 3; k < harmonics; ++k) {
      const double sign = static_cast<double>(kSpzShSign[k / 3 - 1]);
      plain += byte_of(sign * static_cast<double>(rows.sh[i * harmonics + k]) * 128.0 + 128.0);
    }
  }
  write_file(path, gzip(plain, path));
  return rows.x.size() - kept.size();
}

}  // namespace grtx::frontend
