// SPDX-License-Identifier: Apache-2.0
// Common sections of sweep and search plans: scenes, mode, machine, base, [set], [tracer], [limits], and functions that
// read and check values. Internal to plan.cpp and search_plan.cpp; needs toml++.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <functional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "grtx/explore/sweep/plan.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::explore {

/// "line N" of the plan.
std::string place_of(const toml::node& node);

/// Reads one plan; every member function throws Error with the line number.
class PlanSections {
 public:
  enum class Roles { none, search_and_evaluation };  ///< allowed values of a scene's `role`
  using Entry = std::pair<std::string, const toml::node*>;

  PlanSections(const std::string& path, const TracerRules& tracer, Roles roles);
  PlanSections(const PlanSections&) = delete;
  PlanSections& operator=(const PlanSections&) = delete;

  /// Parses the file; returns the top-level entries in file order.
  std::vector<Entry> parse();
  /// Reads a common section; returns false if `name` is no common section.
  bool read(const std::string& name, const toml::node& node);
  /// Names of the sections that read() takes.
  static const std::vector<std::string>& names();

  /// Entries in file order; toml++ orders the keys of a table by name.
  static std::vector<Entry> sorted(const toml::table& table);
  [[noreturn]] void fail(const toml::node& node, const std::string& rule) const;
  [[noreturn]] void unknown(const toml::node& node, const std::string& name,
                            const std::vector<std::string>& known) const;
  /// Throws Error if `name` says "machine" where a plan has none.
  void refuse_machine(const toml::node& node, const std::string& name) const;
  std::string text(const toml::node& node, const std::string& name) const;
  std::string one_of(const toml::node& node, const std::string& name, const std::vector<std::string>& known) const;
  double number(const toml::node& node, const std::string& name, double min, double max) const;
  std::uint64_t integer(const toml::node& node, const std::string& name, std::int64_t min, std::int64_t max) const;
  bool boolean(const toml::node& node, const std::string& name) const;
  const toml::table& table_of(const toml::node& node, const std::string& name) const;
  /// The tables of [[name]]; there must be at least one.
  std::vector<const toml::table*> tables_of(const toml::node& node, const std::string& name) const;
  /// A path, resolved relative to the plan's folder.
  std::string path_text(const toml::node& node, const std::string& name) const;
  SweepValue scalar(const toml::node& node, const std::string& name) const;
  /// A non-empty list of values.
  std::vector<SweepValue> scalars(const toml::node& node, const std::string& name) const;

  /// Checks a value by setting it in a scratch configuration, or by TracerRules for a tracer option.
  void check_value(const toml::node& node, const std::string& name, const SweepValue& value);
  /// The same for what a plan varies, which may also be the design or the machine.
  void check_varied(const toml::node& node, const std::string& name, const SweepValue& value);
  /// Calls `leaf` for each axis or setting in a table, whose names may be dotted or nested.
  void each_name(const toml::table& table, const std::string& prefix,
                 const std::function<void(const std::string&, const toml::node&)>& leaf) const;
  /// Checked settings of a table.
  void read_settings(const toml::table& table, const std::string& prefix, Coordinates& into);

  SweepPlan plan;            ///< filled by read()
  bool sets_design = false;  ///< tracer.accel or tracer.checkpoint was set somewhere

 private:
  void read_scenes(const toml::node& node);
  void read_scene(const toml::table& table);
  /// Reads the key `name` of a scene. full: name in messages. Returns false if this function does not handle the key.
  bool read_scene_source(PlanScene& scene, const std::string& name, const toml::node& node,
                         const std::string& full) const;
  bool read_scene_view(PlanScene& scene, const std::string& name, const toml::node& node,
                       const std::string& full) const;
  void check_scene(const toml::table& table, const PlanScene& scene) const;
  void read_limits(const toml::node& node);
  bool is_key(const std::string& name) const;
  /// The text of --machine for a machine of the plan: a file is relative to the plan's folder.
  std::string machine_text(const std::string& name) const;

  const TracerRules& tracer_;
  Roles roles_;
  sim::GpuConfig config_;  ///< scratch, for checking one value at a time
  std::vector<modules::Parameter> keys_;
  std::unordered_set<std::string> taken_;  ///< settings already checked; lists of points repeat them
  std::filesystem::path folder_;
  toml::table table_;
};

}  // namespace grtx::explore
