// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <filesystem>
#include <unordered_set>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/explore/cost/run_machine.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/header.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

std::string key_of(const ordered_json& inputs) { return hex(xxh3(json_text(inputs))); }

struct Structure {
  std::string accel;
  bool checkpoint = false;
};

bool has(const Structure& s, const Design& design) {
  return s.accel == design.accel && s.checkpoint == design.checkpoint;
}

/// Name of a point's design: the one that it was made from, if it still has its structure; else one that is no more
/// than that structure; else a description.
std::string design_name(const Structure& s, const Design* from) {
  if (from != nullptr && has(s, *from)) return from->name;
  for (const Design& design : designs()) {
    const bool of_structure = std::ranges::all_of(design.tracer, [](const auto& own) { return own.first == "k"; });
    if (has(s, design) && of_structure && design.keys.empty()) return design.name;
  }
  return s.accel + (s.checkpoint ? "+checkpoint" : "");
}

/// tracer: resolved options without defaults; for an incompatible combination, the options as given.
sim::MachineUse machine_use(const Structure& s, ordered_json tracer, bool several_objects) {
  tracer["accel"] = s.accel;
  tracer["checkpoint"] = s.checkpoint ? "on" : "off";
  if (several_objects) tracer["levels"] = "3";
  return machine_of_run(tracer, "tracer");
}

std::string option_name(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

/// Version of the trace format that will be written. Readers accept several versions, but a key must contain the exact
/// one.
std::uint32_t trace_format(const std::string& accel, const ordered_json& tracer, bool several_objects) {
  traces::Header header;
  header.accel = from_name<traces::AccelKind>(accel).value_or(header.accel);
  const auto choose = [&]<typename Enum>(const char* option, Enum& value) {
    if (tracer.contains(option)) value = value_of<Enum>(tracer.at(option).get<std::string>(), "tracer", option);
  };
  choose("pop_test", header.pop_test);
  choose("child_order", header.child_order);
  choose("tracing", header.tracing);
  choose("any_hit", header.any_hit);
  choose("ert_check", header.ert_check);
  choose("opacity_bound", header.opacity_bound);
  choose("colour", header.colour);
  if (tracer.contains("ahead")) header.ahead = 2;
  if (several_objects) header.object_roots.push_back(0);
  if (tracer.contains("checkpoint_bins")) header.checkpoint_bins = 1;
  return traces::format_version(header);
}

}  // namespace

/// A scene of the plan with the inputs of its keys.
struct PointMaker::Scene {
  const PlanScene* plan = nullptr;
  ordered_json identity;
  std::string file, cameras;
  std::vector<std::string> synth;
  SceneInput input;  ///< unset for a generated scene

  Scene(const PlanScene& scene, const TracerRules& tracer, const std::string& program);
  SweepTrace trace(unsigned view, const Structure& structure, const std::map<std::string, std::string>& given,
                   const TracerRules& tracer, const std::string& program, std::string& broken) const;
};

PointMaker::Scene::Scene(const PlanScene& from, const TracerRules& tracer, const std::string& program) : plan(&from) {
  if (from.preset.empty()) {
    input = tracer.input(from.file, from.cameras);
    identity = {{"files", input.files_hash}};
    file = fs::absolute(from.file).string();
    cameras = fs::absolute(from.cameras).string();
  } else {
    identity = {{"preset", from.preset}, {"count", from.count}, {"seed", from.seed}, {"sh_degree", from.sh_degree}};
    const std::string stem = "scene-" + key_of({{"synth", identity}, {"program", program}});
    file = stem + ".ply";
    cameras = stem + ".cameras.json";
    synth = {"--preset",    from.preset,
             "--count",     std::to_string(from.count),
             "--seed",      std::to_string(from.seed),
             "--sh-degree", std::to_string(from.sh_degree)};
  }
}

