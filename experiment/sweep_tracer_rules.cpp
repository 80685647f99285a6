// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/sweep_tracer_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/files_read.h"
#include "grtx/base/nearest_name.h"
#include "grtx/experiment/option_text.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/scene_tracer.h"

namespace grtx::experiment {
namespace {

using Options = std::map<std::string, std::string>;

/// Does not change the trace, so it must not be part of a trace's key.
constexpr const char* kNotSwept = "threads";

/// Names of the options of `grtx trace`, as on the command line.
std::vector<std::string> swept_names() {
  std::vector<std::string> names;
  for (const TracerOptionName& option : tracer_option_names()) {
    if (option.key != kNotSwept) names.push_back(flag_of(option.key).substr(2));
  }
  names.insert(names.end(), {"accel", "checkpoint"});
  return names;
}

/// Checks `accel` and `checkpoint`, which are no members of TracerSettings. Throws Error{"tracer", "", rule}.
void check_design_option(const std::string& key, const std::string& text) {
  std::string taken;
  const OneOf rule{key == "accel" ? names_of<frontend::AccelKind>() : std::vector<std::string>{"on", "off"}};
  const std::string why = take(flag_of(key), text, taken, rule);
  if (!why.empty()) throw Error("tracer", "", why);
}

/// Parses options as `grtx trace` does. Throws Error{"tracer", option, rule}.
TracerSettings parsed(const Options& options) {
  const std::vector<std::string> known = swept_names();
  for (const auto& [name, value] : options) {
    const std::string flag = flag_of(name);
    if (std::find(known.begin(), known.end(), flag.substr(2)) == known.end()) {
      throw Error("tracer", name,
                  "unknown tracer option '" + name + "', the nearest is '" + nearest_name(flag.substr(2), known) + "'");
    }
  }
  TracerSettings settings;
  for (const auto& [name, value] : options) {
    const std::string key = key_of(name);
    if (key == "accel" || key == "checkpoint") {
      check_design_option(key, value);
      continue;
    }
    try {
      set_option(settings, key, value);
    } catch (const Error& error) {
      throw Error("tracer", "", error.rule());
    }
  }
  return settings;
}

}  // namespace

void SceneTracerRules::check(const std::string& option, const std::string& value) const { parsed({{option, value}}); }

std::map<std::string, std::string> SceneTracerRules::resolve(const std::map<std::string, std::string>& options,
                                                             const std::string& accel, bool checkpoint) const {
  const TracerSettings settings = parsed(options);
  const frontend::AccelKind kind = frontend::accel_from_name(accel);
  tracer_options(settings, checkpoint, kind);
  std::map<std::string, std::string> inputs = option_inputs(settings, checkpoint, kind);
  inputs.merge(placed_inputs(settings.secondary));
  return inputs;
}

std::string SceneTracerRules::structure(const std::map<std::string, std::string>& options,
                                        const std::string& accel) const {
  const TracerSettings settings = parsed(options);
  const frontend::AccelOptions o = accel_options(settings, frontend::accel_from_name(accel));
  const frontend::Kernel kernel = kernel_of(settings.kernel_radius, settings.kernel_degree);
  return fmt::format("{} {} {} {} {} {} {}", accel, o.width, o.corner_bounds, o.box_bits, name_of(o.layout),
                     kernel.adaptive, kernel.degree);
}

explore::SceneInput SceneTracerRules::input(const std::string& scene, const std::string& cameras) const {
  const auto [at, is_new] = read_.try_emplace({scene, cameras});
  if (is_new) {
    FilesRead files;
    (void)frontend::load_cameras(cameras, files);
    frontend::find_files_of_scene(scene, files);
    at->second = {files.hash(), frontend::is_object_list(scene)};
  }
  return at->second;
}

}  // namespace grtx::experiment
