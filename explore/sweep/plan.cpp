#include "grtx/explore/sweep/plan.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {
namespace {

constexpr std::size_t kMaxPoints = 1'000'000;  ///< more is a mistyped plan

std::string place_of(const toml::node& node) { return fmt::format("line {}", node.source().begin.line); }

/// Reads one plan; every member function throws Error with the line at fault.
class PlanReader {
 public:
  PlanReader(const std::string& path, const TracerRules& tracer) : tracer_(tracer), keys_(config_keys(config_)) {
    plan_.path = path;
    folder_ = std::filesystem::path(path).parent_path();
  }

  SweepPlan read() {
    plan_.text = read_file(plan_.path);
    toml::table table;
    try {
      table = toml::parse(plan_.text, plan_.path);
    } catch (const toml::parse_error& error) {
      throw Error(plan_.path, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
    }
    for (const auto& [name, node] : sorted(table)) top(name, *node);
    if (plan_.scenes.empty()) throw Error(plan_.path, "scene", "at least one [[scene]] is needed");
    if (sets_design_ && has_designs_) {
      throw Error(plan_.path, designs_place_, "designs: name accel and checkpoint; [tracer] must not set them too");
    }
    if (sets_design_) plan_.designs.clear();
    if (!varied_) plan_.points = {{}};
    return plan_;
  }

 private:
  using Entry = std::pair<std::string, const toml::node*>;

  /// toml++ orders a table's keys by name; a plan's order is that of its lines.
  static std::vector<Entry> sorted(const toml::table& table) {
    std::vector<Entry> entries;
    for (const auto& [name, node] : table) entries.emplace_back(std::string(name.str()), &node);
    std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      const auto& x = a.second->source().begin;
      const auto& y = b.second->source().begin;
      return std::pair(x.line, x.column) < std::pair(y.line, y.column);
    });
    return entries;
  }

  [[noreturn]] void fail(const toml::node& node, const std::string& rule) const {
    throw Error(plan_.path, place_of(node), rule);
  }
  [[noreturn]] void unknown(const toml::node& node, const std::string& name,
                            const std::vector<std::string>& known) const {
    fail(node, fmt::format("unknown key '{}', the nearest is '{}'", name, nearest_name(name, known)));
  }

