// SPDX-License-Identifier: Apache-2.0
// From a file's raw rows to a Scene: the activation, dropping, clamping and recentring rules, shared by all readers.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

/// Parameters as an INRIA .ply stores them, row by row. Readers of other formats convert to this.
struct RawRows {
  std::vector<double> x, y, z;
  std::vector<float> log_scale;      ///< 3 per row, natural logarithm
  std::vector<float> rotation;       ///< 4 per row: w x y z, any norm
  std::vector<float> opacity_logit;  ///< 1 per row
  std::vector<float> sh;             ///< coefficient-major, r g b inner, (degree + 1)^2 * 3 per row
  unsigned sh_degree = 0;
  std::map<std::string, std::uint64_t> noticed;  ///< counts by the reader, for the scene's report

  /// Resizes to n rows of sh_degree.
  void resize(std::size_t n);
  /// Throws Error when `more` additional rows of sh_degree, and the scene made of all rows, would take more memory than
  /// is free. For compressed formats, whose file size says little.
  void require_memory_for(std::size_t more, const std::string& file) const;
};

/// Applies the rules of docs/model/numerics.md (drop non-finite rows, zero quaternions, opacity -inf; clamp tiny scales
/// ...), counting each by reason in the scene's report. Recentres on the component-wise median of the kept centres.
Scene make_scene(const RawRows& rows, std::string name, std::string hash);

}  // namespace grtx::frontend
