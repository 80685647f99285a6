// SPDX-License-Identifier: Apache-2.0
// Six published ways to meet a Gaussian with a ray, as templates over the arithmetic: F1 to F6 of
// docs/model/numerics.md.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace grtx::bench {

/// Inputs as a tracer stores them, all rounded to fp32 once.
struct Pair {
  glm::vec3 origin, direction, mean;
  glm::mat3 to_sigma;     ///< S^-1 R^T, world differences to standard deviations
  glm::vec3 translation;  ///< -to_sigma mean, rounded to fp32 as an instance record holds it (F6)
  glm::mat3 precision;    ///< R S^-2 R^T (F5)
  double kappa = 3.0;     ///< radius at which the proxy ends, standard deviations
  double opacity = 1.0;
};

struct Meeting {
  double d2 = 0.0;     ///< squared distance at peak response, sigma^2
  double peak = 0.0;   ///< t of the peak response
  double entry = 0.0;  ///< t of the entry into the ellipsoid of radius kappa; NaN when it is missed
};

template <typename Real>
using Vec = glm::vec<3, Real>;

template <typename Real>
Real dot3(const Vec<Real>& a, const Vec<Real>& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

template <typename Real>
Meeting make(Real d2, Real base, Real dt, Real a, Real kappa) {
  const Real half = std::sqrt((kappa * kappa - d2) / a);
  return {static_cast<double>(d2), static_cast<double>(base + dt), static_cast<double>(base + (dt - half))};
}

/// 3DGRT: squared length of the cross product of the normalised local direction and the local origin.
template <typename Real>
Meeting f1(const Pair& p) {
  const glm::mat<3, 3, Real> m(p.to_sigma);
  const Vec<Real> lo = m * (Vec<Real>(p.origin) - Vec<Real>(p.mean)), ld = m * Vec<Real>(p.direction);
  const Real a = dot3(ld, ld);
  const Vec<Real> across = glm::cross(ld / std::sqrt(a), lo);
  return make(dot3(across, across), Real(0), -dot3(lo, ld) / a, a, static_cast<Real>(p.kappa));
}

/// The textbook quadratic.
template <typename Real>
Meeting f2(const Pair& p) {
  const glm::mat<3, 3, Real> m(p.to_sigma);
  const Vec<Real> lo = m * (Vec<Real>(p.origin) - Vec<Real>(p.mean)), ld = m * Vec<Real>(p.direction);
  const Real a = dot3(ld, ld), b = dot3(lo, ld), c = dot3(lo, lo), kappa = static_cast<Real>(p.kappa);
  const Real root = std::sqrt(b * b - a * (c - kappa * kappa));
  return {static_cast<double>(c - b * b / a), static_cast<double>(-b / a), static_cast<double>((-b - root) / a)};
}

/// Haines et al., Ray Tracing Gems, chapter 7: the point of peak response first.
template <typename Real>
Meeting from_local(const Vec<Real>& lo, const Vec<Real>& ld, Real base, double kappa) {
  const Real a = dot3(ld, ld);
  const Real dt = -dot3(lo, ld) / a;
  const Vec<Real> nearest = lo + dt * ld;
  return make(dot3(nearest, nearest), base, dt, a, static_cast<Real>(kappa));
}

template <typename Real>
Meeting f3(const Pair& p) {
  const glm::mat<3, 3, Real> m(p.to_sigma);
  return from_local<Real>(m * (Vec<Real>(p.origin) - Vec<Real>(p.mean)), m * Vec<Real>(p.direction), Real(0), p.kappa);
}

/// F3 after a step in world space to the foot of the perpendicular from the mean.
template <typename Real>
Meeting f4(const Pair& p) {
  const glm::mat<3, 3, Real> m(p.to_sigma);
  const Vec<Real> d(p.direction), toward = Vec<Real>(p.mean) - Vec<Real>(p.origin);
  const Real tc = dot3(toward, d) / dot3(d, d);
  const Vec<Real> foot = d * tc - toward;
  return from_local<Real>(m * foot, m * d, tc, p.kappa);
}

/// The paper's formula as printed: the inverse covariance between world-space vectors.
template <typename Real>
Meeting f5(const Pair& p) {
  const glm::mat<3, 3, Real> q(p.precision);
  const Vec<Real> d(p.direction), offset = Vec<Real>(p.mean) - Vec<Real>(p.origin);
  const Vec<Real> qd = q * d;
  const Real a = dot3(d, qd), t = dot3(offset, qd) / a;
  const Vec<Real> x = Vec<Real>(p.origin) + t * d - Vec<Real>(p.mean);
  return make(dot3(x, q * x), Real(0), t, a, static_cast<Real>(p.kappa));
}

/// F3 with the translation baked into a 3x4 matrix, as an instance transform.
template <typename Real>
Meeting f6(const Pair& p) {
  const glm::mat<3, 3, Real> m(p.to_sigma);
  return from_local<Real>(m * Vec<Real>(p.origin) + Vec<Real>(p.translation), m * Vec<Real>(p.direction), Real(0),
                          p.kappa);
}

}  // namespace grtx::bench
