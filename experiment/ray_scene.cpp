// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/ray_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/experiment/scene_trace.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/report/ray/handled_order.h"

namespace grtx::experiment {

using namespace frontend;

namespace {

ViewOptions with_resolution(ViewOptions view, const traces::Header& header) {
  if (view.width == 0) view.width = header.width;
  if (view.height == 0) view.height = header.height;
  return view;
}

void require_same(const std::string& file, const char* what, const traces::Header& header, const std::string& name,
                  const std::string& found) {
  const auto recorded = header.inputs.find(name);
  const std::string expected = recorded == header.inputs.end() ? "" : recorded->second;
  if (expected != found) {
    throw Error(file, what,
                fmt::format("is not that of the trace: {}, not {}", found, expected.empty() ? "none" : expected));
  }
}

std::array<float, 3> floats(const glm::vec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

RayScene::RayScene(const std::string& trace, const traces::Header& header, const std::string& scene, ViewOptions view,
                   FilesRead& files)
    : trace_(trace),
      header_(header),
      path_(scene),
      settings_(traced_settings(trace, header.inputs)),
      options_(tracer_options(settings_, header.checkpoint, header.accel)) {
  camera_ = select_camera(with_resolution(std::move(view), header), files);
  if (camera_.width != header.width || camera_.height != header.height) {
    throw Error(scene, fmt::format("{} x {} pixels", camera_.width, camera_.height),
                fmt::format("the trace has {} x {}", header.width, header.height));
  }
  if (header.three_level() && !is_object_list(scene)) {
    throw Error(scene, "", "must be the list of objects that the trace was made of");
  }
  load_scene(scene_, scene, header.three_level(), {camera_}, settings_, header.accel, files, true);
  if (const MultiObjectWorld* const world = scene_.world()) {
    const auto& found = world->objects();
    for (std::size_t i = 0; i < found.size(); ++i) {
      require_same(scene, "object", header, "object_hash." + std::to_string(i), found[i]->scene.hash);
    }
  } else {
    const ViewTracer& tracer = *scene_.view();
    require_same(scene, "scene", header, "scene_hash", tracer.scene().hash);
    scene_.build(accel_options(settings_, header.accel), true);
    const OpticalObjects optical = optical_objects(settings_.secondary, tracer.scene(), camera_);
    if (!optical.empty()) {
      plan_ = plan_secondary(tracer.scene(), tracer.gaussians(), tracer.accel(), camera_, options_, optical,
                             header.warp_mapping == traces::WarpMapping::linear, settings_.threads, header.warp_size);
    }
  }
  if (scene_.structure().image.size() != header.node_image_bytes) {
    throw Error(scene, "structure", "is not that of the trace: another version built it");
  }
}

RayScene::Start RayScene::start_of(const traces::RayGroup& group, unsigned lane) const {
  if (group.kind == traces::RayKind::primary) {
    const std::uint32_t pixel = group.rays[lane].pixel;
    const glm::vec3 origin(camera_.position - scene_.structure().offset);
    const glm::vec3 direction(camera_.direction(pixel % header_.width, pixel / header_.width));
    Start start;
    start.ray = TraceRay(origin, direction);
    if (!plan_.objects.empty()) start.limit = plan_.primary_limit(origin, direction);
    return start;
  }
  std::uint64_t first = 0;
  for (std::uint32_t frame = 0; frame < group.frame; ++frame) first += header_.frame_groups[frame];
  first +=
      map_pixels(header_.width, header_.height, header_.warp_mapping == traces::WarpMapping::linear, header_.warp_size)
          .size();
  const std::uint64_t index = group.index - first;
  if (index >= plan_.groups.size() || lane >= plan_.groups[index].count) {
    throw Error(path_, "secondary rays", "are not those of " + trace_ + ": another camera or view");
  }
  const SecondaryRay& planned = plan_.rays[plan_.groups[index].first + lane];
  return {TraceRay(planned.origin, planned.direction), planned.limit, planned.transmittance};
}

void RayScene::require_same_events(const traces::RayGroup& group, const traces::Ray& recorded,
                                   const traces::Ray& found) const {
  const auto differs = [&](std::size_t round, std::size_t event) {
    return Error(path_,
                 fmt::format("pixel {},{} round {} event {}", recorded.pixel % header_.width,
                             recorded.pixel / header_.width, round, event),
                 "is not traced as in " + trace_ + ": another camera, view or version of the program");
  };
  std::size_t first = 0;
  for (std::size_t r = 0; r < std::max(recorded.rounds.size(), found.rounds.size()); ++r) {
    if (r >= recorded.rounds.size() || r >= found.rounds.size()) throw differs(r, 0);
    const std::uint32_t count = recorded.rounds[r].event_count;
    const std::span<const traces::Event> events(recorded.events.data() + first, count);
    std::vector<std::size_t> order;  // in which the ray came to them
    if (header_.ahead > 1) order = report::handled_order(events, header_.ahead).events;
    for (std::uint32_t e = 0; e < count; ++e) {
      const std::size_t event = first + e;
      traces::Event expected = events[header_.ahead > 1 ? order[e] : e];
      if (expected.kind() == traces::EventKind::visit_internal) expected.node = group.nodes[expected.node].address;
      expected.kind_shifts &= static_cast<std::uint16_t>(~traces::Event::kWide);  // follows from the structure
      if (event >= found.events.size() || found.events[event] != expected) throw differs(r, e);
    }
    if (recorded.rounds[r] != found.rounds[r]) throw differs(r, count);
    first += count;
  }
  if (recorded.processed != found.processed) throw differs(recorded.rounds.size(), 0);
}

report::RayValues RayScene::trace(const traces::RayGroup& group, unsigned lane) {
  const traces::Ray& recorded = group.rays[lane];
  const Start start = start_of(group, lane);
  const TracedStructure traced = scene_.structure();
  RayTracer tracer(traced, options_);
  RayWatch watch(options_, tracer.state(), tracer.stack());
  watch.begin_ray(recorded.pixel);
  tracer.trace(start.ray, watch, start.transmittance, start.limit);
  WatchedRay watched = watch.watched();
  require_same_events(group, recorded, watched.ray);

  report::RayValues values;
  values.t_max = std::move(watched.t_max);
  values.times = std::move(watched.times);
  values.transmittance = std::move(watched.transmittance);
  for (const WatchedRay::Start& round : watched.starts) {
    values.start_t_max.push_back(round.t_max);
    auto& hits = values.start_hits.emplace_back();
    for (const KEntry& hit : round.k_buffer) hits.emplace_back(hit.t, hit.id);
  }
  values.origin = floats(start.ray.origin);
  values.direction = floats(start.ray.direction);
  return values;
}

void RayScene::describe(std::vector<report::RayNode>& nodes) const {
  const TracedStructure traced = scene_.structure();
  const NodeImage& image = traced.image;
  const std::uint64_t unit = image.sizes().unit();
  const std::uint64_t objects_end = header_.objects_base();
  for (report::RayNode& node : nodes) {
    const std::uint64_t address = node.units * unit;
    if (traces::without_width(node.kind) == traces::NodeKind::instance) {
      const std::uint32_t index = image.leaf_index(node.units);
      node.gaussian = scene_.world() && address < objects_end ? scene_.world()->placed()[index].first_gaussian : index;
    } else if (node.kind != traces::NodeKind::internal && (!header_.two_level || address < header_.blas_base)) {
      const std::uint32_t leaves = traced.proxy.is_sphere()                                ? 1
                                   : image.sizes().layout() == traces::NodeLayout::compact ? traced.patches.count()
                                                                                           : traced.proxy.faces();
      node.gaussian = image.leaf_index(node.units) / leaves;
    }
    if (node.first_child == 0 || node.kind != traces::NodeKind::internal) continue;
    if (scene_.world() && address >= objects_end && address < header_.blas_base) continue;  // box is in object space
    const DecodedInternal decoded = image.decode_internal(address);
    for (unsigned slot = 0; slot < decoded.child_count; ++slot) {
      report::RayNode& child = nodes[node.first_child - 1 + slot];
      const Box& box = decoded.boxes[slot];
      child.boxed = true;
      child.box = {box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y, box.upper.z};
    }
  }
}

report::DrawnGaussian RayScene::gaussian(std::uint32_t number) const {
  report::DrawnGaussian drawn;
  drawn.number = number;
  const PlacedObject* const placed = scene_.world() ? &scene_.world()->owner(number) : nullptr;
  const std::uint32_t local = placed != nullptr ? number - placed->first_gaussian : number;
  const Scene& scene = placed != nullptr ? placed->object->scene : scene_.view()->scene();
  const PreparedGaussians& gaussians = placed != nullptr ? placed->object->gaussians : scene_.view()->gaussians();
  // Inverse of the transform of differences from world to object space.
  const glm::dmat3 to_world = placed != nullptr ? glm::inverse(placed->to_object) : glm::dmat3(1.0);
  const glm::dvec3 position = placed != nullptr ? placed->position : glm::dvec3(0.0);
  drawn.mean = floats(glm::vec3(position + to_world * glm::dvec3(gaussians.record(local).mean)));
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<float, 3> half = floats(glm::vec3(to_world * glm::dvec3(gaussians.half_axis(local, axis))));
    std::copy(half.begin(), half.end(), drawn.half_axes.begin() + 3 * axis);
  }
  constexpr float kFirstHarmonic = 0.28209479f;  // 1 / (2 sqrt pi)
  for (unsigned channel = 0; channel < 3; ++channel) {
    const std::size_t at = static_cast<std::size_t>(local) * scene.sh_coefficients() * 3 + channel;
    drawn.colour[channel] = std::clamp(0.5f + kFirstHarmonic * scene.sh[at], 0.0f, 1.0f);
  }
  drawn.opacity = gaussians.record(local).opacity;
  drawn.kernel_radius = std::sqrt(gaussians.record(local).kappa2);
  return drawn;
}

}  // namespace grtx::experiment