SweepTrace PointMaker::Scene::trace(unsigned view, const Structure& structure,
                                    const std::map<std::string, std::string>& given, const TracerRules& tracer,
                                    const std::string& program, std::string& broken) const {
  SweepTrace made;
  made.scene = plan->name;
  made.scene_file = file;
  made.cameras = cameras;
  made.synth = synth;
  made.files_hash = input.files_hash;
  made.options = identity;
  made.options["view"] = view;
  made.options["width"] = plan->width;
  made.options["height"] = plan->height;
  made.options["fov_scale"] = plan->fov_scale;
  try {
    made.options["tracer"] = tracer.resolve(given, structure.accel, structure.checkpoint);
    made.structure = tracer.structure(given, structure.accel);
  } catch (const Error& error) {
    made.options["tracer"] = given;
    broken = error.what();
  }
  made.options["program"] = program;
  made.options["trace_format"] = trace_format(structure.accel, made.options.at("tracer"), input.several_objects);
  made.key = key_of(made.options);
  const PlanScene& p = *plan;
  made.arguments = {"--view",   std::to_string(view),     "--width",      std::to_string(p.width),
                    "--height", std::to_string(p.height), "--fov-scale",  fmt::format("{}", p.fov_scale),
                    "--accel",  structure.accel,          "--checkpoint", structure.checkpoint ? "on" : "off"};
  for (const auto& [name, value] : given) {
    made.arguments.push_back("--" + option_name(name));
    made.arguments.push_back(value);
  }
  return made;
}

/// Inputs of a trace; key of the cache.
struct PointMaker::TraceRequest {
  std::size_t scene = 0;
  unsigned view = 0;
  std::string accel;
  bool checkpoint = false;
  std::map<std::string, std::string> options;
  auto operator<=>(const TraceRequest&) const = default;
};

struct PointMaker::ResolvedTrace {
  std::shared_ptr<const SweepTrace> trace;
  std::string broken;
  sim::MachineUse use;
};

PointMaker::PointMaker(const SweepPlan& plan, const TracerRules& tracer, std::string program)
    : plan_(plan),
      tracer_(tracer),
      program_(std::move(program)),
      resolved_(std::make_unique<std::map<TraceRequest, ResolvedTrace>>()) {
  for (const PlanScene& scene : plan.scenes) {
    for (const unsigned view : scene.views) places_.push_back({scenes_.size(), view});
    scenes_.emplace_back(scene, tracer, program_);
  }
}

PointMaker::~PointMaker() = default;

const PointMaker::ResolvedTrace& PointMaker::traced(TraceRequest request) {
  const auto found = resolved_->find(request);
  if (found != resolved_->end()) return found->second;
  const Structure structure{request.accel, request.checkpoint};
  ResolvedTrace made;
  made.trace = std::make_shared<SweepTrace>(
      scenes_.at(request.scene).trace(request.view, structure, request.options, tracer_, program_, made.broken));
  made.use = machine_use(structure, made.trace->options.at("tracer"), scenes_.at(request.scene).input.several_objects);
  return resolved_->emplace(std::move(request), std::move(made)).first->second;
}

