// SPDX-License-Identifier: Apache-2.0
// The object that a ray is in: the scene's only one or, with several, the one whose TLAS the ray walks.
#pragma once

#include <algorithm>
#include <cstdint>

#include "grtx/frontend/accel/multi_object.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"

namespace grtx::frontend {

class CurrentObject {
 public:
  CurrentObject(const PreparedGaussians& gaussians, const MultiObjectWorld* world)
      : gaussians_(&gaussians), world_(world) {}

  bool one_of_several() const { return world_ != nullptr; }
  const PreparedGaussians& gaussians() const { return *gaussians_; }
  const GaussianRecord& record(std::uint32_t g) const { return gaussians_->record(g); }

  void begin_ray() { leaf_ = 0; }
  /// Whether the ray is in this object. leaf: of the scene TLAS, an index into WalkMemory; 0: none.
  bool is(std::uint32_t leaf) const { return leaf_ == leaf; }
  /// Enters an object. ray: in the world. index: of the placement, as in the leaf.
  const PlacedObject& enter(const TraceRay& ray, std::uint32_t leaf, std::uint32_t index) {
    leaf_ = leaf;
    placed_ = &world_->placed()[index];
    gaussians_ = &placed_->object->gaussians;
    ray_ = placed_->to_object_ray(ray);
    interval_ = conservative_interval(ray.slabs, placed_->box);
    return *placed_;
  }
  /// The ray in the object's space.
  const TraceRay& ray() const { return ray_; }

  /// Converts a hit and its Gaussian's id from the object to the scene. World and object space round differently. As
  /// with the boxes of a face, a hit is defined to lie in its object's world box: whatever the scene TLAS looks like,
  /// its boxes contain that one and lead to the hit.
  void place_hit(Hit& hit, std::uint32_t& gaussian, SortKey key) const {
    gaussian += placed_->first_gaussian;
    if (interval_.empty()) hit.kind = HitKind::miss;
    hit.t = std::max(hit.t, interval_.enter);
    // The box may end before a peak, which is not an entry.
    if (key == SortKey::entry && hit.t > interval_.exit) hit.kind = HitKind::miss;
  }

 private:
  const PreparedGaussians* gaussians_;
  const MultiObjectWorld* world_;  ///< null: the scene has one object
  std::uint32_t leaf_ = 0;
  const PlacedObject* placed_ = nullptr;
  TraceRay ray_;
  Interval interval_;  ///< of the ray in the object's world box
};

}  // namespace grtx::frontend
