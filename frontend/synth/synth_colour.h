// Spherical-harmonics colours of generated Gaussians.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/frontend/synth/synth_ply.h"
#include "grtx/frontend/synth/synth_random.h"

namespace grtx::frontend {

struct SynthColourNoise {
  std::uint64_t seed = 0;
  unsigned degree = 0;
  std::array<double, 4> rms{};  ///< noise of f_dc, rms of the coefficients of bands 1, 2, 3
};

/// Fills row.sh: random coefficients of the given rms, partly common to all Gaussians of `object`, and f_dc such that
/// the colour seen along `view` (unit, from the eye) is nearly `colour`: training fits the sum, not the single
/// coefficients.
void colour_row(SynthRow& row, const SynthColourNoise& noise, glm::dvec3 colour, const glm::dvec3& view,
                std::uint64_t object, SynthRandom& random);

}  // namespace grtx::frontend