PointMaker::TracedPoint PointMaker::make(const Place& place, const std::string& design, const Coordinates& varied) {
  const Design* from = design.empty() ? nullptr : &design_of(design);
  const PlanMachine* machine = &plan_.machine;
  for (const auto& [name, value] : varied) {
    if (name == kDesign) from = &design_of(text_of(value));
    if (name == kMachine) machine = &plan_.machines.at(text_of(value));
  }
  Structure structure{"tri20", false};
  std::map<std::string, std::string> options, named;
  PointConfigs::Settings settings;
  const auto take = [&](const std::string& name, const SweepValue& value) {
    if (name == kDesign || name == kMachine) return;
    if (name == "tracer.accel") {
      structure.accel = text_of(value);
    } else if (name == "tracer.checkpoint") {
      structure.checkpoint = text_of(value) == "on";
    } else if (name.starts_with("tracer.")) {
      named[name.substr(7)] = text_of(value);
    } else {
      settings.emplace_back(name, text_of(value));
    }
  };
  if (from != nullptr) structure = {from->accel, from->checkpoint};
  for (const auto& [name, value] : plan_.settings) take(name, value);
  for (const auto& [name, value] : varied) take(name, value);
  options = tracer_of(from == nullptr ? Design() : *from, machine->tracer, named);
  if (from != nullptr) {  // below what the plan sets
    const Design::Texts own = keys_for(*from, k_of(*from, options.contains("k") ? options.at("k") : ""));
    settings.insert(settings.begin(), own.begin(), own.end());
  }

  const Scene& scene = scenes_.at(place.scene);
  TracedPoint made;
  SweepPoint& point = made.point;
  point.design = design_name(structure, from);
  const ResolvedTrace& known =
      traced({place.scene, place.view, structure.accel, structure.checkpoint, std::move(options)});
  made.trace = known.trace;
  point.broken = known.broken;
  point.use = known.use;
  point.trace_key = made.trace->key;
  point.machine = machine->name;
  point.machine_option = machine->option;
  point.mode = plan_.mode;
  point.scene = scene.plan->name;
  point.coordinates = ordered_json::object();
  if (scene.plan->views.size() > 1) point.coordinates["view"] = place.view;
  for (const auto& [name, value] : varied) {
    if (name != kMachine) point.coordinates[name] = value;  // which every point has
  }
  PointConfigs& configs = configs_.try_emplace(machine->name, machine->config, machine->rivals).first->second;
  point.config = configs.with(settings, point.broken);
  point.key = key_in_mode(point, point.mode, program_);
  return made;
}

SweepPoints expand(const SweepPlan& plan, const TracerRules& tracer, const std::string& program) {
  PointMaker maker(plan, tracer, program);
  SweepPoints all;
  std::unordered_set<std::string> traces, points;
  const std::vector<std::string> designs = plan.designs.empty() ? std::vector<std::string>{""} : plan.designs;
  for (const PointMaker::Place& place : maker.places()) {
    for (const std::string& design : designs) {
      for (const Coordinates& varied : plan.points) {
        PointMaker::TracedPoint made = maker.make(place, design, varied);
        if (traces.insert(made.trace->key).second) all.traces.push_back(std::move(made.trace));
        if (points.insert(made.point.key).second) all.points.push_back(std::move(made.point));
      }
    }
  }
  return all;
}

std::string key_in_mode(const SweepPoint& p, const std::string& mode, const std::string& program) {
  // Text of the JSON object {trace, config, machine, mode, program}, written directly for speed.
  const auto quoted = [](const std::string& text) { return json_text(ordered_json(text)); };
  const std::string files =
      p.config.memory_files().empty() ? "" : fmt::format(R"(,"memory_files":{})", quoted(p.config.memory_files()));
  return hex(
      xxh3(fmt::format(R"({{"trace":{},"config":{},"machine":{},"mode":{},"program":{}{}}})", quoted(p.trace_key),
                       p.config.text(), quoted(p.machine), quoted(mode), quoted(program), files)));
}

SweepPoint in_mode(const SweepPoint& point, const std::string& mode, const std::string& program) {
  SweepPoint other = point;
  other.mode = mode;
  other.key = key_in_mode(point, mode, program);
  return other;
}

void write_config(const std::string& path, const ordered_json& config) {
  // A resolved configuration names every key: the bandwidth lies over the clock in which the times are written.
  const std::string below = fs::path(path).stem().string() + ".below.toml";
  std::string lower, upper = fmt::format("include = \"{}\"\n", below);
  for (const auto& [name, value] : config.items()) {
    (name == "dram.bandwidth_gb_s" ? upper : lower) += fmt::format("\"{}\" = {}\n", name, json_text(value));
  }
  write_file((fs::path(path).parent_path() / below).string(), lower);
  write_file(path, upper);
}

sim::GpuConfig config_from(const ordered_json& config) {
  sim::GpuConfig resolved;
  const std::vector<modules::Parameter> keys = sim::config_keys(resolved);
  for (const auto& [name, value] : config.items()) sim::apply_setting(name + "=" + text_of(value), keys);
  sim::check_config(resolved, "configuration");
  return resolved;
}

}  // namespace grtx::explore
