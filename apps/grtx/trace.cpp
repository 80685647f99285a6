// SPDX-License-Identifier: Apache-2.0
// grtx trace: the functional tracer. Image, counters and trace of one view.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/experiment/heatmap.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/scene_trace.h"
#include "grtx/experiment/tracer_statistics.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/scene_memory.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::apps {
namespace {

struct TraceArguments {
  std::string scene;
  experiment::ViewOptions view;
  std::string accel = "tri20";
  std::string checkpoint = "off";
  experiment::TracerSettings tracer;
  CLI::App* command = nullptr;
  std::string machine = experiment::kDefaultMachine;
  std::string output;
  std::string image;
  std::string contents;
  std::string statistics;
  std::vector<std::string> heatmaps;
  bool no_trace = false;
  bool flatten = false;
};

const std::vector<std::string>& heatmap_names() {
  static const std::vector<std::string> names = {"visits", "rounds", "blended", "checkpoint_entries"};
  return names;
}

void write_heatmaps(const std::vector<experiment::HeatmapRequest>& heatmaps, const frontend::Camera& camera,
                    const std::vector<frontend::PixelCost>& costs) {
  for (const experiment::HeatmapRequest& heatmap : heatmaps) {
    experiment::Heatmap map{heatmap.name, "a pixel", camera.width, camera.height, {}};
    for (const frontend::PixelCost& cost : costs) {
      const std::uint32_t values[] = {cost.visits, cost.rounds, cost.blended, cost.checkpoints};
      const auto index = std::find(heatmap_names().begin(), heatmap_names().end(), heatmap.name);
      map.values.push_back(values[index - heatmap_names().begin()]);
    }
    experiment::write_heatmap(heatmap.path, map);
  }
}

/// Text for the user on several objects, or on glass and mirror; "" if there are none.
std::string remark(const frontend::SceneTracer& scene, const frontend::TracedView& traced) {
  if (const frontend::MultiObjectWorld* const world = scene.world()) {
    return fmt::format("{} objects of {} files; moving them writes {} of {} B of nodes", world->placed().size(),
                       world->objects().size(), world->update_bytes(), world->image().size());
  }
  if (scene.view()->objects().empty()) return "";
  const frontend::TracerCounters& c = traced.result.secondary;
  return fmt::format("secondary: {} rays in {} groups, {} rounds, {} visits; {}", c.rays, traced.plan.groups.size(),
                     c.rounds, c.visits(), experiment::describe(scene.view()->objects()));
}

int trace(TraceArguments& options, const CommonOptions& common, frontend::SceneTracer& scene) {
  apply_tracer(options.tracer, choose_machine({.machine = options.machine}, common), *options.command);
  if (options.output.empty() && !options.no_trace) {
    throw Error("trace", "-o", "a trace file is needed; --no-trace renders only");
  }
  const bool several = !options.view.views.empty() || (frontend::is_object_list(options.scene) && !options.flatten);
  if (!options.contents.empty() && (options.no_trace || several)) {
    throw Error("--contents", "", "is of one view of one scene, and of the trace that -o writes");
  }
  const frontend::AccelKind kind = frontend::accel_from_name(options.accel);
  const bool checkpoint = options.checkpoint == "on";
  if (!options.image.empty()) frontend::check_image_name(options.image);
  // These throw for invalid options before anything is read.
  experiment::tracer_options(options.tracer, checkpoint, kind);
  experiment::check_secondary(options.tracer.secondary);
  frontend::RenderOptions render = experiment::render_options(options.tracer, common.quiet);
  const bool statistics = common.json || !options.statistics.empty();
  render.count_unique = statistics;
  render.count_hits = statistics;
  const std::vector<experiment::HeatmapRequest> heatmaps =
      experiment::heatmap_requests(options.heatmaps, heatmap_names());
  render.pixel_costs = !heatmaps.empty();
  if (!options.view.views.empty() && !heatmaps.empty())
    throw Error("--heatmap", "", "is of one view: not with --views");
  FilesRead files;
  const std::vector<frontend::Camera> cameras = experiment::select_cameras(options.view, files);
  experiment::load_scene(scene, options.scene, frontend::is_object_list(options.scene) && !options.flatten, cameras,
                         options.tracer, kind, files, common.quiet);
  common.files.check(files);
  const frontend::TracedView traced = experiment::trace_scene(scene, options.tracer, checkpoint, kind, render,
                                                              options.no_trace ? "" : options.output, files);
  const frontend::RenderResult& result = traced.result;
  if (!options.image.empty()) experiment::write_images(options.image, traced);
  if (!options.contents.empty()) {
    frontend::write_scene_memory(options.contents, options.output, *scene.view(), traced);
  }
  write_heatmaps(heatmaps, cameras.front(), result.pixel_costs);

  if (statistics) {
    const nlohmann::ordered_json document =
        experiment::view_document(scene, traced, options.tracer, checkpoint, kind, options.machine);
    if (!options.statistics.empty()) write_file(options.statistics, sim::statistics_text(document));
    if (common.json) print_json(document);
  }
  sim::print_notes({{"trace", experiment::view_notes(traced, options.tracer)}});
  if (!common.quiet && !common.json) {
    const auto& c = result.counters;
    say("{}: {} rays, {} rounds, {:.1f} visits per ray, {} blended, {:.1f} B per Gaussian, {:.3g} Mvisits/s{}",
        options.accel, c.rays, c.rounds,
        static_cast<double>(c.visits()) / static_cast<double>(std::max<std::uint64_t>(1, c.rays)), c.blended,
        static_cast<double>(scene.structure().image.size()) /
            static_cast<double>(std::max<std::uint64_t>(1, scene.gaussians())),
        static_cast<double>(c.visits()) / std::max(result.seconds, 1e-9) * 1e-6,
        traced.trace ? fmt::format(", trace {:.3g} MB", static_cast<double>(traced.trace->bytes) * 1e-6) : "");
    say("{}", experiment::describe_end(result.counters));
    if (const std::string more = remark(scene, traced); !more.empty()) say("{}", more);
  }
  return 0;
}

}  // namespace

