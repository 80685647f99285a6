// grtx ray: how one ray, or the rays of one warp, were traced, as one HTML page.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/ray_scene.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/codec/check_group.h"
#include "grtx/traces/reader.h"
#include "grtx/view/ray/ray_page.h"

namespace grtx::sim {
namespace {

struct RayArguments {
  std::string trace;
  std::vector<unsigned> pixel;
  std::optional<std::uint64_t> warp;
  std::uint32_t frame = 0;
  std::string scene;
  ViewOptions view;
  std::string timeline;
  std::string output;
  CLI::App* command = nullptr;
};

struct Chosen {
  traces::RayGroup group;
  std::vector<unsigned> lanes;
};

std::string place_of(const RayArguments& options) {
  return options.warp ? fmt::format("--warp {}", *options.warp)
                      : fmt::format("--pixel {},{}", options.pixel[0], options.pixel[1]);
}

void choose(const traces::Reader& reader, std::uint64_t index, std::optional<std::uint32_t> pixel,
            std::vector<Chosen>& chosen) {
  Chosen next;
  reader.read(index, next.group);
  for (unsigned lane = 0; lane < next.group.rays.size(); ++lane) {
    const traces::Ray& ray = next.group.rays[lane];
    if (!ray.rounds.empty() && (!pixel || ray.pixel == *pixel)) next.lanes.push_back(lane);
  }
  if (!next.lanes.empty()) chosen.push_back(std::move(next));
}

/// The rays asked for, by the group that holds them.
std::vector<Chosen> chosen_rays(const traces::Reader& reader, const RayArguments& options) {
  const traces::Header& header = reader.header();
  std::vector<Chosen> chosen;
  if (options.warp) {
    if (*options.warp >= reader.group_count()) {
      throw Error(options.trace, place_of(options),
                  fmt::format("the trace has {} warps, numbered from 0", reader.group_count()));
    }
    choose(reader, *options.warp, std::nullopt, chosen);
  } else {
    const unsigned x = options.pixel[0], y = options.pixel[1];
    if (x >= header.width || y >= header.height) {
      throw Error(options.trace, place_of(options),
                  fmt::format("the image has {} x {} pixels, numbered from 0", header.width, header.height));
    }
    const std::size_t frames = std::max<std::size_t>(1, header.frame_groups.size());
    if (options.frame >= frames) {
      throw Error(options.trace, fmt::format("--frame {}", options.frame),
                  fmt::format("the trace has {} frame{}, numbered from 0", frames, frames == 1 ? "" : "s"));
    }
    std::uint64_t begin = 0;
    for (std::uint32_t i = 0; i < options.frame; ++i) begin += header.frame_groups[i];
    const std::uint64_t end = header.frame_groups.empty() ? header.groups : begin + header.frame_groups[options.frame];
    const std::uint32_t pixel = y * header.width + x;
    const auto primary = frontend::map_pixels(header.width, header.height,
                                              header.warp_mapping == traces::WarpMapping::linear, header.warp_size);
    for (std::size_t i = 0; i < primary.size(); ++i) {
      if (std::find(primary[i].begin(), primary[i].end(), pixel) != primary[i].end()) {
        choose(reader, begin + i, pixel, chosen);
      }
    }
    for (std::uint64_t i = begin + primary.size(); i < end; ++i) choose(reader, i, pixel, chosen);  // glass and mirrors
  }
  if (chosen.empty()) throw Error(options.trace, place_of(options), "has no ray: nothing was traced there");
  return chosen;
}

/// --view, unless it is given, is the one whose camera the trace names.
void find_view(const traces::Header& header, ViewOptions& view) {
  const auto recorded = header.inputs.find("camera");
  if (recorded == header.inputs.end()) return;
  const std::vector<frontend::Camera> cameras = frontend::load_cameras(view.cameras);
  const auto found = std::ranges::find(cameras, recorded->second, &frontend::Camera::name);
  if (found != cameras.end()) view.view = static_cast<unsigned>(found - cameras.begin());
}

int ray(const RayArguments& options, const CommonOptions& common) {
  if (options.pixel.empty() == !options.warp) throw Error("ray", "--pixel", "which ray? --pixel X,Y, or --warp W");
  if (options.scene.empty() != options.view.cameras.empty()) {
    throw Error("ray", options.scene.empty() ? "--cameras" : "--scene",
                "a ray is traced again with both: --scene and --cameras");
  }
  const traces::Reader reader(options.trace);
  const traces::Header& header = reader.header();
  std::vector<Chosen> chosen = chosen_rays(reader, options);

  RayPage page;
  page.trace = options.trace;
  page.trace_hash = reader.content_hash();
  page.header = &header;
  page.scene = options.scene;
  page.timeline = options.timeline;
  page.title = (options.warp ? fmt::format("Rays of warp {}", *options.warp)
                             : fmt::format("Ray of pixel {},{}", options.pixel[0], options.pixel[1])) +
               " in " + std::filesystem::path(options.trace).filename().string();
  for (const Chosen& rays : chosen) traces::check_group(options.trace, header, rays.group);
  std::vector<WarpTimeline> timelines(chosen.size());
  if (!options.timeline.empty()) {
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      timelines[i] = read_warp_timeline(options.timeline, reader.content_hash(), chosen[i].group.index);
    }
    page.timeline_config = timelines.front().config_hash;
  }
  FilesRead files;
  std::optional<RayScene> scene;
  if (!options.scene.empty()) {
    ViewOptions view = options.view;
    if (options.command->count("--view") == 0) find_view(header, view);
    scene.emplace(options.trace, header, options.scene, view, files);
  }
  common.files.check(files);

