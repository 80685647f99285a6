#include "grtx/frontend/synth/synth_colour.h"

#include <algorithm>

namespace grtx::frontend {
namespace {

constexpr std::uint64_t kTintStream = 2;
constexpr double kBand0 = 0.28209479177387814;
constexpr double kFitted = 0.85;  // share of the view-dependent part that f_dc makes up for

/// Real spherical harmonics of bands 0 to 3, signs as in 3DGS files.
std::array<double, 16> basis(const glm::dvec3& d) {
  const double x = d.x;
  const double y = d.y;
  const double z = d.z;
  return {kBand0,
          -0.4886025119029199 * y,
          0.4886025119029199 * z,
          -0.4886025119029199 * x,
          1.0925484305920792 * x * y,
          -1.0925484305920792 * y * z,
          0.31539156525252005 * (2.0 * z * z - x * x - y * y),
          -1.0925484305920792 * x * z,
          0.5462742152960396 * (x * x - y * y),
          -0.5900435899266435 * y * (3.0 * x * x - y * y),
          2.890611442640554 * x * y * z,
          -0.4570457994644658 * y * (4.0 * z * z - x * x - y * y),
          0.3731763325901154 * z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y),
          -0.4570457994644658 * x * (4.0 * z * z - x * x - y * y),
          1.445305721320277 * z * (x * x - y * y),
          -0.5900435899266435 * x * (x * x - 3.0 * y * y)};
}

}  // namespace

void colour_row(SynthRow& row, const SynthColourNoise& noise, glm::dvec3 colour, const glm::dvec3& view,
                std::uint64_t object, SynthRandom& random) {
  const std::array<double, 16> y = basis(view);
  SynthRandom tint(noise.seed, kTintStream, object);
  const unsigned coefficients = (noise.degree + 1) * (noise.degree + 1);
  glm::dvec3 seen(0.0);
  for (unsigned k = 1; k < coefficients; ++k) {
    const double rms = noise.rms[k < 4 ? 1 : k < 9 ? 2 : 3];
    // An eighth of the variance is the object's gloss; the rest differs between Gaussians. Both mostly grey.
    const double shared_grey = 0.35 * tint.normal();
    const double own_grey = 0.85 * random.normal();
    for (unsigned c = 0; c < 3; ++c) {
      const double value = rms * (shared_grey + 0.05 * tint.normal() + own_grey + 0.38 * random.normal());
      row.sh[3 * k + c] = static_cast<float>(value);
      seen[static_cast<int>(c)] += y[k] * value;
    }
  }
  const double grey = random.normal();
  for (unsigned c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    const double wanted = std::clamp(colour[channel], 0.0, 1.0) - 0.5 - kFitted * seen[channel];
    row.sh[c] = static_cast<float>(wanted / kBand0 + noise.rms[0] * (0.85 * grey + 0.5 * random.normal()));
  }
}

}  // namespace grtx::frontend