void add_trace(CLI::App& app, CommonOptions& common, std::shared_ptr<frontend::SceneTracer> kept) {
  if (kept == nullptr) kept = std::make_shared<frontend::SceneTracer>();
  const auto options = std::make_shared<TraceArguments>();
  CLI::App* command = make_command(app, common, "trace", "Traces a view: trace file, image and counters",
                                   [options, &common, kept] { return trace(*options, common, *kept); });
  command->add_option("--scene", options->scene, "Scene file, or object list .json (no default)")
      ->type_name(kInputFile)
      ->required();
  add_flatten_option(command, options->flatten);
  add_view_options(command, options->view);
  add_views_option(command, options->view);
  command->add_option("--accel", options->accel, "Acceleration structure")
      ->check(one_of(names_of<frontend::AccelKind>()));
  command->add_option("--checkpoint", options->checkpoint, "Checkpointing and replay")->check(one_of({"on", "off"}));
  add_tracer_options(command, options->tracer);
  options->command = command;
  add_machine_option(command, options->machine);
  command->add_option("-o,--output", options->output, "Trace file to write (default: none)")->type_name(kOutputFile);
  command
      ->add_option("--image", options->image,
                   "Image to write: .png, .exr or .pfm; of a sequence one per frame, NAME_0.png on (default: none)")
      ->type_name(kOutputFile);
  command
      ->add_option("--contents", options->contents,
                   "File to write of what lies in memory, for a platform: nodes, records, picture (default: none)")
      ->type_name(kOutputFile);
  command->add_option("--stats", options->statistics, "Statistics JSON to write (default: none)")
      ->type_name(kOutputFile);
  add_heatmap_option(command, options->heatmaps, heatmap_names());
  command->add_flag("--no-trace", options->no_trace, "Render only (default: off)");
}

}  // namespace grtx::apps
