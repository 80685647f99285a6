// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/synth/synth_colour.h"

#include <algorithm>
#include <cmath>

namespace grtx::frontend {
namespace {

constexpr std::uint64_t kTintStream = 2;
constexpr double kBand0 = 0.28209479177387814;
constexpr double kFitted = 0.85;  // share of the variation between views that is removed

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

/// Directions that must not vary if all views are to see one colour: orthonormal, in the space of coefficients 1 .. n -
/// 1.
struct ViewDifferences {
  std::array<std::array<double, 16>, 15> axes{};
  unsigned count = 0;
};

/// `scale`: rms of each coefficient, so that the removal is spread over the bands as the noise is.
ViewDifferences view_differences(std::span<const glm::dvec3> views, const std::array<double, 16>& scale,
                                 unsigned coefficients) {
  ViewDifferences differences;
  const std::array<double, 16> nearest = basis(views[0]);
  for (const glm::dvec3& view : views.subspan(1)) {
    if (differences.count + 2 >= coefficients) break;  // leaves something that can vary
    std::array<double, 16> axis = basis(view);
    for (unsigned k = 1; k < coefficients; ++k) axis[k] = (axis[k] - nearest[k]) * scale[k];
    for (unsigned i = 0; i < differences.count; ++i) {
      double along = 0.0;
      for (unsigned k = 1; k < coefficients; ++k) along += differences.axes[i][k] * axis[k];
      for (unsigned k = 1; k < coefficients; ++k) axis[k] -= along * differences.axes[i][k];
    }
    double length = 0.0;
    for (unsigned k = 1; k < coefficients; ++k) length += axis[k] * axis[k];
    if (length < 1e-6) continue;  // nearly the same view
    for (unsigned k = 1; k < coefficients; ++k) differences.axes[differences.count][k] = axis[k] / std::sqrt(length);
    ++differences.count;
  }
  return differences;
}

}  // namespace

void colour_row(PlyRow& row, const SynthColourNoise& noise, const glm::dvec3& colour, std::span<const glm::dvec3> views,
                std::uint64_t object, CounterRandom& random) {
  CounterRandom tint(noise.seed, kTintStream, object);
  const unsigned coefficients = (noise.degree + 1) * (noise.degree + 1);
  std::array<double, 16> scale{};
  for (unsigned k = 1; k < coefficients; ++k) scale[k] = noise.rms[k < 4 ? 1 : k < 9 ? 2 : 3];
  const ViewDifferences differences = view_differences(views, scale, coefficients);
  // Scales the rest up by the removed part, so that the rms stays.
  const double left = 1.0 - kFitted * (2.0 - kFitted) * differences.count / std::max(1.0, coefficients - 1.0);
  std::array<std::array<double, 16>, 3> value{};  // by channel, in units of the rms
  for (unsigned k = 1; k < coefficients; ++k) {
    // An eighth of the variance is the object's gloss; the rest differs between Gaussians. Both are mostly grey.
    const double shared_grey = 0.35 * tint.normal();
    const double own_grey = 0.85 * random.normal();
    for (unsigned c = 0; c < 3; ++c) {
      value[c][k] = shared_grey + 0.05 * tint.normal();
      value[c][k] += own_grey + 0.38 * random.normal();
    }
  }
  const std::array<double, 16> nearest = basis(views[0]);
  const double grey = random.normal();
  for (unsigned c = 0; c < 3; ++c) {
    for (unsigned i = 0; i < differences.count; ++i) {
      double along = 0.0;
      for (unsigned k = 1; k < coefficients; ++k) along += differences.axes[i][k] * value[c][k];
      for (unsigned k = 1; k < coefficients; ++k) value[c][k] -= kFitted * along * differences.axes[i][k];
    }
    double seen = 0.0;
    for (unsigned k = 1; k < coefficients; ++k) {
      const double coefficient = scale[k] * value[c][k] / std::sqrt(left);
      row.sh[3 * k + c] = static_cast<float>(coefficient);
      seen += nearest[k] * coefficient;
    }
    const double wanted = std::clamp(colour[static_cast<int>(c)], 0.0, 1.0) - 0.5 - kFitted * seen;
    row.sh[c] = static_cast<float>(wanted / kBand0 + noise.rms[0] * (0.85 * grey + 0.5 * random.normal()));
  }
}

}  // namespace grtx::frontend
