// SPDX-License-Identifier: Apache-2.0
// The one hit function: (ray, Gaussian, proxy) -> (hit?, t_hit, face, d2). Every acceleration structure uses it, so
// structures differ only in which nodes they visit.
//
// The ray is rebased in world space to the foot of the perpendicular from the mean before it is transformed (form F4 of
// docs/model/numerics.md), and rebased once more in unit space to the point of peak response. A polyhedron is a set of
// slabs; its entry face is the arg-max. A hit must also pass the slab tests of its face's world box and object box, and
// its t is clamped to them: so any structure whose boxes contain those two reaches the face, whatever fp32 rounds.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "grtx/frontend/gaussian/hit_options.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

struct TraceRay {
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f, 0.0f, 1.0f};  ///< fp32-rounded unit vector
  SlabRay slabs;
  float inverse_length2 = 1.0f;  ///< 1 / (direction . direction)

  TraceRay() = default;
  TraceRay(const glm::vec3& o, const glm::vec3& d)
      : origin(o), direction(d), slabs(o, d), inverse_length2(1.0f / ((d.x * d.x + d.y * d.y) + d.z * d.z)) {}
};

/// The ray in the unit frame of one Gaussian: t = t_peak + e for the point peak + e * direction.
struct UnitRay {
  float t_peak = 0.0f;
  glm::vec3 peak{0.0f};  ///< point of peak response, |peak|^2 = d2
  glm::vec3 direction{0.0f};
  float d2 = std::numeric_limits<float>::infinity();
  float length2 = 1.0f;  ///< |direction|^2
};

enum class HitKind : std::uint8_t {
  miss,
  hit,
  inside,  ///< the proxy contains the ray origin and is not counted
};

struct Hit {
  HitKind kind = HitKind::miss;
  float t = 0.0f;
  float d2 = 0.0f;         ///< squared distance from the centre at peak response, in units of the kernel radius
  std::uint32_t face = 0;  ///< entry face; for `inside` the exit face, which lies ahead
};

namespace detail {

template <typename Real>
inline Real dot3(const Real* a, const Real* b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

template <typename Real>
inline UnitRay to_unit_ray_as(const TraceRay& ray, const GaussianRecord& g) {
  const Real d[3] = {Real(ray.direction.x), Real(ray.direction.y), Real(ray.direction.z)};
  const Real m[3] = {Real(g.mean.x) - Real(ray.origin.x), Real(g.mean.y) - Real(ray.origin.y),
                     Real(g.mean.z) - Real(ray.origin.z)};
  const Real tc = dot3(m, d) * Real(ray.inverse_length2);
  const Real p[3] = {d[0] * tc - m[0], d[1] * tc - m[1], d[2] * tc - m[2]};
  Real lo[3], ld[3];
  for (int i = 0; i < 3; ++i) {
    const Real row[3] = {Real(g.to_unit[i].x), Real(g.to_unit[i].y), Real(g.to_unit[i].z)};
    lo[i] = dot3(row, p);
    ld[i] = dot3(row, d);
  }
  const Real length2 = dot3(ld, ld);
  const Real dt = -dot3(lo, ld) / length2;
  Real peak[3];
  for (int i = 0; i < 3; ++i) peak[i] = lo[i] + dt * ld[i];
  UnitRay unit;
  unit.t_peak = static_cast<float>(tc + dt);
  unit.peak = glm::vec3(static_cast<float>(peak[0]), static_cast<float>(peak[1]), static_cast<float>(peak[2]));
  unit.direction = glm::vec3(static_cast<float>(ld[0]), static_cast<float>(ld[1]), static_cast<float>(ld[2]));
  unit.d2 = static_cast<float>(dot3(peak, peak));
  unit.length2 = static_cast<float>(length2);
  return unit;
}

/// Half the length of the ray in the unit sphere, in t; in double where |direction|^2 underflows fp32 (scales from
/// 1e19).
inline float half_chord(const UnitRay& unit) {
  if (unit.length2 >= std::numeric_limits<float>::min()) return std::sqrt((1.0f - unit.d2) / unit.length2);
  const double d[3] = {unit.direction.x, unit.direction.y, unit.direction.z};
  return static_cast<float>(std::sqrt((1.0 - static_cast<double>(unit.d2)) / dot3(d, d)));
}

}  // namespace detail

/// Extreme scales overflow or underflow fp32 squares: those rare Gaussians are transformed in double.
inline UnitRay to_unit_ray(const TraceRay& ray, const GaussianRecord& g) {
  UnitRay unit = detail::to_unit_ray_as<float>(ray, g);
  if (!(unit.length2 > 1e-30f && unit.length2 < 1e30f && unit.d2 < 1e30f)) {
    unit = detail::to_unit_ray_as<double>(ray, g);
  }
  return unit;
}

/// docs/model/numerics.md. A pure function of its arguments; every face test gives the same bits.
inline Hit canonical_hit(const TraceRay& ray, const UnitRay& unit, const PreparedGaussians& gaussians, std::uint32_t g,
                         const Proxy& proxy, SortKey key, InsideRule inside_rule, FaceTest test_faces) {
  Hit hit;
  hit.d2 = unit.d2;
  const bool inside_ellipsoid = unit.d2 <= 1.0f;
  if (!(unit.d2 <= proxy.circumscribed_radius2()) || (key == SortKey::peak && !inside_ellipsoid)) return hit;
  Interval span;
  std::uint32_t exit_face = 0;
  if (proxy.is_sphere()) {
    const float half = detail::half_chord(unit);
    span = {-half, half};
  } else {
    span = test_faces(unit.peak, unit.direction, proxy.face_slabs(), hit.face, exit_face);
    if (span.empty()) return hit;
  }
  const float t_enter = unit.t_peak + span.enter;
  const float t_exit = unit.t_peak + span.exit;
  if (!(t_exit > 0.0f)) return hit;
  if (!(t_enter > 0.0f)) {
    if (inside_rule == InsideRule::skip || !proxy.is_sphere()) {
      hit.kind = HitKind::inside;
      hit.face = exit_face;
      return hit;
    }
    if (!(unit.t_peak > 0.0f)) return hit;  // the peak lies behind the origin
    hit.kind = HitKind::hit;
    hit.t = key == SortKey::peak ? unit.t_peak : 0.0f;
    return hit;
  }
  const Interval world = conservative_interval(ray.slabs, gaussians.face_box(g, proxy, hit.face));
  const Interval object = slab_interval(SlabRay(unit.peak, unit.direction), proxy.face_box(hit.face));
  if (world.empty() || object.empty()) return hit;
  if (key == SortKey::peak) {
    // The peak lies inside the whole proxy, not inside the entry face's box: only the face must be reached.
    hit.t = unit.t_peak;
  } else {
    const float lower = std::max(world.enter, unit.t_peak + object.enter);
    const float upper = std::min(world.exit, unit.t_peak + object.exit);
    if (!(lower <= upper)) return hit;
    hit.t = std::min(std::max(t_enter, lower), upper);
  }
  hit.kind = HitKind::hit;
  return hit;
}

}  // namespace grtx::frontend
