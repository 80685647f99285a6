// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/compressed_ply_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/frontend/scene/ply_elements.h"
#include "grtx/frontend/scene/ply_reader.h"
#include "grtx/frontend/scene/raw_encoding.h"

namespace grtx::frontend {
namespace {

constexpr std::size_t kChunkRows = 256;

// A chunk's numbers, in this order; old writers omit the colour limits.
constexpr std::array<const char*, 18> kChunkNames{
    "min_x",       "min_y",       "min_z",       "max_x", "max_y", "max_z", "min_scale_x", "min_scale_y", "min_scale_z",
    "max_scale_x", "max_scale_y", "max_scale_z", "min_r", "min_g", "min_b", "max_r",       "max_g",       "max_b"};
constexpr std::size_t kPositionLimits = 0, kScaleLimits = 6, kColourLimits = 12;

// The value of `bits` bits of `word` from bit `low` on, as 0 .. 1.
double unorm(std::uint32_t word, unsigned low, unsigned bits) {
  const std::uint32_t mask = (1u << bits) - 1u;
  return static_cast<double>((word >> low) & mask) / static_cast<double>(mask);
}

// Three numbers in 11, 10 and 11 bits, the first in the highest.
std::array<double, 3> unpack_11_10_11(std::uint32_t word) {
  return {unorm(word, 21, 11), unorm(word, 11, 10), unorm(word, 0, 11)};
}

// Between min and max of one axis; `limits` points at three minima followed by three maxima.
double between(const float* limits, std::size_t axis, double t) {
  return static_cast<double>(limits[axis]) * (1.0 - t) + static_cast<double>(limits[axis + 3]) * t;
}

// Bits 31-30 name the omitted component (0 = w); the others follow in ascending order with 10 bits each.
void unpack_rotation(std::uint32_t word, float* wxyz) {
  const std::size_t omitted = word >> 30;
  double squares = 0.0;
  unsigned low = 20;
  for (std::size_t c = 0; c < 4; ++c) {
    if (c == omitted) continue;
    const double value = (unorm(word, low, 10) - 0.5) * std::numbers::sqrt2;
    wxyz[c] = static_cast<float>(value);
    squares += value * value;
    low -= 10;
  }
  wxyz[omitted] = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - squares)));
}

double sh_value(std::uint32_t byte) {
  const double n = byte == 0 ? 0.0 : byte == 255 ? 1.0 : (byte + 0.5) / 256.0;
  return (n - 0.5) * 8.0;
}

std::size_t required_integer(const PlyElement& element, const std::string& property, const std::string& file) {
  const std::size_t index = required_property(element, property, file);
  if (!is_integer(element.properties[index].type)) {
    throw Error(file, "element \"" + element.name + "\"", "property \"" + property + "\" must be of an integer type");
  }
  return index;
}

void require_rows(const PlyElement& element, std::uint64_t rows, const std::string& file) {
  if (element.rows == rows) return;
  throw Error(file, "element \"" + element.name + "\"",
              "must have " + std::to_string(rows) + " rows, not " + std::to_string(element.rows));
}

void read_sh(const PlyHeader& header, std::size_t index, const PlyElements& elements, const std::string& file,
             RawRows& rows) {
  const PlyElement& element = header.elements[index];
  std::vector<PlyColumn> columns;
  append_sh_columns(element, rows.sh_degree, rows.sh.data(), columns);
  for (const PlyColumn& column : columns) required_integer(element, element.properties[column.property].name, file);
  elements.read(index, columns);
  const std::size_t stride = std::size_t{3} * (rows.sh_degree + 1) * (rows.sh_degree + 1);
  for (std::size_t i = 0; i < rows.sh.size(); ++i) {
    if (i % stride < 3) continue;  // the constant term comes from the packed colour
    if (rows.sh[i] < 0.0f || rows.sh[i] > 255.0f) {
      throw Error(file, "element \"sh\", row " + std::to_string(i / stride), "must hold bytes, 0 to 255");
    }
    rows.sh[i] = static_cast<float>(sh_value(static_cast<std::uint32_t>(rows.sh[i])));
  }
}

}  // namespace

