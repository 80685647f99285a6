// SPDX-License-Identifier: Apache-2.0
// double -> float -> double that really rounds. From -O2 on, GCC 12's basic-block vectoriser drops both conversions
// where two neighbours are converted (-fno-tree-slp-vectorize prevents it), so the obvious expression may not round.
#pragma once

#include <glm/vec3.hpp>

namespace grtx::frontend {

/// The float nearest to `value`, as a double.
inline double round_to_float(double value) {
  volatile float narrow = static_cast<float>(value);  // a store that no optimisation may drop
  return static_cast<double>(narrow);
}

inline glm::dvec3 round_to_float(const glm::dvec3& v) {
  return {round_to_float(v.x), round_to_float(v.y), round_to_float(v.z)};
}

}  // namespace grtx::frontend
