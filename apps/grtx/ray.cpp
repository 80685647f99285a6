// SPDX-License-Identifier: Apache-2.0
// grtx ray: an HTML page that shows how one ray, or the rays of one warp, were traced.
#include <algorithm>
#include <cstdint>
#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/experiment/ray_study.h"
#include "grtx/experiment/slow_rays.h"
#include "grtx/traces/dump.h"
#include "grtx/traces/reader.h"

namespace grtx::apps {
namespace {

struct RayArguments {
  experiment::RayPlan plan;
  std::string output;
  std::size_t slowest = 0;  ///< rays to list in place of a page; 0: none
  CLI::App* command = nullptr;
};

int print_slowest(const RayArguments& options, const CommonOptions& common) {
  const experiment::SlowRays slow = experiment::slowest_rays(traces::Reader(options.plan.trace), options.slowest);
  if (common.json) {
    nlohmann::ordered_json json = json_document("ray");
    json["median_visits"] = slow.median;
    json["slowest"] = nlohmann::ordered_json::array();
    for (const experiment::SlowRay& ray : slow.rays) {
      json["slowest"].push_back({{"pixel", {ray.x, ray.y}},
                                 {"frame", ray.frame},
                                 {"kind", name_of(ray.kind)},
                                 {"warp", ray.warp},
                                 {"visits", ray.visits},
                                 {"rounds", ray.rounds}});
    }
    print_json(json);
    return 0;
  }
  fmt::print("{:<12} {:>8} {:>10} {:>8} {:>8}  {}\n", "pixel", "visits", "of median", "rounds", "warp", "kind");
  for (const experiment::SlowRay& ray : slow.rays) {
    fmt::print("{:<12} {:>8} {:>9.1f}x {:>8} {:>8}  {}{}\n", fmt::format("{},{}", ray.x, ray.y), ray.visits,
               static_cast<double>(ray.visits) / static_cast<double>(std::max<std::uint64_t>(1, slow.median)),
               ray.rounds, ray.warp, name_of(ray.kind), ray.frame == 0 ? "" : fmt::format(", frame {}", ray.frame));
  }
  if (slow.rays.empty() || common.quiet) return 0;
  const experiment::SlowRay& first = slow.rays.front();
  fmt::print("next: grtx ray {} --pixel {},{}{} -o ray.html\n", options.plan.trace, first.x, first.y,
             first.frame == 0 ? "" : fmt::format(" --frame {}", first.frame));
  return 0;
}

int ray(const RayArguments& options, const CommonOptions& common) {
  experiment::RayPlan plan = options.plan;
  if (options.slowest != 0) return print_slowest(options, common);
  if (options.output.empty()) throw Error("ray", "-o", "a page is needed, or --slowest N");
  if (plan.rays.pixel.empty() == !plan.rays.warp)
    throw Error("ray", "--pixel", "which ray? --pixel X,Y, or --warp W; --slowest 10 lists some");
  if (plan.scene.empty() != plan.view.cameras.empty()) {
    throw Error("ray", plan.scene.empty() ? "--cameras" : "--scene",
                "a ray is traced again with both: --scene and --cameras");
  }
  plan.recorded_view = options.command->count("--view") == 0;
  plan.opened = [&common](const FilesRead& files) { common.files.check(files); };
  const experiment::RayStudy study = experiment::study_rays(plan);
  write_file(options.output, study.page);
  if (common.json) {
    nlohmann::ordered_json json = json_document("ray");
    json["page"] = options.output;
    json["bytes"] = study.page.size();
    json["rays"] = study.rays;
    json["rounds"] = study.rounds;
    json["events"] = study.events;
    json["traced_again"] = study.traced_again;
    print_json(json);
  } else if (!common.quiet) {
    say("{}: {} ray{}, {} rounds, {} events, {:.3g} MB{}", options.output, study.rays, study.rays == 1 ? "" : "s",
        study.rounds, study.events, static_cast<double>(study.page.size()) * 1e-6,
        study.traced_again ? "" : "; without --scene and --cameras it has no distances and no view of the boxes");
  }
  return 0;
}

}  // namespace

void add_ray(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<RayArguments>();
  CLI::App* command = make_command(app, common, "ray", "Shows on a page how a ray was traced, event by event",
                                   [options, &common] { return ray(*options, common); });
  options->command = command;
  command->add_option("TRACE", options->plan.trace, "Trace file (no default)")->type_name(kInputFile)->required();
  CLI::Option* pixel =
      command
          ->add_option("--pixel", options->plan.rays.pixel,
                       "The ray of pixel X,Y, and its secondary rays from glass and mirrors (default: none)")
          ->delimiter(',')
          ->expected(2)
          ->type_name("X,Y");
  command->add_option("--warp", options->plan.rays.warp, "All rays of this warp in place of a pixel's (default: none)")
      ->excludes(pixel);
  command->add_option("--frame", options->plan.rays.frame, "Frame of the pixel, in the trace of a sequence");
  command
      ->add_option("--scene", options->plan.scene,
                   "Scene of the trace: the ray is traced again for its distances, boxes and Gaussians (default: none)")
      ->type_name(kInputFile);
  add_view_options(command, options->plan.view);
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
  command
      ->add_option("--image", options->plan.image,
                   "Picture of the view (PNG, JPEG, GIF, WebP), in which the page marks the pixel (default: none)")
      ->type_name(kInputFile);
  command
      ->add_option("--beside", options->plan.beside,
                   "Traces of other designs of the view, in which the page looks at the same pixel (default: none)")
      ->delimiter(',')
      ->type_name(kInputFile)
      ->excludes("--warp");
  command
      ->add_option("--timeline", options->plan.timeline,
                   "File of 'grtx sim --timeline T.json', for a time axis (default: none)")
      ->type_name(kInputFile);
  CLI::Option* output =
      command->add_option("-o,--output", options->output, "HTML file to write (no default)")->type_name(kOutputFile);
  command
      ->add_option("--slowest", options->slowest,
                   "In place of a page: this many pixels whose rays visit the most nodes (default: none)")
      ->default_str("")
      ->check(in_range(1U, 1000000U))
      ->excludes(pixel)
      ->excludes("--warp")
      ->excludes(output);
}

}  // namespace grtx::apps
