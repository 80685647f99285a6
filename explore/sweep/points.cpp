#include "grtx/explore/sweep/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/header.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

std::string key_of(const ordered_json& inputs) { return hex(xxh3(inputs.dump())); }

/// A scene of the plan with what its keys need.
struct Scene {
  const PlanScene* plan = nullptr;
  ordered_json identity;
  std::string file, cameras;
  std::vector<std::string> synth;
};

Scene scene_of(const PlanScene& plan, const std::string& program) {
  Scene scene;
  scene.plan = &plan;
  if (plan.preset.empty()) {
    scene.identity = {{"scene", content_hash(plan.file)}, {"cameras", content_hash(plan.cameras)}};
    scene.file = fs::absolute(plan.file).string();
    scene.cameras = fs::absolute(plan.cameras).string();
  } else {
    scene.identity = {
        {"preset", plan.preset}, {"count", plan.count}, {"seed", plan.seed}, {"sh_degree", plan.sh_degree}};
    const std::string stem = "scene-" + key_of({{"synth", scene.identity}, {"program", program}});
    scene.file = stem + ".ply";
    scene.cameras = stem + ".cameras.json";
    scene.synth = {"--preset",    plan.preset,
                   "--count",     std::to_string(plan.count),
                   "--seed",      std::to_string(plan.seed),
                   "--sh-degree", std::to_string(plan.sh_degree)};
  }
  return scene;
}

struct Structure {
  std::string accel;
  bool checkpoint = false;
};

Structure structure_of(const std::string& design) {
  return {design == "sw" || design == "grtx" ? "tlas-tri20" : "tri20", design == "hw" || design == "grtx"};
}

/// The paper's name of a structure that it has, else a plain description.
std::string design_name(const Structure& s) {
  for (const char* name : {"baseline", "sw", "hw", "grtx"}) {
    const Structure known = structure_of(name);
    if (known.accel == s.accel && known.checkpoint == s.checkpoint) return name;
  }
  return s.accel + (s.checkpoint ? "+checkpoint" : "");
}

/// tracer: resolved options.
std::vector<std::string> cost_arguments(const Structure& s, const ordered_json& tracer) {
  const bool two_level = s.accel.starts_with("tlas-");
  std::vector<std::string> arguments = {"--design",
                                        s.checkpoint ? (two_level ? "grtx" : "hw") : (two_level ? "sw" : "baseline")};
  if (s.accel == "ellipsoid" || s.accel == "tlas-sphere") arguments.push_back("--spheres");
  if (tracer.contains("pop_test")) {
    arguments.insert(arguments.end(), {"--pop-test", tracer.at("pop_test").get<std::string>()});
  }
  return arguments;
}

std::string option_name(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

SweepTrace trace_of(const Scene& scene, unsigned view, const Structure& structure,
                    const std::map<std::string, std::string>& given, const TracerRules& tracer,
                    const std::string& program, std::string& broken) {
  SweepTrace trace;
  trace.scene = scene.plan->name;
  trace.scene_file = scene.file;
  trace.cameras = scene.cameras;
  trace.synth = scene.synth;
  trace.options = scene.identity;
  trace.options["view"] = view;
  trace.options["width"] = scene.plan->width;
  trace.options["height"] = scene.plan->height;
  trace.options["fov_scale"] = scene.plan->fov_scale;
  try {
    trace.options["tracer"] = tracer.resolve(given, structure.accel, structure.checkpoint);
  } catch (const Error& error) {
    trace.options["tracer"] = given;
    broken = error.what();
  }
  trace.options["program"] = program;
  trace.options["trace_format"] = traces::kFormatVersion;
  trace.key = key_of(trace.options);
  const auto& p = *scene.plan;
  trace.arguments = {"--view",   std::to_string(view),     "--width",      std::to_string(p.width),
                     "--height", std::to_string(p.height), "--fov-scale",  fmt::format("{}", p.fov_scale),
                     "--accel",  structure.accel,          "--checkpoint", structure.checkpoint ? "on" : "off"};
  for (const auto& [name, value] : given) {
    trace.arguments.push_back("--" + option_name(name));
    trace.arguments.push_back(value);
  }
  return trace;
}

/// The configuration with a point's values; `broken` says why there is none.
ordered_json config_of(const GpuConfig& base, const Coordinates& values, std::string& broken) {
  GpuConfig config = base;
  const std::vector<modules::Parameter> keys = config_keys(config);
  for (const auto& [name, value] : values) {
    if (!name.starts_with("tracer.")) apply_setting(name + "=" + text_of(value), keys);
  }
  try {
    check_config(config, "configuration");
  } catch (const Error& error) {
    if (broken.empty()) broken = error.what();
  }
  return config_json(config);
}

std::string point_key(const SweepPoint& p, const std::string& program) {
  return key_of({{"trace", p.trace_key}, {"config", p.config}, {"mode", p.mode}, {"program", program}});
}

}  // namespace

std::string content_hash(const std::string& path) {
  if (!fs::exists(path)) throw Error(path, "", "no such file");
  if (!fs::is_directory(path)) return hex(xxh3(read_file(path)));
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  std::string hashes;
  for (const std::string& file : files) {
    hashes += fs::path(file).filename().string() + " " + hex(xxh3(read_file(file))) + "\n";
  }
  return hex(xxh3(hashes));
}

SweepPoints expand(const SweepPlan& plan, const TracerRules& tracer, const std::string& program) {
  SweepPoints all;
  std::set<std::string> traces, points;
  const std::vector<std::string> designs = plan.designs.empty() ? std::vector<std::string>{""} : plan.designs;
  for (const PlanScene& plan_scene : plan.scenes) {
    const Scene scene = scene_of(plan_scene, program);
    for (const unsigned view : plan_scene.views) {
      for (const std::string& design : designs) {
        for (const Coordinates& varied : plan.points) {
          Coordinates values = plan.settings;
          values.insert(values.end(), varied.begin(), varied.end());
          Structure structure = structure_of(design);
          std::map<std::string, std::string> given;
          for (const auto& [name, value] : values) {
            if (!name.starts_with("tracer.")) continue;
            if (name == "tracer.accel") {
              structure.accel = text_of(value);
            } else if (name == "tracer.checkpoint") {
              structure.checkpoint = text_of(value) == "on";
            } else {
              given[name.substr(7)] = text_of(value);
            }
          }
          SweepPoint point;
          SweepTrace trace = trace_of(scene, view, structure, given, tracer, program, point.broken);
          point.trace_key = trace.key;
          point.mode = plan.mode;
          point.scene = plan_scene.name;
          point.design = design_name(structure);
          point.coordinates = ordered_json::object();
          if (plan_scene.views.size() > 1) point.coordinates["view"] = view;
          for (const auto& [name, value] : varied) point.coordinates[name] = value;
          point.config = config_of(plan.machine, values, point.broken);
          point.cost_arguments = cost_arguments(structure, trace.options.at("tracer"));
          point.key = point_key(point, program);
          if (traces.insert(trace.key).second) all.traces.push_back(std::move(trace));
          if (points.insert(point.key).second) all.points.push_back(std::move(point));
        }
      }
    }
  }
  return all;
}

SweepPoint in_mode(const SweepPoint& point, const std::string& mode, const std::string& program) {
  SweepPoint other = point;
  other.mode = mode;
  other.key = point_key(other, program);
  return other;
}

std::string config_toml(const ordered_json& config) {
  std::string text;
  for (const auto& [name, value] : config.items()) text += fmt::format("\"{}\" = {}\n", name, value.dump());
  return text;
}

}  // namespace grtx::sim
