// SPDX-License-Identifier: Apache-2.0
// Arithmetic of one Gaussian that every part of the tracer must evaluate identically on every host: kernel radius,
// response, spherical harmonics. Per-ray code uses only +, -, * and /, so images do not depend on a maths library.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <limits>

#include "grtx/frontend/gaussian/kernel.h"

namespace grtx::frontend {

inline constexpr float kAlphaMax = 0.99f;          // 3DGS, 3DGRT
inline constexpr float kAlphaMin = 1.0f / 255.0f;  // 3DGS, 3DGRT
inline constexpr double kMinResponse = 0.0113;     // 3DGRT particlePrimitives.cu
inline constexpr double kMaxResponse = 0.97;       // keeps the radius real for tiny opacities (3DGRT)

/// Radius of the bounding ellipsoid in standard deviations: where opacity * response falls to 0.0113 (adaptive), or 3.
/// opacity: 0..1. Result: 0.2468 .. 2.9943 for degree 2, 0.8605 .. 2.9972 for degree 4. Source: 3DGRT.
inline double kernel_radius(double opacity, Kernel kernel) {
  if (!kernel.adaptive) return 3.0;
  const double modulated = opacity > 0.0 ? kMinResponse / opacity : kMaxResponse;
  const double exponent = std::log(std::min(modulated, kMaxResponse));
  return kernel.degree == 4 ? std::sqrt(std::sqrt(-18.0 * exponent)) : std::sqrt(-2.0 * exponent);
}

/// e^x for x in [-80, 0] with a relative error below 1e-8, from plain arithmetic.
inline float exp_negative(float x) {
  // x = n ln2 + r, |r| <= ln2 / 2; e^r from its Taylor polynomial of degree 9 (remainder < 7e-12).
  const double value = static_cast<double>(x);
  const double scaled = value * 1.4426950408889634;
  const int n = static_cast<int>(scaled - 0.5);
  const double r = value - static_cast<double>(n) * 0.6931471805599453;
  double p = 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = p * r + 1.0;
  p = p * r + 1.0;
  const std::uint64_t bits = static_cast<std::uint64_t>(1023 + n) << 52;
  double power = 0.0;
  std::memcpy(&power, &bits, sizeof power);
  return static_cast<float>(p * power);
}

/// alpha of a hit. d2: squared distance of the ray from the centre in units of the kernel radius (<= 1 counts);
/// kappa2: squared kernel radius in sigma; degree: of the kernel. 0 when the hit does not count.
inline float hit_alpha(float opacity, float kappa2, float d2, unsigned degree = 2) {
  if (!(d2 <= 1.0f)) return 0.0f;
  const float sigma2 = kappa2 * d2;  // squared distance
  const float exponent = degree == 4 ? (sigma2 * sigma2) / -18.0f : -0.5f * sigma2;
  const float alpha = std::min(kAlphaMax, opacity * exp_negative(exponent));
  return alpha >= kAlphaMin ? alpha : 0.0f;
}

inline constexpr unsigned kShFunctions = 25;  ///< of degree 4, the highest in a scene

/// Real SH basis up to `degree` (0..4) for a unit direction, 0 beyond it; signs as in 3DGS.
inline std::array<float, kShFunctions> sh_basis(const glm::vec3& d, unsigned degree) {
  std::array<float, kShFunctions> b{};
  const float x = d.x, y = d.y, z = d.z;
  b[0] = 0.28209479177387814f;
  if (degree >= 1) {
    constexpr float c1 = 0.4886025119029199f;
    b[1] = -c1 * y;
    b[2] = c1 * z;
    b[3] = -c1 * x;
  }
  if (degree >= 2) {
    const float xx = x * x, yy = y * y, zz = z * z;
    b[4] = 1.0925484305920792f * (x * y);
    b[5] = -1.0925484305920792f * (y * z);
    b[6] = 0.31539156525252005f * (2.0f * zz - xx - yy);
    b[7] = -1.0925484305920792f * (x * z);
    b[8] = 0.5462742152960396f * (xx - yy);
    if (degree >= 3) {
      b[9] = -0.5900435899266435f * (y * (3.0f * xx - yy));
      b[10] = 2.890611442640554f * (x * y * z);
      b[11] = -0.4570457994644658f * (y * (4.0f * zz - xx - yy));
      b[12] = 0.3731763325901154f * (z * (2.0f * zz - 3.0f * xx - 3.0f * yy));
      b[13] = -0.4570457994644658f * (x * (4.0f * zz - xx - yy));
      b[14] = 1.445305721320277f * (z * (xx - yy));
      b[15] = -0.5900435899266435f * (x * (xx - 3.0f * yy));
    }
    if (degree >= 4) {
      b[16] = 2.5033429417967046f * (x * y * (xx - yy));
      b[17] = -1.7701307697799304f * (y * z * (3.0f * xx - yy));
      b[18] = 0.9461746957575601f * (x * y * (7.0f * zz - 1.0f));
      b[19] = -0.6690465435572892f * (y * z * (7.0f * zz - 3.0f));
      b[20] = 0.10578554691520431f * (zz * (35.0f * zz - 30.0f) + 3.0f);
      b[21] = -0.6690465435572892f * (x * z * (7.0f * zz - 3.0f));
      b[22] = 0.47308734787878004f * ((xx - yy) * (7.0f * zz - 1.0f));
      b[23] = -1.7701307697799304f * (x * z * (xx - 3.0f * yy));
      b[24] = 0.6258357354491761f * (xx * (xx - 3.0f * yy) - yy * (3.0f * xx - yy));
    }
  }
  return b;
}

/// v / |v|; v is not 0. Squares that overflow or underflow fp32 are computed in double.
inline glm::vec3 unit_vector(const glm::vec3& v) {
  const float length2 = (v.x * v.x + v.y * v.y) + v.z * v.z;
  if (length2 >= std::numeric_limits<float>::min() && length2 <= std::numeric_limits<float>::max()) {
    return v / std::sqrt(length2);
  }
  const double x = v.x, y = v.y, z = v.z, length = std::sqrt((x * x + y * y) + z * z);
  return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

/// Colour of a Gaussian: max(SH + 0.5, 0) per channel. sh: coefficient-major, r g b inner.
inline glm::vec3 sh_colour(const float* sh, const std::array<float, kShFunctions>& basis, unsigned coefficients) {
  glm::vec3 sum(0.0f);
  for (unsigned j = 0; j < coefficients; ++j) {
    sum.x += basis[j] * sh[3 * j];
    sum.y += basis[j] * sh[3 * j + 1];
    sum.z += basis[j] * sh[3 * j + 2];
  }
  return {std::max(sum.x + 0.5f, 0.0f), std::max(sum.y + 0.5f, 0.0f), std::max(sum.z + 0.5f, 0.0f)};
}

}  // namespace grtx::frontend
