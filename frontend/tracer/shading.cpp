// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/shading.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "grtx/base/fp16.h"
#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_watch.h"

namespace grtx::frontend {
namespace {

constexpr unsigned kUsualShFunctions = 16;  ///< degree 3, which a shader of 3DGS evaluates whatever the scene has

/// As it lies in a table of colours; beyond what fp16 holds the largest that it holds.
glm::vec3 stored_colour(const glm::vec3& colour) {
  const auto stored = [](float x) { return round_to_fp16(std::min(x, 65504.0f)); };
  return {stored(colour.r), stored(colour.g), stored(colour.b)};
}

}  // namespace

Shading::Shading(const TracedStructure& structure, const TracerOptions& options)
    : scene_(structure.scene),
      records_(structure, options),
      world_(structure.world),
      options_(options),
      sh_degree_(scene_.sh_degree) {
  if (world_ == nullptr && options.triangle_test == TriangleTest::world) processed_by_.resize(scene_.size());
}

void Shading::begin_ray(const TraceRay& ray) {
  if (options_.sh_direction == ShDirection::ray) basis_ = sh_basis(ray.direction, sh_degree_);
}

template <typename Recorder>
void Shading::blend(const TraceRay& ray, RayState& state, traces::Round& round, Recorder& recorder) {
  if (world_ == nullptr) prefetch_colours(state.hits.k_buffer());
  for (const KEntry& entry : state.hits.k_buffer().entries()) {
    const GaussianRecord& g = records_.of(entry.id);
    const float alpha = records_.alpha(entry, g);
    if (Recorder::kEnabled) recorder.processed(records_.number(entry.id), alpha > 0.0f);
    ++round.processed_count;
    ++state.counters.processed;
    if (options_.triangle_test == TriangleTest::world) count_doubled(entry.id, state);
    if (!(alpha > 0.0f)) continue;
    const glm::vec3 colour = colour_of(entry, g, ray, state.counters);
    const float weight = alpha * state.transmittance;
    state.colour += weight * colour;
    state.transmittance *= 1.0f - alpha;
    ++state.counters.blended;
    if (blended_ids_ != nullptr) blended_ids_->push_back(entry.id);
    if (options_.ert_check == ErtCheck::hit && state.transmittance < options_.ert) {
      round.terminated = true;
      break;
    }
  }
  if (options_.ert_check == ErtCheck::round) round.terminated = state.transmittance < options_.ert;
  if (round.terminated) state.counters.skipped_dead_colours += state.hits.k_buffer().size() - round.processed_count;
}

template void Shading::blend(const TraceRay&, RayState&, traces::Round&, NullRecorder&);
template void Shading::blend(const TraceRay&, RayState&, traces::Round&, GroupRecorder&);
template void Shading::blend(const TraceRay&, RayState&, traces::Round&, EncodingRecorder&);
template void Shading::blend(const TraceRay&, RayState&, traces::Round&, RayWatch&);

void Shading::prefetch_colours(const KBuffer& hits) const {
  const unsigned coefficients = scene_.sh_coefficients();
  for (const KEntry& entry : hits.entries()) {
    const float* sh = &scene_.sh[static_cast<std::size_t>(entry.id) * coefficients * 3];
    __builtin_prefetch(sh);
    if (coefficients > 4) {
      __builtin_prefetch(sh + 16);
      __builtin_prefetch(sh + 32);
    }
    if (coefficients > kUsualShFunctions) {
      __builtin_prefetch(sh + 48);
      __builtin_prefetch(sh + 64);
    }
  }
}

glm::vec3 Shading::colour_of(const KEntry& entry, const GaussianRecord& g, const TraceRay& ray,
                             TracerCounters& counters) {
  if (world_ != nullptr) return colour_in_world(entry, ray);
  if (options_.sh_direction == ShDirection::centre) {
    basis_ = sh_basis(unit_vector(g.mean - ray.origin), sh_degree_);
  }
  const unsigned coefficients = scene_.sh_coefficients();
  const float* sh = &scene_.sh[static_cast<std::size_t>(entry.id) * coefficients * 3];
  if (coefficients < kUsualShFunctions) counters.skipped_sh_bands += 3 * (kUsualShFunctions - coefficients);
  const glm::vec3 colour = sh_colour(sh, basis_, coefficients);
  return options_.colour == ColourPer::frame ? stored_colour(colour) : colour;
}

// Spherical harmonics are in object space: transforming the direction to it rotates them with the object.
glm::vec3 Shading::colour_in_world(const KEntry& entry, const TraceRay& ray) const {
  const PlacedObject& placed = world_->owner(entry.id);
  const std::uint32_t local = entry.id - placed.first_gaussian;
  const Scene& scene = placed.object->scene;
  const TraceRay object_ray = placed.to_object_ray(ray);
  const glm::vec3 d = options_.sh_direction == ShDirection::centre
                          ? placed.object->gaussians.record(local).mean - object_ray.origin
                          : object_ray.direction;
  const unsigned coefficients = scene.sh_coefficients();
  return sh_colour(&scene.sh[static_cast<std::size_t>(local) * coefficients * 3],
                   sh_basis(unit_vector(d), scene.sh_degree), coefficients);
}

void Shading::count_doubled(std::uint32_t gaussian, RayState& state) {
  if (processed_by_[gaussian] == state.stamp) ++state.counters.doubled;
  processed_by_[gaussian] = state.stamp;
}

}  // namespace grtx::frontend