bool is_compressed_ply(const PlyHeader& header) {
  const auto vertex = header.find("vertex");
  return header.find("chunk") && vertex && header.elements[*vertex].find("packed_position");
}

RawRows read_compressed_ply(std::string_view bytes, const PlyHeader& header, const std::string& file) {
  const std::size_t chunk_index = *header.find("chunk"), vertex_index = *header.find("vertex");
  const PlyElement& chunk = header.elements[chunk_index];
  const PlyElement& vertex = header.elements[vertex_index];
  const std::size_t limits = chunk.find("min_r") ? kChunkNames.size() : kColourLimits;  // numbers per chunk
  std::vector<PlyColumn> chunk_columns, vertex_columns;
  for (std::size_t i = 0; i < limits; ++i) chunk_columns.push_back({required_property(chunk, kChunkNames[i], file)});
  for (const char* name : {"packed_position", "packed_rotation", "packed_scale", "packed_color"}) {
    vertex_columns.push_back({required_integer(vertex, name, file)});
  }
  const auto sh_index = header.find("sh");
  const unsigned degree = sh_index ? sh_degree_of(header.elements[*sh_index], file) : 0;
  const PlyElements elements(bytes, header, file);  // checks the row counts against the file's size
  require_rows(chunk, vertex.rows / kChunkRows + (vertex.rows % kChunkRows != 0), file);
  if (sh_index) require_rows(header.elements[*sh_index], vertex.rows, file);

  RawRows rows;
  rows.sh_degree = degree;
  if (elements.trailing_bytes() > 0) rows.noticed["bytes behind the last element"] = elements.trailing_bytes();
  if (vertex.rows == 0) return rows;
  const std::size_t n = static_cast<std::size_t>(vertex.rows);
  std::vector<float> chunks(static_cast<std::size_t>(chunk.rows) * limits);
  for (std::size_t i = 0; i < limits; ++i) {
    chunk_columns[i].out = chunks.data() + i;
    chunk_columns[i].stride = limits;
  }
  elements.read(chunk_index, chunk_columns);
  std::vector<std::uint32_t> packed(n * 4);
  for (std::size_t i = 0; i < 4; ++i) {
    vertex_columns[i].out = packed.data() + i;
    vertex_columns[i].stride = 4;
  }
  elements.read(vertex_index, vertex_columns);

  const std::size_t sh_stride = std::size_t{3} * (degree + 1) * (degree + 1);
  rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float* limit = &chunks[i / kChunkRows * limits];
    const std::uint32_t* word = &packed[i * 4];
    const std::array<double, 3> position = unpack_11_10_11(word[0]), scale = unpack_11_10_11(word[2]);
    rows.x[i] = between(limit + kPositionLimits, 0, position[0]);
    rows.y[i] = between(limit + kPositionLimits, 1, position[1]);
    rows.z[i] = between(limit + kPositionLimits, 2, position[2]);
    unpack_rotation(word[1], &rows.rotation[i * 4]);
    for (std::size_t c = 0; c < 3; ++c) {
      rows.log_scale[i * 3 + c] = static_cast<float>(between(limit + kScaleLimits, c, scale[c]));
      double colour = unorm(word[3], static_cast<unsigned>(24 - 8 * c), 8);
      if (limits > kColourLimits) colour = between(limit + kColourLimits, c, colour);
      rows.sh[i * sh_stride + c] = static_cast<float>((colour - 0.5) / kShC0);
    }
    rows.opacity_logit[i] = logit_of(unorm(word[3], 0, 8));
  }
  if (sh_index) read_sh(header, *sh_index, elements, file, rows);
  return rows;
}

}  // namespace grtx::frontend
