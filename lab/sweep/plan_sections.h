// What the plans of sweeps and searches have in common: scenes, mode, base, [set], [tracer], [limits], and how a value
// is read and checked. For plan.cpp and search_plan.cpp; needs toml++.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <functional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "grtx/lab/sweep/plan.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// "line N" of the plan.
std::string place_of(const toml::node& node);

/// Reads one plan; every member function throws Error with the line at fault.
class PlanSections {
 public:
  enum class Roles { none, search_and_evaluation };  ///< of scenes
  using Entry = std::pair<std::string, const toml::node*>;

  PlanSections(const std::string& path, const TracerRules& tracer, Roles roles);
  PlanSections(const PlanSections&) = delete;
  PlanSections& operator=(const PlanSections&) = delete;

  /// The whole plan's entries, in the order of its lines.
  std::vector<Entry> parse();
  /// Reads a section that all plans have; false when it is none.
  bool read(const std::string& name, const toml::node& node);
  /// Names of the sections that read() takes.
  static const std::vector<std::string>& names();

  /// toml++ orders a table's keys by name; a plan's order is that of its lines.
  static std::vector<Entry> sorted(const toml::table& table);
  [[noreturn]] void fail(const toml::node& node, const std::string& rule) const;
  [[noreturn]] void unknown(const toml::node& node, const std::string& name,
                            const std::vector<std::string>& known) const;
  std::string text(const toml::node& node, const std::string& name) const;
  std::string one_of(const toml::node& node, const std::string& name, const std::vector<std::string>& known) const;
  double number(const toml::node& node, const std::string& name, double min, double max) const;
  std::uint64_t integer(const toml::node& node, const std::string& name, std::int64_t min, std::int64_t max) const;
  bool boolean(const toml::node& node, const std::string& name) const;
  const toml::table& table_of(const toml::node& node, const std::string& name) const;
  /// The tables of [[name]], at least one.
  std::vector<const toml::table*> tables_of(const toml::node& node, const std::string& name) const;
  /// A path relative to the plan's folder.
  std::string path_text(const toml::node& node, const std::string& name) const;
  SweepValue scalar(const toml::node& node, const std::string& name) const;
  /// A list of at least one value.
  std::vector<SweepValue> scalars(const toml::node& node, const std::string& name) const;

  /// Sets a scratch configuration, or asks the tracer: whatever refuses says the rule.
  void check_value(const toml::node& node, const std::string& name, const SweepValue& value);
  /// Calls `leaf` for each axis or setting in a table, whose names may be dotted or nested.
  void each_name(const toml::table& table, const std::string& prefix,
                 const std::function<void(const std::string&, const toml::node&)>& leaf) const;
  /// Checked settings of a table.
  void read_settings(const toml::table& table, const std::string& prefix, Coordinates& into);

  SweepPlan plan;            ///< what was read
  bool sets_design = false;  ///< tracer.accel or tracer.checkpoint was set somewhere

 private:
  void read_scenes(const toml::node& node);
  void read_scene(const toml::table& table);
  /// The key `name` of a scene, written `full` in messages. Returns false for keys of another kind.
  bool read_scene_source(PlanScene& scene, const std::string& name, const toml::node& node,
                         const std::string& full) const;
  bool read_scene_view(PlanScene& scene, const std::string& name, const toml::node& node,
                       const std::string& full) const;
  void check_scene(const toml::table& table, const PlanScene& scene) const;
  void read_limits(const toml::node& node);
  bool is_key(const std::string& name) const;

  const TracerRules& tracer_;
  Roles roles_;
  GpuConfig config_;  ///< scratch: each value is tried on it alone
  std::vector<modules::Parameter> keys_;
  std::unordered_set<std::string> taken_;  ///< settings found good: a list of points repeats them
  std::filesystem::path folder_;
  toml::table table_;
};

}  // namespace grtx::sim
