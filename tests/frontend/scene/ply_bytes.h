// SPDX-License-Identifier: Apache-2.0
// A table of Gaussians that can be written as .ply in every encoding, property order and type.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "frontend/scene/scene_bytes.h"

namespace grtx::frontend::test {

/// Property names, and a row of values per Gaussian.
struct PlyTable {
  std::vector<std::string> names;
  std::vector<std::vector<float>> rows;
};

/// Names in the INRIA order, with normals.
inline std::vector<std::string> inria_names(unsigned f_rest) {
  std::vector<std::string> names{"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (unsigned i = 0; i < f_rest; ++i) names.push_back("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    names.push_back(name);
  }
  return names;
}

/// Distinct, harmless values that are no round numbers.
inline PlyTable sample_table(unsigned f_rest, std::size_t rows) {
  PlyTable table{inria_names(f_rest), {}};
  for (std::size_t row = 0; row < rows; ++row) {
    std::vector<float> values;
    for (std::size_t column = 0; column < table.names.size(); ++column) {
      values.push_back(
          static_cast<float>(std::sin(1.0 + 0.7 * static_cast<double>(column) + 3.1 * static_cast<double>(row))));
    }
    table.rows.push_back(values);
  }
  return table;
}

inline std::string ply_header(const std::string& format, const PlyTable& table, const std::string& newline = "\n") {
  std::string text = "ply" + newline + "format " + format + " 1.0" + newline + "comment made by a test" + newline +
                     fmt::format("element vertex {}", table.rows.size()) + newline;
  for (const std::string& name : table.names) text += "property float " + name + newline;
  return text + "end_header" + newline;
}

inline std::string binary_ply(const PlyTable& table, const std::string& newline = "\n") {
  Bytes bytes;
  bytes.text(ply_header("binary_little_endian", table, newline));
  for (const auto& row : table.rows) {
    for (const float value : row) bytes.add(value);
  }
  return bytes.str();
}

/// One Gaussian at the origin: scale 1, identity rotation, opacity 0.5, SH degree 0; then the named values are changed.
inline PlyTable one_row(const std::map<std::string, float>& changes) {
  PlyTable table{inria_names(0), {}};
  std::vector<float> row;
  for (const std::string& name : table.names) {
    const auto change = changes.find(name);
    row.push_back(change != changes.end() ? change->second : name == "rot_0" ? 1.0f : 0.0f);
  }
  table.rows.push_back(row);
  return table;
}

}  // namespace grtx::frontend::test
