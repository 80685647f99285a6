// What RayTracer does differently in its other modes: single-round and closest-hit tracing, and triangles tested
// against their stored vertices. docs/model/tracer.md states the semantics. Included by frontend/tracer/ray_tracer.h.
#pragma once

#include "grtx/frontend/tracer/ray_tracer.h"

namespace grtx::frontend {

/// Single-round: appended as it comes. Once the buffer is full it keeps the k nearest, and t_max shrinks as in
/// multi-round tracing, so that the next round finds what was turned away behind the last one kept.
template <typename Recorder>
void RayTracer::collect_unsorted(const KEntry& candidate, const Entry& entry, Recorder& recorder) {
  using traces::LeafOutcome;
  const auto outcome = [&](LeafOutcome o, unsigned shifts) {
    recorder.event(traces::EventKind::visit_leaf, units_of(entry.node), static_cast<unsigned>(o), 0, shifts);
  };
  const bool kth = options_.tmax_update == TmaxUpdate::kth;
  if (!k_buffer_.full()) {
    const unsigned moved = k_buffer_.append(candidate);
    ++counters_.any_hit_inserted;
    if (kth && k_buffer_.full()) t_max_ = std::min(t_max_, k_buffer_.largest().t);
    return outcome(LeafOutcome::inserted, moved);
  }
  turned_away_ = true;
  ++counters_.any_hit_evicted;
  if (candidate < k_buffer_.largest()) {
    const unsigned moved = k_buffer_.replace_largest(candidate);
    ++counters_.any_hit_inserted;
    if (kth) t_max_ = std::min(t_max_, k_buffer_.largest().t);
    return outcome(LeafOutcome::displaced, moved);
  }
  ++counters_.any_hit_rejected;
  t_max_ = kth ? std::min(t_max_, k_buffer_.largest().t) : candidate.t;
  outcome(LeafOutcome::rejected, 0);
}

/// Closest-hit: only the nearest hit behind the last round's is kept. candidate.t <= t_max_.
template <typename Recorder>
void RayTracer::commit_nearest(const KEntry& candidate, const Entry& entry, Recorder& recorder) {
  using traces::LeafOutcome;
  const auto outcome = [&](LeafOutcome o) {
    recorder.event(traces::EventKind::visit_leaf, units_of(entry.node), static_cast<unsigned>(o), 0, 0);
  };
  if (k_buffer_.full()) {
    if (!(candidate < k_buffer_.back())) return outcome(LeafOutcome::beyond);  // a tie with a smaller id
    k_buffer_.displace(candidate);
  } else {
    k_buffer_.insert(candidate);
  }
  t_max_ = candidate.t;
  ++counters_.nearest_commits;
  outcome(LeafOutcome::nearest);
}

/// The ray as a transformation unit makes it from the instance leaf: fp32, origin and direction, the same t.
inline ShearedRay RayTracer::object_space_ray(const TraceRay& ray, std::uint32_t gaussian) const {
  const GaussianRecord& g = gaussians_.record(gaussian);
  const glm::vec3 from_mean = ray.origin - g.mean;
  glm::vec3 origin, direction;
  for (int i = 0; i < 3; ++i) {
    const glm::vec3& row = g.to_unit[i];
    origin[i] = (row.x * from_mean.x + row.y * from_mean.y) + row.z * from_mean.z;
    direction[i] = (row.x * ray.direction.x + row.y * ray.direction.y) + row.z * ray.direction.z;
  }
  return ShearedRay(origin, direction);
}

/// hit?, t and face from the leaf's vertices; the response still comes from the Gaussian, as in the blending shader.
inline Hit RayTracer::world_hit(const TraceRay& ray, const Entry& entry, std::uint32_t gaussian, std::uint32_t face) {
  const std::uint64_t leaf = static_cast<std::uint64_t>(units_of(entry.node)) * traces::kNodeUnit;
  const ShearedRay& sheared = in_blas(entry) ? memory_.instance(instance_).sheared : sheared_;
  Hit hit;
  hit.face = face;
  const std::optional<float> t = sheared.hit(image_.vertex(leaf, 0), image_.vertex(leaf, 1), image_.vertex(leaf, 2));
  if (!t) return hit;
  hit.kind = HitKind::hit;
  hit.t = *t;
  hit.d2 = (in_blas(entry) ? memory_.instance(instance_).unit : to_unit_ray(ray, gaussians_.record(gaussian))).d2;
  return hit;
}

inline void RayTracer::count_doubled(std::uint32_t gaussian) {
  if (processed_by_[gaussian] == ray_stamp_) ++counters_.doubled;
  processed_by_[gaussian] = ray_stamp_;
}

}  // namespace grtx::frontend
