// SPDX-License-Identifier: Apache-2.0
// The reference's own description of the proxies in the sigma-normalised local frame: pairs of parallel planes. Built
// from the solids' geometry alone, so that it shares nothing with the tracer's tables.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/reference/reference.h"

namespace grtx::frontend {

/// The points x with |normal . x| <= distance: a face and the opposite face of a centrally symmetric solid.
struct ReferenceSlab {
  glm::dvec3 normal;  ///< unit
  double distance;    ///< in units of the solid's inscribed radius, >= 1
};

/// 10 slabs for the icosahedron, 40 for the icosphere (two face classes), none for the sphere.
/// Vertices lie at the cyclic permutations of (0, +-1, +-phi), the solid's pose in 3DGRT.
std::vector<ReferenceSlab> reference_slabs(ReferenceProxy proxy);

/// Largest distance of a vertex from the centre in units of the inscribed radius; 1 for the sphere.
double reference_circumradius(ReferenceProxy proxy);

}  // namespace grtx::frontend