  std::string text(const toml::node& node, const std::string& name) const {
    const auto* value = node.as_string();
    if (value == nullptr || value->get().empty()) fail(node, name + ": must be a text");
    return value->get();
  }
  double number(const toml::node& node, const std::string& name, double min, double max) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !(*value >= min && *value <= max)) fail(node, fmt::format("{}: must be {} to {}", name, min, max));
    return *value;
  }
  std::uint64_t integer(const toml::node& node, const std::string& name, std::int64_t min, std::int64_t max) const {
    const auto* value = node.as_integer();
    if (value == nullptr || value->get() < min || value->get() > max) {
      fail(node, fmt::format("{}: must be an integer, {} to {}", name, min, max));
    }
    return static_cast<std::uint64_t>(value->get());
  }
  const toml::table& table_of(const toml::node& node, const std::string& name) const {
    if (const auto* table = node.as_table()) return *table;
    fail(node, name + ": must be a table");
  }
  std::string path_text(const toml::node& node, const std::string& name) const {
    return (folder_ / text(node, name)).lexically_normal().string();
  }

  SweepValue scalar(const toml::node& node, const std::string& name) const {
    if (const auto* value = node.as_integer()) return value->get();
    if (const auto* value = node.as_floating_point(); value != nullptr && std::isfinite(value->get())) {
      return value->get();
    }
    if (const auto* value = node.as_boolean()) return value->get();
    if (const auto* value = node.as_string()) return value->get();
    fail(node, name + ": must be a single value");
  }

  bool is_key(const std::string& name) const {
    return std::any_of(keys_.begin(), keys_.end(), [&](const modules::Parameter& key) { return key.name == name; });
  }

  /// Sets a scratch configuration, or asks the tracer: whatever refuses says the rule.
  void check_value(const toml::node& node, const std::string& name, const SweepValue& value) {
    try {
      if (name.starts_with("tracer.")) {
        tracer_.check(name.substr(7), text_of(value));
        sets_design_ = sets_design_ || name == "tracer.accel" || name == "tracer.checkpoint";
      } else {
        apply_setting(name + "=" + text_of(value), keys_);
      }
    } catch (const Error& error) {
      fail(node, (error.rule().find(name) == std::string::npos ? name + ": " : "") + error.rule());
    }
  }

  /// Calls `leaf` for each axis or setting in a table, whose names may be dotted or nested.
  void each_name(const toml::table& table, const std::string& prefix,
                 const std::function<void(const std::string&, const toml::node&)>& leaf) {
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

  void read_settings(const toml::table& table, const std::string& prefix, Coordinates& into) {
    each_name(table, prefix, [&](const std::string& name, const toml::node& node) {
      const SweepValue value = scalar(node, name);
      check_value(node, name, value);
      into.emplace_back(name, value);
    });
  }

  Axis read_axis(const std::string& name, const toml::node& node, bool grid) {
    Axis axis;
    axis.name = name;
    axis.place = place_of(node);
    const toml::array* list = node.as_array();
    if (const auto* table = node.as_table()) {
      if (const auto* values = table->get("values")) {
        list = values->as_array();
        if (list == nullptr || table->size() != 1) fail(node, name + ": values must be a list, and stand alone");
      } else {
        read_range(*table, axis, grid);
      }
    } else if (list == nullptr) {
      fail(node, name + ": must be a list of values or a range {from, to, ...}");
    }
    if (list != nullptr) {
      if (list->empty()) fail(node, name + ": the list of values is empty");
      for (const toml::node& item : *list) axis.values.push_back(scalar(item, name));
    }
    for (const SweepValue& value : axis.values) check_value(node, name, value);
    return axis;
  }

  void read_range(const toml::table& table, Axis& axis, bool grid) {
    bool has_from = false, has_to = false;
    for (const auto& [name, node] : sorted(table)) {
      const std::string full = axis.name + "." + name;
      if (name == "from") {
        axis.from = number(*node, full, -1e15, 1e15);
        has_from = true;
      } else if (name == "to") {
        axis.to = number(*node, full, -1e15, 1e15);
        has_to = true;
      } else if (name == "scale") {
        const std::string scale = text(*node, full);
        if (scale != "linear" && scale != "log") fail(*node, full + ": must be linear or log");
        axis.logarithmic = scale == "log";
      } else if (name == "integer") {
        if (!node->is_boolean()) fail(*node, full + ": must be true or false");
        axis.integer = node->as_boolean()->get();
      } else if (name == "steps" && grid) {
        axis.steps = static_cast<unsigned>(integer(*node, full, 1, 100000));
      } else {
        unknown(*node, full,
                {axis.name + ".from", axis.name + ".to", axis.name + ".scale", axis.name + ".integer",
                 axis.name + (grid ? ".steps" : ".values")});
      }
    }
    if (!has_from || !has_to) fail(table, axis.name + ": a range needs from and to");
    if (axis.from > axis.to) fail(table, axis.name + ": from must not be above to");
    if (axis.logarithmic && axis.from <= 0.0) fail(table, axis.name + ": a logarithmic range must be above 0");
    if (axis.integer && (std::floor(axis.from) != axis.from || std::floor(axis.to) != axis.to)) {
      fail(table, axis.name + ": from and to must be integers");
    }
    if (grid && axis.steps == 0) fail(table, axis.name + ": a range in a grid needs steps");
    for (const double share : {0.0, 0.5, std::nextafter(1.0, 0.0)}) {  // the ends are in range, and the type fits
      check_value(table, axis.name, value_at(axis, share));
    }
  }

  std::vector<Axis> read_axes(const toml::table& table, bool grid) {
    std::vector<Axis> axes;
    each_name(table, "",
              [&](const std::string& name, const toml::node& node) { axes.push_back(read_axis(name, node, grid)); });
    if (axes.empty()) fail(table, "no axis is given");
    return axes;
  }

  void add_points(const toml::node& node, const std::vector<Coordinates>& points) {
    varied_ = true;
    plan_.points.insert(plan_.points.end(), points.begin(), points.end());
    if (plan_.points.size() > kMaxPoints) fail(node, fmt::format("more than {} points", kMaxPoints));
  }

  void read_grid(const toml::node& node) {
    const std::vector<Axis> axes = read_axes(table_of(node, "grid"), true);
    double size = 1.0;
    for (const Axis& axis : axes) size *= static_cast<double>(std::max<std::size_t>(axis.values.size(), axis.steps));
    if (size > kMaxPoints) fail(node, fmt::format("more than {} points", kMaxPoints));
    add_points(node, grid_points(axes));
  }

  void read_sampled(const std::string& kind, const toml::node& node) {
    unsigned count = 0;
    std::uint64_t seed = 1;
    std::vector<Axis> axes;
    for (const auto& [name, item] : sorted(table_of(node, kind))) {
      const std::string full = kind + "." + name;
      if (name == "count") {
        count = static_cast<unsigned>(integer(*item, full, 1, static_cast<std::int64_t>(kMaxPoints)));
      } else if (name == "seed") {
        seed = integer(*item, full, 0, std::numeric_limits<std::int64_t>::max());
      } else if (name == "axes") {
        axes = read_axes(table_of(*item, full), false);
      } else {
        unknown(*item, full, {kind + ".count", kind + ".seed", kind + ".axes"});
      }
    }
    if (count == 0) fail(node, kind + ": count is needed");
    if (axes.empty()) fail(node, kind + ": axes are needed");
    add_points(node, kind == "latin" ? latin_points(axes, count, seed) : random_points(axes, count, seed));
  }

  void read_list(const toml::node& node) {
    const auto* list = node.as_array();
    if (list == nullptr || list->empty()) fail(node, "point: must be tables [[point]]");
    for (const toml::node& item : *list) {
      Coordinates point;
      read_settings(table_of(item, "point"), "", point);
      add_points(item, {point});
    }
  }

  void read_scenes(const toml::node& node) {
    const auto* list = node.as_array();
    if (list == nullptr || list->empty()) fail(node, "scene: must be tables [[scene]]");
    for (const toml::node& item : *list) read_scene(table_of(item, "scene"));
  }

  void read_scene(const toml::table& table) {
    PlanScene scene;
    scene.place = place_of(table);
    bool generated_only = false;
    for (const auto& [name, node] : sorted(table)) {
      const std::string full = "scene." + name;
      if (name == "name") {
        scene.name = text(*node, full);
      } else if (name == "file") {
        scene.file = path_text(*node, full);
      } else if (name == "cameras") {
        scene.cameras = path_text(*node, full);
      } else if (name == "preset") {
        scene.preset = text(*node, full);
      } else if (name == "count") {
        scene.count = integer(*node, full, 1, 4294967294);
        generated_only = true;
      } else if (name == "seed") {
        scene.seed = integer(*node, full, 0, std::numeric_limits<std::int64_t>::max());
        generated_only = true;
      } else if (name == "sh_degree") {
        scene.sh_degree = static_cast<unsigned>(integer(*node, full, 0, 3));
        generated_only = true;
      } else if (name == "view") {
        scene.views = {static_cast<unsigned>(integer(*node, full, 0, 1'000'000))};
      } else if (name == "views") {
        const auto* views = node->as_array();
        if (views == nullptr || views->empty()) fail(*node, full + ": must be a list of indices");
        scene.views.clear();
        for (const toml::node& view : *views) {
          scene.views.push_back(static_cast<unsigned>(integer(view, full, 0, 1'000'000)));
        }
      } else if (name == "width") {
        scene.width = static_cast<unsigned>(integer(*node, full, 0, 65536));
      } else if (name == "height") {
        scene.height = static_cast<unsigned>(integer(*node, full, 0, 65536));
      } else if (name == "fov_scale") {
        scene.fov_scale = number(*node, full, 1e-3, 1e3);
      } else {
        unknown(*node, full,
                {"scene.name", "scene.file", "scene.cameras", "scene.preset", "scene.count", "scene.seed",
                 "scene.sh_degree", "scene.view", "scene.views", "scene.width", "scene.height", "scene.fov_scale"});
      }
    }
    if (scene.file.empty() == scene.preset.empty()) {
      fail(table, "scene: needs either file and cameras, or preset (with count and seed)");
    }
    if (!scene.file.empty() && scene.cameras.empty()) fail(table, "scene: cameras are needed");
    if (!scene.file.empty() && generated_only) fail(table, "scene: count, seed and sh_degree are for a preset");
    if (!scene.preset.empty() && !scene.cameras.empty()) fail(table, "scene: a preset brings its own cameras");
    if (scene.name.empty()) {
      scene.name = scene.preset.empty() ? std::filesystem::path(scene.file).stem().string()
                                        : fmt::format("{}-{}-{}", scene.preset, scene.count, scene.seed);
    }
    for (const PlanScene& other : plan_.scenes) {
      if (other.name == scene.name) fail(table, fmt::format("scene: two scenes are named '{}'", scene.name));
    }
    plan_.scenes.push_back(scene);
  }

  void read_designs(const toml::node& node) {
    const auto* list = node.as_array();
    if (list == nullptr || list->empty()) fail(node, "designs: must be a list of baseline, sw, hw, grtx");
    static const std::vector<std::string> known = {"baseline", "sw", "hw", "grtx"};
    plan_.designs.clear();
    for (const toml::node& item : *list) {
      const std::string name = text(item, "designs");
      if (std::find(known.begin(), known.end(), name) == known.end()) {
        fail(item, fmt::format("designs: unknown '{}', the nearest is '{}'", name, nearest_name(name, known)));
      }
      plan_.designs.push_back(name);
    }
    has_designs_ = true;
    designs_place_ = place_of(node);
  }

  void top(const std::string& name, const toml::node& node) {
    if (name == "scene") {
      read_scenes(node);
    } else if (name == "designs") {
      read_designs(node);
    } else if (name == "mode") {
      plan_.mode = text(node, name);
    } else if (name == "confirm") {
      plan_.confirm = text(node, name);
    } else if (name == "base") {
      plan_.base = path_text(node, name);
      try {
        plan_.machine = load_config(plan_.base, {});
      } catch (const Error& error) {
        if (error.file() == plan_.base && error.place().empty()) fail(node, "base: " + std::string(error.what()));
        throw;
      }
    } else if (name == "set") {
      read_settings(table_of(node, name), "", plan_.settings);
    } else if (name == "tracer") {
      read_settings(table_of(node, name), "tracer.", plan_.settings);
    } else if (name == "limits") {
      for (const auto& [key, item] : sorted(table_of(node, name))) {
        if (key == "seconds") {
          plan_.limits.seconds = number(*item, "limits.seconds", 0.01, 1e7);
        } else if (key == "memory_mb") {
          plan_.limits.memory_mb = number(*item, "limits.memory_mb", 1.0, 1e7);
        } else {
          unknown(*item, "limits." + key, {"limits.seconds", "limits.memory_mb"});
        }
      }
    } else if (name == "grid") {
      read_grid(node);
    } else if (name == "point") {
      read_list(node);
    } else if (name == "random" || name == "latin") {
      read_sampled(name, node);
    } else {
      unknown(node, name,
              {"scene", "designs", "mode", "confirm", "base", "set", "tracer", "limits", "grid", "point", "random",
               "latin"});
    }
  }

  const TracerRules& tracer_;
  GpuConfig config_;  ///< scratch: each value is tried on it alone
  std::vector<modules::Parameter> keys_;
  std::filesystem::path folder_;
  SweepPlan plan_;
  bool sets_design_ = false, has_designs_ = false, varied_ = false;
  std::string designs_place_;
};

}  // namespace

SweepPlan load_plan(const std::string& path, const TracerRules& tracer) { return PlanReader(path, tracer).read(); }

}  // namespace grtx::sim
