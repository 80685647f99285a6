#include "grtx/apps/grtx/sweep_tracer_rules.h"

#include <fmt/format.h>

#include <algorithm>

#include "grtx/apps/grtx/machine.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/base/error.h"
#include "grtx/base/files_read.h"
#include "grtx/base/nearest_name.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/scene_tracer.h"

namespace grtx::sim {
namespace {

/// Options that change no byte of a trace have no place in its key.
bool is_swept(const std::string& flag) { return flag != "--threads" && flag != "--help"; }

/// Parses options as `grtx trace` would. Throws Error{"tracer", option, rule}.
TracerCli parsed(const std::map<std::string, std::string>& options) {
  CLI::App app;
  TracerCli cli;
  std::string accel, checkpoint;
  add_tracer_options(&app, cli);
  app.add_option("--accel", accel)->check(one_of(names_of<frontend::AccelKind>()));
  app.add_option("--checkpoint", checkpoint)->check(one_of({"on", "off"}));
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      if (is_swept("--" + name)) known.push_back(name);
    }
  }
  std::vector<std::string> arguments;
  for (const auto& [name, value] : options) {
    const std::string flag = flag_of(name);
    if (std::find(known.begin(), known.end(), flag.substr(2)) == known.end()) {
      throw Error("tracer", name,
                  "unknown tracer option '" + name + "', the nearest is '" + nearest_name(flag.substr(2), known) + "'");
    }
    arguments.push_back(flag + "=" + value);
  }
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    throw Error("tracer", "", error.what());
  }
  return cli;
}

}  // namespace

void CliTracerRules::check(const std::string& option, const std::string& value) const { parsed({{option, value}}); }

std::map<std::string, std::string> CliTracerRules::resolve(const std::map<std::string, std::string>& options,
                                                           const std::string& accel, bool checkpoint) const {
  const TracerCli cli = parsed(options);
  const frontend::AccelKind kind = frontend::accel_from_name(accel);
  tracer_options(cli, checkpoint, kind);
  std::map<std::string, std::string> inputs = option_inputs(cli, checkpoint, kind);
  inputs.merge(placed_inputs(cli.secondary));
  return inputs;
}

std::string CliTracerRules::structure(const std::map<std::string, std::string>& options,
                                      const std::string& accel) const {
  const TracerCli cli = parsed(options);
  const frontend::AccelOptions o = accel_options(cli, frontend::accel_from_name(accel));
  const frontend::Kernel kernel = kernel_of(cli.kernel_radius, cli.kernel_degree);
  return fmt::format("{} {} {} {} {} {} {}", accel, o.width, o.corner_bounds, o.box_bits, name_of(o.layout),
                     kernel.adaptive, kernel.degree);
}

SceneInput CliTracerRules::input(const std::string& scene, const std::string& cameras) const {
  const auto [at, is_new] = read_.try_emplace({scene, cameras});
  if (is_new) {
    FilesRead files;
    (void)frontend::load_cameras(cameras, files);
    frontend::find_files_of_scene(scene, files);
    at->second = {files.hash(), frontend::is_object_list(scene)};
  }
  return at->second;
}

}  // namespace grtx::sim
