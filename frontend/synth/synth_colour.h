// SPDX-License-Identifier: Apache-2.0
// Spherical-harmonics colours of generated Gaussians.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "grtx/frontend/numbers/counter_random.h"
#include "grtx/frontend/scene/ply_writer.h"

namespace grtx::frontend {

struct SynthColourNoise {
  std::uint64_t seed = 0;
  unsigned degree = 0;
  std::array<double, 4> rms{};  ///< noise of f_dc, rms of the coefficients of bands 1, 2, 3
};

/// Fills row.sh: random coefficients of the given rms, partly common to all Gaussians of `object`, such that each of
/// `views` (unit, from the eyes that see it, nearest first; at least one) sees nearly `colour`: training fits what the
/// cameras see, not single coefficients. A degree can fit as many views as it has coefficients besides f_dc.
void colour_row(PlyRow& row, const SynthColourNoise& noise, const glm::dvec3& colour, std::span<const glm::dvec3> views,
                std::uint64_t object, CounterRandom& random);

}  // namespace grtx::frontend
