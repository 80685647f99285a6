// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/plan_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/base/printable.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/config/config_file.h"

namespace grtx::explore {

std::string place_of(const toml::node& node) { return fmt::format("line {}", node.source().begin.line); }

PlanSections::PlanSections(const std::string& path, const TracerRules& tracer, Roles roles)
    : tracer_(tracer), roles_(roles), keys_(sim::config_keys(config_)) {
  plan.path = path;
  folder_ = std::filesystem::path(path).parent_path();
}

std::vector<PlanSections::Entry> PlanSections::parse() {
  plan.text = read_file(plan.path);
  try {
    table_ = toml::parse(plan.text, plan.path);
  } catch (const toml::parse_error& error) {
    throw Error(plan.path, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
  }
  return sorted(table_);
}

const std::vector<std::string>& PlanSections::names() {
  static const std::vector<std::string> names = {"scene", "mode", "machine", "base", "set", "tracer", "limits"};
  return names;
}

bool PlanSections::read(const std::string& name, const toml::node& node) {
  if (name == "scene") {
    read_scenes(node);
  } else if (name == "mode") {
    plan.mode = text(node, name);
  } else if (name == kMachine) {
    plan.machine_asked = machine_text(text(node, name));
  } else if (name == "base") {
    plan.base = path_text(node, name);
    try {
      sim::LoadedConfig loaded = sim::load_machine({.file = plan.base});
      plan.machine.config = std::move(loaded.config);
      plan.machine.rivals = loaded.rivals;
    } catch (const Error& error) {
      if (error.file() == plan.base && error.place().empty()) fail(node, "base: " + std::string(error.what()));
      throw;
    }
  } else if (name == "set") {
    read_settings(table_of(node, name), "", plan.settings);
  } else if (name == "tracer") {
    read_settings(table_of(node, name), "tracer.", plan.settings);
  } else if (name == "limits") {
    read_limits(node);
  } else {
    return false;
  }
  return true;
}

std::vector<PlanSections::Entry> PlanSections::sorted(const toml::table& table) {
  std::vector<Entry> entries;
  for (const auto& [name, node] : table) entries.emplace_back(std::string(name.str()), &node);
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    const auto& x = a.second->source().begin;
    const auto& y = b.second->source().begin;
    return std::pair(x.line, x.column) < std::pair(y.line, y.column);
  });
  return entries;
}

void PlanSections::fail(const toml::node& node, const std::string& rule) const {
  throw Error(plan.path, place_of(node), rule);
}

void PlanSections::unknown(const toml::node& node, const std::string& name,
                           const std::vector<std::string>& known) const {
  refuse_machine(node, name);
  fail(node, fmt::format("unknown key '{}', {}", name, nearest_keys(name, known)));
}

void PlanSections::refuse_machine(const toml::node& node, const std::string& name) const {
  if (name != "machine" && !name.ends_with(".machine")) return;
  fail(node, "machine: stands at the top of a plan, for all points, or is varied, as the design is");
}

std::string PlanSections::text(const toml::node& node, const std::string& name) const {
  const auto* value = node.as_string();
  if (value == nullptr || value->get().empty()) fail(node, name + ": must be a text");
  return value->get();
}

std::string PlanSections::one_of(const toml::node& node, const std::string& name,
                                 const std::vector<std::string>& known) const {
  const std::string word = text(node, name);
  if (std::find(known.begin(), known.end(), word) == known.end()) {
    fail(node, fmt::format("{}: unknown '{}', the nearest is '{}'", name, word, nearest_name(word, known)));
  }
  return word;
}

double PlanSections::number(const toml::node& node, const std::string& name, double min, double max) const {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !(*value >= min && *value <= max)) fail(node, fmt::format("{}: must be {} to {}", name, min, max));
  return *value;
}

std::uint64_t PlanSections::integer(const toml::node& node, const std::string& name, std::int64_t min,
                                    std::int64_t max) const {
  const auto* value = node.as_integer();
  if (value == nullptr || value->get() < min || value->get() > max) {
    fail(node, fmt::format("{}: must be an integer, {} to {}", name, min, max));
  }
  return static_cast<std::uint64_t>(value->get());
}

bool PlanSections::boolean(const toml::node& node, const std::string& name) const {
  if (!node.is_boolean()) fail(node, name + ": must be true or false");
  return node.as_boolean()->get();
}

