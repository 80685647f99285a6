// From a file's raw rows to a Scene: the activation, dropping, clamping and recentring rules, shared by all readers.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

/// Parameters as an INRIA .ply stores them, one entry a row. Readers of other formats convert to this.
struct RawRows {
  std::vector<double> x, y, z;
  std::vector<float> log_scale;      ///< 3 a row, natural logarithm
  std::vector<float> rotation;       ///< 4 a row: w x y z, any norm
  std::vector<float> opacity_logit;  ///< 1 a row
  std::vector<float> sh;             ///< coefficient-major, r g b inner, (degree + 1)^2 * 3 a row
  unsigned sh_degree = 0;
  std::map<std::string, std::uint64_t> noticed;  ///< by the reader; passed on to the scene's report

  /// To n rows of sh_degree.
  void resize(std::size_t n);
  /// Throws Error when so many more rows of sh_degree, and the scene that is made of all, would take more memory than
  /// is free. For formats that compress: the size of their files says little.
  void require_memory_for(std::size_t more, const std::string& file) const;
};

/// Applies the rules of docs/model/numerics.md (drop non-finite rows, zero quaternions, opacity -inf; clamp tiny scales
/// ...), counting each by reason in the scene's report. Recentres on the component-wise median of the kept centres.
Scene make_scene(const RawRows& rows, std::string name, std::string hash);

}  // namespace grtx::frontend
