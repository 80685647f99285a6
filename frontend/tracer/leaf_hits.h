// SPDX-License-Identifier: Apache-2.0
// The hit of a ray in a leaf: the canonical hit of its Gaussian, or the leaf's stored triangle, as a link of
// WalkMemory.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/world_triangle.h"
#include "grtx/frontend/tracer/current_object.h"
#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/walk_memory.h"

namespace grtx::frontend {

/// One per tracer. Rays passed to its functions are in the space of `object`.
class LeafHits {
 public:
  LeafHits(const TracedStructure& structure, const TracerOptions& options)
      : image_(structure.image),
        proxy_(structure.proxy),
        sort_key_(options.sort_key),
        inside_(options.inside),
        stored_triangles_(options.triangle_test == TriangleTest::world),
        leaves_(leaves_of(structure)),
        leaf_of_face_(leaf_of_face(structure)),
        test_faces_(face_test(options.simd)) {}

  void begin_ray(const TraceRay& ray) {
    if (stored_triangles_) sheared_ = ShearedRay(ray.origin, ray.direction);
  }
  /// Prepares an instance of this Gaussian for a ray that enters it.
  void enter(EnteredInstance& instance, const TraceRay& ray, std::uint32_t gaussian, const CurrentObject& object) const;

  /// Link of a leaf. units: its address. instance: the one that the ray is in; null outside the BLAS.
  std::uint32_t link_of_leaf(const TraceRay& ray, std::uint32_t units, EnteredInstance* instance,
                             const CurrentObject& object, WalkMemory& memory, RayState& state);
  /// Link of an instance without a walk of its BLAS: the hit that the walk would find.
  std::uint32_t link_of_instance(const TraceRay& ray, EnteredInstance& instance, const CurrentObject& object,
                                 WalkMemory& memory) {
    if (instance.decision == 0) {
      instance.decision = link_of_hit(hit_of_instance(ray, instance, object), instance.gaussian, object, memory);
    }
    return instance.decision;
  }

 private:
  /// primitive / leaves: a division by 5 as a multiplication, exact for all 32 bits, then a shift.
  std::uint32_t gaussian_of(std::uint32_t primitive) const {
    return static_cast<std::uint32_t>(std::uint64_t{primitive} * (leaves_ == 1 ? 1u : 0xCCCCCCCDu) >> leaves_shift_);
  }
  static bool compact(const TracedStructure& structure) {
    return structure.image.sizes().layout() == traces::NodeLayout::compact;
  }
  static unsigned leaves_of(const TracedStructure& structure) {
    if (structure.proxy.is_sphere()) return 1;
    return compact(structure) ? structure.patches.count() : structure.proxy.faces();
  }
  static std::array<std::uint8_t, 80> leaf_of_face(const TracedStructure& structure) {
    if (compact(structure)) return structure.patches.patch_of();
    std::array<std::uint8_t, 80> same{};
    for (unsigned i = 0; i < same.size(); ++i) same[i] = static_cast<std::uint8_t>(i);
    return same;
  }
  const Hit& cached_hit(const TraceRay& ray, std::uint32_t gaussian, const CurrentObject& object, std::uint64_t stamp);
  const Hit& hit_of_instance(const TraceRay& ray, EnteredInstance& instance, const CurrentObject& object) const;
  Hit stored_triangle_hit(const TraceRay& ray, std::uint32_t units, const EnteredInstance* instance,
                          std::uint32_t gaussian, const CurrentObject& object) const;
  std::uint32_t link_of_hit(Hit hit, std::uint32_t gaussian, const CurrentObject& object, WalkMemory& memory) const;

  const NodeImage& image_;
  const Proxy& proxy_;
  const SortKey sort_key_;
  const InsideRule inside_;
  const bool stored_triangles_;
  const unsigned leaves_;  ///< of a proxy: 1, 5, 20 or 80
  const unsigned leaves_shift_ = leaves_ == 1 ? 0 : leaves_ == 5 ? 34 : leaves_ == 20 ? 36 : 38;  ///< see gaussian_of()
  const std::array<std::uint8_t, 80> leaf_of_face_;  ///< by face: index of the proxy's leaf with that face
  const FaceTest test_faces_;
  ShearedRay sheared_;  ///< the ray, for stored triangles outside a BLAS