const toml::table& PlanSections::table_of(const toml::node& node, const std::string& name) const {
  if (const auto* table = node.as_table()) return *table;
  fail(node, name + ": must be a table");
}

std::vector<const toml::table*> PlanSections::tables_of(const toml::node& node, const std::string& name) const {
  const auto* list = node.as_array();
  if (list == nullptr || list->empty()) fail(node, fmt::format("{0}: must be tables [[{0}]]", name));
  std::vector<const toml::table*> tables;
  for (const toml::node& item : *list) tables.push_back(&table_of(item, name));
  return tables;
}

std::string PlanSections::path_text(const toml::node& node, const std::string& name) const {
  return (folder_ / text(node, name)).lexically_normal().string();
}

SweepValue PlanSections::scalar(const toml::node& node, const std::string& name) const {
  if (const auto* value = node.as_integer()) return value->get();
  if (const auto* value = node.as_floating_point(); value != nullptr && std::isfinite(value->get())) {
    return value->get();
  }
  if (const auto* value = node.as_boolean()) return value->get();
  if (const auto* value = node.as_string()) return value->get();
  fail(node, name + ": must be a single value");
}

std::vector<SweepValue> PlanSections::scalars(const toml::node& node, const std::string& name) const {
  const auto* list = node.as_array();
  if (list == nullptr) fail(node, name + ": must be a list of values");
  if (list->empty()) fail(node, name + ": the list of values is empty");
  std::vector<SweepValue> values;
  for (const toml::node& item : *list) values.push_back(scalar(item, name));
  return values;
}

std::string PlanSections::machine_text(const std::string& name) const {
  return name.ends_with(".toml") ? (folder_ / name).lexically_normal().string() : name;
}

bool PlanSections::is_key(const std::string& name) const {
  return std::any_of(keys_.begin(), keys_.end(), [&](const modules::Parameter& key) { return key.name == name; });
}

void PlanSections::check_value(const toml::node& node, const std::string& name, const SweepValue& value) {
  const std::string setting = name + "=" + text_of(value);
  if (taken_.contains(setting)) return;
  try {
    if (name.starts_with("tracer.")) {
      tracer_.check(name.substr(7), text_of(value));
      sets_design = sets_design || name == "tracer.accel" || name == "tracer.checkpoint";
    } else {
      sim::apply_setting(setting, keys_);
    }
    taken_.insert(setting);
  } catch (const Error& error) {
    fail(node, (error.rule().find(name) == std::string::npos ? name + ": " : "") + error.rule());
  }
}

void PlanSections::check_varied(const toml::node& node, const std::string& name, const SweepValue& value) {
  if (name == kMachine) {
    if (!value.is_string() || text_of(value).empty()) fail(node, "machine: must be a name, or a file .toml");
    plan.varied_machines.try_emplace(text_of(value), VariedMachine{machine_text(text_of(value)), place_of(node)});
    return;
  }
  if (name != kDesign) return check_value(node, name, value);
  const std::string word = text_of(value);
  if (std::ranges::find(design_names(), word) == design_names().end()) {
    fail(node, fmt::format("design: unknown '{}', the nearest is '{}'", word, nearest_name(word, design_names())));
  }
}

void PlanSections::each_name(const toml::table& table, const std::string& prefix,
                             const std::function<void(const std::string&, const toml::node&)>& leaf) const {
  for (const auto& [name, node] : sorted(table)) {
    const std::string full = prefix + name;
    const auto* inner = node->as_table();
    const bool is_range = inner != nullptr && (inner->contains("from") || inner->contains("values"));
    if (inner != nullptr && !is_range && !is_key(full)) {
      each_name(*inner, full + ".", leaf);
    } else {
      leaf(full, *node);
    }
  }
}

void PlanSections::read_settings(const toml::table& table, const std::string& prefix, Coordinates& into) {
  each_name(table, prefix, [&](const std::string& name, const toml::node& node) {
    refuse_machine(node, name);
    const SweepValue value = scalar(node, name);
    check_value(node, name, value);
    into.emplace_back(name, value);
  });
}

void PlanSections::read_scenes(const toml::node& node) {
  for (const toml::table* table : tables_of(node, "scene")) read_scene(*table);
}

