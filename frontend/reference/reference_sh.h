// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics of degrees 0 to 4 in double precision, in the order and signs of 3DGS files.
#pragma once

#include <glm/vec3.hpp>

namespace grtx::frontend {

/// max(sum of basis * coefficient + 0.5, 0) per channel. `sh`: (degree + 1)^2 coefficients, r g b inner. `d`:
/// direction, taken as unit length. Constants as in diff-gaussian-rasterization; degree 4 as in spz files.
glm::dvec3 reference_colour(const float* sh, unsigned degree, const glm::dvec3& d);

}  // namespace grtx::frontend