  // Recent hit tests of a monolithic structure: up to 80 faces of a Gaussian lie close together in the walk.
  struct CachedHit {
    std::uint64_t tag = ~std::uint64_t{0};
    Hit hit;
  };
  static constexpr std::size_t kHitCache = 512;
  std::vector<CachedHit> hit_cache_ = std::vector<CachedHit>(kHitCache);
};

inline void LeafHits::enter(EnteredInstance& instance, const TraceRay& ray, std::uint32_t gaussian,
                            const CurrentObject& object) const {
  const GaussianRecord& g = object.record(gaussian);
  instance.gaussian = gaussian;
  instance.unit = to_unit_ray(ray, g);
  instance.slabs = SlabRay(instance.unit.peak, instance.unit.direction);
  if (!stored_triangles_) return;
  // The ray as a transform unit computes it from the instance leaf: fp32 origin and direction, the same t.
  const glm::vec3 from_mean = ray.origin - g.mean;
  glm::vec3 origin, direction;
  for (int i = 0; i < 3; ++i) {
    const glm::vec3& row = g.to_unit[i];
    origin[i] = (row.x * from_mean.x + row.y * from_mean.y) + row.z * from_mean.z;
    direction[i] = (row.x * ray.direction.x + row.y * ray.direction.y) + row.z * ray.direction.z;
  }
  instance.sheared = ShearedRay(origin, direction);
}

inline const Hit& LeafHits::cached_hit(const TraceRay& ray, std::uint32_t gaussian, const CurrentObject& object,
                                       std::uint64_t stamp) {
  CachedHit& cached = hit_cache_[gaussian % kHitCache];
  const std::uint64_t tag = (stamp << 32) | gaussian;
  if (cached.tag != tag) {
    cached.tag = tag;
    cached.hit = canonical_hit(ray, to_unit_ray(ray, object.record(gaussian)), object.gaussians(), gaussian, proxy_,
                               sort_key_, inside_, test_faces_);
  }
  return cached.hit;
}

inline const Hit& LeafHits::hit_of_instance(const TraceRay& ray, EnteredInstance& instance,
                                            const CurrentObject& object) const {
  if (!instance.hit_known) {
    instance.hit = canonical_hit(ray, instance.unit, object.gaussians(), instance.gaussian, proxy_, sort_key_, inside_,
                                 test_faces_);
    instance.hit_known = true;
  }
  return instance.hit;
}

inline std::uint32_t LeafHits::link_of_leaf(const TraceRay& ray, std::uint32_t units, EnteredInstance* instance,
                                            const CurrentObject& object, WalkMemory& memory, RayState& state) {
  const std::uint32_t primitive = image_.leaf_index(units);
  const std::uint32_t gaussian = instance != nullptr ? instance->gaussian : gaussian_of(primitive);
  if (stored_triangles_) {
    return link_of_hit(stored_triangle_hit(ray, units, instance, gaussian, object), gaussian, object, memory);
  }
  // A leaf outside the BLAS holds one proxy face, or patch of faces, of all in the scene.
  const std::uint32_t leaf = instance != nullptr ? primitive : primitive - gaussian * leaves_;
  const Hit& hit =
      instance != nullptr ? hit_of_instance(ray, *instance, object) : cached_hit(ray, gaussian, object, state.stamp);
  return leaf_of_face_[hit.face] == leaf ? link_of_hit(hit, gaussian, object, memory) : WalkMemory::kMissed;
}

/// Whether and where the ray hits the leaf's triangles (the nearest of several) comes from their vertices, the response
/// from the Gaussian, as in the blending shader.
inline Hit LeafHits::stored_triangle_hit(const TraceRay& ray, std::uint32_t units, const EnteredInstance* instance,
                                         std::uint32_t gaussian, const CurrentObject& object) const {
  const ShearedRay& sheared = instance != nullptr ? instance->sheared : sheared_;
  Hit hit;
  for (unsigned i = 0; i < image_.triangle_count(units); ++i) {
    const auto [a, b, c] = image_.triangle(units, i);
    const std::optional<float> t = sheared.hit(a, b, c);
    if (!t || (hit.kind == HitKind::hit && hit.t <= *t)) continue;
    hit.kind = HitKind::hit;
    hit.t = *t;
  }
  if (hit.kind != HitKind::hit) return hit;
  hit.d2 = (instance != nullptr ? instance->unit : to_unit_ray(ray, object.record(gaussian))).d2;
  return hit;
}

inline std::uint32_t LeafHits::link_of_hit(Hit hit, std::uint32_t gaussian, const CurrentObject& object,
                                           WalkMemory& memory) const {
  if (object.one_of_several()) object.place_hit(hit, gaussian, sort_key_);
  if (hit.kind == HitKind::miss) return WalkMemory::kMissed;
  return hit.kind == HitKind::inside ? WalkMemory::kInside : memory.add_hit({hit.t, gaussian, hit.d2});
}

}  // namespace grtx::frontend