  std::set<std::uint32_t> met;
  std::size_t rays = 0, rounds = 0, events = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const traces::RayGroup& group = chosen[i].group;
    DrawnWarp warp{RayNodes(header, group, chosen[i].lanes), {}, std::move(timelines[i].slices)};
    if (scene) scene->describe(warp.nodes.nodes());
    for (const unsigned lane : chosen[i].lanes) {
      DrawnRay drawn;
      drawn.group = group.index;
      drawn.frame = group.frame;
      drawn.lane = lane;
      drawn.pixel = group.rays[lane].pixel;
      drawn.kind = group.kind;
      std::optional<RayValues> values;
      if (scene) values = scene->trace(group, lane);
      drawn.replayed = replay_ray(header, group, lane, warp.nodes, values ? &*values : nullptr);
      if (values) {
        drawn.traced_again = true;
        drawn.transmittance = values->transmittance;
        drawn.origin = values->origin;
        drawn.direction = values->direction;
      }
      for (const auto& [node, gaussian] : drawn.replayed.learnt) {
        if (!scene) warp.nodes.nodes()[node].gaussian = gaussian;
      }
      met.insert(drawn.replayed.met.begin(), drawn.replayed.met.end());
      ++rays;
      rounds += group.rays[lane].rounds.size();
      events += group.rays[lane].events.size();
      warp.rays.push_back(std::move(drawn));
    }
    page.warps.push_back(std::move(warp));
  }
  for (const std::uint32_t number : met) page.gaussians.push_back(scene->gaussian(number));
  const std::string text = ray_page(page);
  write_file(options.output, text);
  if (common.json) {
    nlohmann::ordered_json json = json_document("ray");
    json["page"] = options.output;
    json["bytes"] = text.size();
    json["rays"] = rays;
    json["rounds"] = rounds;
    json["events"] = events;
    json["traced_again"] = scene.has_value();
    print_json(json);
  } else if (!common.quiet) {
    say("{}: {} ray{}, {} rounds, {} events, {:.3g} MB{}", options.output, rays, rays == 1 ? "" : "s", rounds, events,
        static_cast<double>(text.size()) * 1e-6,
        scene ? "" : "; without --scene and --cameras it has no distances and no view of the boxes");
  }
  return 0;
}

}  // namespace

void add_ray(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<RayArguments>();
  CLI::App* command = make_command(app, common, "ray", "Shows on a page how a ray was traced, event by event",
                                   [options, &common] { return ray(*options, common); });
  options->command = command;
  command->add_option("TRACE", options->trace, "Trace file (no default)")->type_name(kInputFile)->required();
  CLI::Option* pixel =
      command
          ->add_option("--pixel", options->pixel,
                       "The ray of pixel X,Y, and those that glass and mirrors make of it (default: none)")
          ->delimiter(',')
          ->expected(2)
          ->type_name("X,Y");
  command->add_option("--warp", options->warp, "All rays of this warp in place of a pixel's (default: none)")
      ->excludes(pixel);
  command->add_option("--frame", options->frame, "Frame of the pixel, in the trace of a sequence");
  command
      ->add_option("--scene", options->scene,
                   "Scene of the trace: the ray is traced again for its distances, boxes and Gaussians (default: none)")
      ->type_name(kInputFile);
  add_view_options(command, options->view);
  command->get_option("--cameras")
      ->required(false)
      ->description(
          "Cameras of the trace, with --scene: cameras.json, transforms.json or COLMAP folder (default: none)");
  command->get_option("--view")
      ->description("Index of the view in the camera file (default: the trace's)")
      ->default_str("");
  for (const char* name : {"--width", "--height"}) {
    command->get_option(name)->description("Resolution of the trace, in pixels; 0 takes the trace's");
  }
  command->add_option("--timeline", options->timeline, "What 'grtx sim --timeline' wrote: a time axis (default: none)")
      ->type_name(kInputFile);
  command->add_option("-o,--output", options->output, "HTML file to write (no default)")
      ->type_name(kOutputFile)
      ->required();
}

}  // namespace grtx::sim
