// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/ray_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/experiment/ray_scene.h"
#include "grtx/experiment/slow_rays.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/report/page/html.h"
#include "grtx/report/ray/ray_page.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {
namespace {

/// Index of the view whose camera is recorded in the trace; `view.view` if none matches.
unsigned recorded_view(const traces::Header& header, const ViewOptions& view) {
  const auto recorded = header.inputs.find("camera");
  if (recorded == header.inputs.end()) return view.view;
  const std::vector<frontend::Camera> cameras = frontend::load_cameras(view.cameras);
  const auto found = std::ranges::find(cameras, recorded->second, &frontend::Camera::name);
  return found == cameras.end() ? view.view : static_cast<unsigned>(found - cameras.begin());
}

report::RayPage empty_page(const RayPlan& plan, const traces::Reader& reader) {
  report::RayPage page;
  page.trace = plan.trace;
  page.trace_hash = reader.content_hash();
  page.header = &reader.header();
  page.scene = plan.scene;
  page.timeline = plan.timeline;
  if (!plan.image.empty()) page.picture = report::picture_uri(plan.image);
  page.title = (plan.rays.warp ? fmt::format("Rays of warp {}", *plan.rays.warp)
                               : fmt::format("Ray of pixel {},{}", plan.rays.pixel[0], plan.rays.pixel[1])) +
               " in " + std::filesystem::path(plan.trace).filename().string();
  return page;
}

/// What the primary rays of the pixel did.
report::PixelBeside beside(const std::string& trace, const traces::Reader& reader, const RayChoice& choice,
                           const std::vector<ChosenRays>& chosen) {
  const traces::Header& header = reader.header();
  report::PixelBeside did;
  did.trace = trace;
  did.design =
      fmt::format("{}, checkpoints {}, k = {}", name_of(header.accel), header.checkpoint ? "on" : "off", header.k) +
      (header.ahead > 1 ? fmt::format(", {} nodes under way", header.ahead) : "");
  for (const ChosenRays& rays : chosen) {
    if (rays.group.kind != traces::RayKind::primary) continue;
    for (const unsigned lane : rays.lanes) {
      const traces::Ray& ray = rays.group.rays[lane];
      did.visits += visits_of(ray);
      did.rounds += ray.rounds.size();
      for (const traces::Round& round : ray.rounds) did.processed += round.processed_count;
    }
  }
  did.median = median_visits(reader, choice.frame);
  return did;
}

/// The same pixel in this trace and in others, which must be of the same view.
std::vector<report::PixelBeside> all_beside(const RayPlan& plan, const traces::Reader& reader,
                                            const std::vector<ChosenRays>& chosen) {
  std::vector<report::PixelBeside> all;
  if (plan.beside.empty()) return all;
  if (plan.rays.warp) throw Error("ray", "--beside", "is for a --pixel: warps hold other rays in another trace");
  all.push_back(beside(plan.trace, reader, plan.rays, chosen));
  const auto input = [](const traces::Reader& of, const char* name) {
    const auto found = of.header().inputs.find(name);
    return found == of.header().inputs.end() ? std::string() : found->second;
  };
  for (const std::string& trace : plan.beside) {
    const traces::Reader other(trace);
    for (const char* fact : {"files_hash", "camera"}) {
      if (input(other, fact) != input(reader, fact))
        throw Error(trace, "header", "is of another view than " + plan.trace);
    }
    if (other.header().width != reader.header().width || other.header().height != reader.header().height) {
      throw Error(trace, "header", "is of another size than " + plan.trace);
    }
    const std::vector<ChosenRays> rays = chosen_rays(trace, other, plan.rays);
    for (const ChosenRays& one : rays) traces::check_group(trace, other.header(), one.group);
    all.push_back(beside(trace, other, plan.rays, rays));
  }
  return all;
}

/// Timeline of each group; empty without a timeline.
std::vector<report::WarpTimeline> timelines_of(const RayPlan& plan, const traces::Reader& reader,
                                               const std::vector<ChosenRays>& chosen) {
  std::vector<report::WarpTimeline> timelines(chosen.size());
  if (plan.timeline.empty()) return timelines;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    timelines[i] = report::read_warp_timeline(plan.timeline, reader.content_hash(), chosen[i].group.index);
  }
  return timelines;
}

report::DrawnRay drawn_ray(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                           unsigned lane, report::RayNodes& nodes, RayScene* scene) {
  report::DrawnRay drawn;
  drawn.group = group.index;
  drawn.frame = group.frame;
  drawn.lane = lane;
  drawn.pixel = group.rays[lane].pixel;
  drawn.kind = group.kind;
  std::optional<report::RayValues> values;
  if (scene != nullptr) values = scene->trace(group, lane);
  drawn.replayed = report::replay_ray(file, header, group, lane, nodes, values ? &*values : nullptr);
  if (values) {
    drawn.traced_again = true;
    drawn.transmittance = values->transmittance;
    drawn.origin = values->origin;
    drawn.direction = values->direction;
    return drawn;
  }
  for (const auto& [node, gaussian] : drawn.replayed.learnt) nodes.nodes()[node].gaussian = gaussian;
  return drawn;
}

}  // namespace

RayStudy study_rays(const RayPlan& plan) {
  const traces::Reader reader(plan.trace);
  const traces::Header& header = reader.header();
  const std::vector<ChosenRays> chosen = chosen_rays(plan.trace, reader, plan.rays);
  report::RayPage page = empty_page(plan, reader);
  page.median_visits = median_visits(reader, chosen.front().group.frame);
  page.beside = all_beside(plan, reader, chosen);
  for (const ChosenRays& rays : chosen) traces::check_group(plan.trace, header, rays.group);
  std::vector<report::WarpTimeline> timelines = timelines_of(plan, reader, chosen);
  if (!plan.timeline.empty()) page.timeline_config = timelines.front().config_hash;
  FilesRead files;
  std::optional<RayScene> scene;
  if (!plan.scene.empty()) {
    ViewOptions view = plan.view;
    if (plan.recorded_view) view.view = recorded_view(header, view);
    scene.emplace(plan.trace, header, plan.scene, view, files);
  }
  if (plan.opened) plan.opened(files);

  RayStudy study;
  study.traced_again = scene.has_value();
  std::set<std::uint32_t> met;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const traces::RayGroup& group = chosen[i].group;
    report::DrawnWarp warp{
        report::RayNodes(plan.trace, header, group, chosen[i].lanes), {}, std::move(timelines[i].slices)};
    if (scene) scene->describe(warp.nodes.nodes());
    for (const unsigned lane : chosen[i].lanes) {
      report::DrawnRay drawn = drawn_ray(plan.trace, header, group, lane, warp.nodes, scene ? &*scene : nullptr);
      met.insert(drawn.replayed.met.begin(), drawn.replayed.met.end());
      ++study.rays;
      study.rounds += group.rays[lane].rounds.size();
      study.events += group.rays[lane].events.size();
      warp.rays.push_back(std::move(drawn));
    }
    page.warps.push_back(std::move(warp));
  }
  for (const std::uint32_t number : met) page.gaussians.push_back(scene->gaussian(number));
  study.page = report::ray_page(page);
  return study;
}

}  // namespace grtx::experiment
