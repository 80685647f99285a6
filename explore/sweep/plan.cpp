// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "grtx/base/error.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/explore/sweep/plan_sections.h"

namespace grtx::explore {
namespace {

constexpr std::size_t kMaxPoints = 100'000;  ///< more is a typing error

/// Reads the sections that only sweep plans have.
class PlanReader {
 public:
  PlanReader(const std::string& path, const TracerRules& tracer) : in_(path, tracer, PlanSections::Roles::none) {}

  SweepPlan read() {
    for (const auto& [name, node] : in_.parse()) top(name, *node);
    SweepPlan& plan = in_.plan;
    if (plan.scenes.empty()) throw Error(plan.path, "scene", "at least one [[scene]] is needed");
    if (in_.sets_design && has_designs_) {
      throw Error(plan.path, designs_place_, "designs: name accel and checkpoint; [tracer] must not set them too");
    }
    if (in_.sets_design) plan.designs.clear();
    if (!varied_) plan.points = {{}};
    for (const Coordinates& point : plan.points) check_structure(point);
    double views = 0.0;
    for (const PlanScene& scene : plan.scenes) views += static_cast<double>(scene.views.size());
    const double designs = static_cast<double>(std::max<std::size_t>(1, plan.designs.size()));
    const double points = static_cast<double>(plan.points.size());
    check_count(views * designs * points, "",
                fmt::format("{} views x {} designs x {} combinations: ", views, designs, points));
    return plan;
  }

 private:
  /// A point has its structure from one place.
  void check_structure(const Coordinates& point) const {
    const auto names = [](const Coordinates& settings, auto... words) {
      return std::ranges::any_of(settings, [&](const auto& setting) { return ((setting.first == words) || ...); });
    };
    const auto sets_structure = [&](const Coordinates& s) { return names(s, "tracer.accel", "tracer.checkpoint"); };
    if (names(point, kDesign) && (sets_structure(point) || sets_structure(in_.plan.settings))) {
      throw Error(in_.plan.path, "", "design: names accel and checkpoint; what has it must not set them too");
    }
  }

  /// Checks the number of points before creating them.
  void check_count(double count, const std::string& place, const std::string& what) const {
    if (count <= kMaxPoints) return;
    throw Error(in_.plan.path, place,
                fmt::format("{}{:.0f} points, of which a plan may have {}", what, count, kMaxPoints));
  }

  Axis read_axis(const std::string& name, const toml::node& node, bool grid) {
    Axis axis;
    axis.name = name;
    axis.place = place_of(node);
    const toml::array* list = node.as_array();
    if (const auto* table = node.as_table()) {
      if (const auto* values = table->get("values")) {
        list = values->as_array();
        if (list == nullptr || table->size() != 1) in_.fail(node, name + ": values must be a list, and stand alone");
      } else {
        read_range(*table, axis, grid);
      }
    } else if (list == nullptr) {
      in_.fail(node, name + ": must be a list of values or a range {from, to, ...}");
    }
    if (list != nullptr) {
      if (list->empty()) in_.fail(node, name + ": the list of values is empty");
      for (const toml::node& item : *list) axis.values.push_back(in_.scalar(item, name));
    }
    for (const SweepValue& value : axis.values) in_.check_varied(node, name, value);
    return axis;
  }

  void read_range(const toml::table& table, Axis& axis, bool grid) {
    bool has_from = false, has_to = false;
    for (const auto& [name, node] : in_.sorted(table)) {
      const std::string full = axis.name + "." + name;
      if (name == "from") {
        axis.from = in_.number(*node, full, -1e15, 1e15);
        has_from = true;
      } else if (name == "to") {
        axis.to = in_.number(*node, full, -1e15, 1e15);
        has_to = true;
      } else if (name == "scale") {
        const std::string scale = in_.text(*node, full);
        if (scale != "linear" && scale != "log") in_.fail(*node, full + ": must be linear or log");
        axis.logarithmic = scale == "log";
      } else if (name == "integer") {
        axis.integer = in_.boolean(*node, full);
      } else if (name == "steps" && grid) {
        axis.steps = static_cast<unsigned>(in_.integer(*node, full, 1, 100000));
      } else {
        in_.unknown(*node, full,
                    {axis.name + ".from", axis.name + ".to", axis.name + ".scale", axis.name + ".integer",
                     axis.name + (grid ? ".steps" : ".values")});
      }
    }
    if (!has_from || !has_to) in_.fail(table, axis.name + ": a range needs from and to");
    if (axis.from > axis.to) in_.fail(table, axis.name + ": from must not be above to");
    if (axis.logarithmic && axis.from <= 0.0) in_.fail(table, axis.name + ": a logarithmic range must be above 0");
    if (axis.integer && (std::floor(axis.from) != axis.from || std::floor(axis.to) != axis.to)) {
      in_.fail(table, axis.name + ": from and to must be integers");
    }
    if (grid && axis.steps == 0) in_.fail(table, axis.name + ": a range in a grid needs steps");
    for (const double share : {0.0, 0.5, std::nextafter(1.0, 0.0)}) {  // checks both ends, the middle and the type
      in_.check_value(table, axis.name, value_at(axis, share));
    }
  }