void PlanSections::read_scene(const toml::table& table) {
  PlanScene scene;
  scene.place = place_of(table);
  for (const auto& [name, node] : sorted(table)) {
    const std::string full = "scene." + name;
    if (!read_scene_source(scene, name, *node, full) && !read_scene_view(scene, name, *node, full)) {
      unknown(*node, full,
              {"scene.name", "scene.file", "scene.cameras", "scene.preset", "scene.count", "scene.seed",
               "scene.sh_degree", "scene.view", "scene.views", "scene.width", "scene.height", "scene.fov_scale"});
    }
  }
  check_scene(table, scene);
  if (scene.name.empty()) {
    scene.name = scene.preset.empty() ? std::filesystem::path(scene.file).stem().string()
                                      : fmt::format("{}-{}-{}", scene.preset, scene.count, scene.seed);
  }
  for (const PlanScene& other : plan.scenes) {
    if (other.name == scene.name) fail(table, fmt::format("scene: two scenes are named '{}'", scene.name));
  }
  plan.scenes.push_back(scene);
}

bool PlanSections::read_scene_source(PlanScene& scene, const std::string& name, const toml::node& node,
                                     const std::string& full) const {
  if (name == "name") {
    scene.name = text(node, full);
    if (printable(scene.name) != scene.name) fail(node, full + ": must have no control characters");
  } else if (name == "file") {
    scene.file = path_text(node, full);
  } else if (name == "cameras") {
    scene.cameras = path_text(node, full);
  } else if (name == "preset") {
    scene.preset = text(node, full);
  } else if (name == "count") {
    scene.count = integer(node, full, 1, 4294967294);
  } else if (name == "seed") {
    scene.seed = integer(node, full, 0, std::numeric_limits<std::int64_t>::max());
  } else if (name == "sh_degree") {
    scene.sh_degree = static_cast<unsigned>(integer(node, full, 0, 3));
  } else if (name == "role" && roles_ == Roles::search_and_evaluation) {
    scene.evaluation = one_of(node, full, {"search", "evaluation"}) == "evaluation";
  } else {
    return false;
  }
  return true;
}

bool PlanSections::read_scene_view(PlanScene& scene, const std::string& name, const toml::node& node,
                                   const std::string& full) const {
  if (name == "view") {
    scene.views = {static_cast<unsigned>(integer(node, full, 0, 1'000'000))};
  } else if (name == "views") {
    const auto* views = node.as_array();
    if (views == nullptr || views->empty()) fail(node, full + ": must be a list of indices");
    scene.views.clear();
    for (const toml::node& view : *views) {
      scene.views.push_back(static_cast<unsigned>(integer(view, full, 0, 1'000'000)));
    }
  } else if (name == "width") {
    scene.width = static_cast<unsigned>(integer(node, full, 0, 65536));
  } else if (name == "height") {
    scene.height = static_cast<unsigned>(integer(node, full, 0, 65536));
  } else if (name == "fov_scale") {
    scene.fov_scale = number(node, full, 1e-3, 1e3);
  } else {
    return false;
  }
  return true;
}

void PlanSections::check_scene(const toml::table& table, const PlanScene& scene) const {
  const bool generated = table.contains("count") || table.contains("seed") || table.contains("sh_degree");
  if (scene.file.empty() == scene.preset.empty()) {
    fail(table, "scene: needs either file and cameras, or preset (with count and seed)");
  }
  if (!scene.file.empty() && scene.cameras.empty()) fail(table, "scene: cameras are needed");
  if (!scene.file.empty() && generated) fail(table, "scene: count, seed and sh_degree are for a preset");
  if (!scene.preset.empty() && !scene.cameras.empty()) fail(table, "scene: a preset brings its own cameras");
}

void PlanSections::read_limits(const toml::node& node) {
  for (const auto& [key, item] : sorted(table_of(node, "limits"))) {
    if (key == "seconds") {
      plan.limits.seconds = number(*item, "limits.seconds", 0.01, 1e7);
    } else if (key == "memory_mb") {
      plan.limits.memory_mb = number(*item, "limits.memory_mb", 1.0, 1e7);
    } else {
      unknown(*item, "limits." + key, {"limits.seconds", "limits.memory_mb"});
    }
  }
}

}  // namespace grtx::explore