  std::vector<Axis> read_axes(const toml::table& table, bool grid) {
    std::vector<Axis> axes;
    in_.each_name(table, "", [&](const std::string& name, const toml::node& node) {
      axes.push_back(read_axis(name, node, grid));
    });
    if (axes.empty()) in_.fail(table, "no axis is given");
    return axes;
  }

  void add_points(const toml::node& node, std::vector<Coordinates> points) {
    varied_ = true;
    std::move(points.begin(), points.end(), std::back_inserter(in_.plan.points));
    check_count(static_cast<double>(in_.plan.points.size()), place_of(node), "");
  }

  void read_grid(const toml::node& node) {
    const std::vector<Axis> axes = read_axes(in_.table_of(node, "grid"), true);
    double size = 1.0;
    for (const Axis& axis : axes) size *= static_cast<double>(std::max<std::size_t>(axis.values.size(), axis.steps));
    check_count(size, place_of(node), "grid: ");
    add_points(node, grid_points(axes));
  }

  void read_sampled(const std::string& kind, const toml::node& node) {
    unsigned count = 0;
    std::uint64_t seed = 1;
    std::vector<Axis> axes;
    for (const auto& [name, item] : in_.sorted(in_.table_of(node, kind))) {
      const std::string full = kind + "." + name;
      if (name == "count") {
        const std::uint64_t given = in_.integer(*item, full, 1, std::numeric_limits<std::uint32_t>::max());
        check_count(static_cast<double>(given), place_of(*item), full + ": ");
        count = static_cast<unsigned>(given);
      } else if (name == "seed") {
        seed = in_.integer(*item, full, 0, std::numeric_limits<std::int64_t>::max());
      } else if (name == "axes") {
        axes = read_axes(in_.table_of(*item, full), false);
      } else {
        in_.unknown(*item, full, {kind + ".count", kind + ".seed", kind + ".axes"});
      }
    }
    if (count == 0) in_.fail(node, kind + ": count is needed");
    if (axes.empty()) in_.fail(node, kind + ": axes are needed");
    add_points(node, kind == "latin" ? latin_points(axes, count, seed) : random_points(axes, count, seed));
  }

  void read_list(const toml::node& node) {
    for (const toml::table* table : in_.tables_of(node, "point")) {
      Coordinates point;
      in_.each_name(*table, "", [&](const std::string& name, const toml::node& value) {
        in_.refuse_machine(value, name);
        point.emplace_back(name, in_.scalar(value, name));
        in_.check_varied(value, name, point.back().second);
      });
      add_points(*table, {point});
    }
  }

  void read_designs(const toml::node& node) {
    const auto* list = node.as_array();
    if (list == nullptr || list->empty())
      in_.fail(node, fmt::format("designs: must be a list of {}", fmt::join(design_names(), ", ")));
    in_.plan.designs.clear();
    for (const toml::node& item : *list) in_.plan.designs.push_back(in_.one_of(item, "designs", design_names()));
    has_designs_ = true;
    designs_place_ = place_of(node);
  }

  void top(const std::string& name, const toml::node& node) {
    if (in_.read(name, node)) return;
    if (name == "designs") {
      read_designs(node);
    } else if (name == "confirm") {
      in_.plan.confirm = in_.text(node, name);
    } else if (name == "area") {
      in_.plan.area = in_.one_of(node, name, {kChipArea, kRtUnitArea});
    } else if (name == "grid") {
      read_grid(node);
    } else if (name == "point") {
      read_list(node);
    } else if (name == "random" || name == "latin") {
      read_sampled(name, node);
    } else {
      std::vector<std::string> known = PlanSections::names();
      known.insert(known.end(), {"designs", "confirm", "area", "grid", "point", "random", "latin"});
      in_.unknown(node, name, known);
    }
  }

  PlanSections in_;
  bool has_designs_ = false, varied_ = false;
  std::string designs_place_;
};

}  // namespace

SweepPlan load_plan(const std::string& path, const TracerRules& tracer) { return PlanReader(path, tracer).read(); }

}  // namespace grtx::explore
