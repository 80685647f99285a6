// SPDX-License-Identifier: Apache-2.0
// The subject of a result: machine, view, options, mode and model version. Results may be compared or averaged only if
// their subjects match; this class decides that, for runs and for points of sweeps. Options and keys that a design
// brings with it (explore/sweep/designs.h) are part of the design.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace grtx::report {

/// Differences that are allowed between two results.
enum class MayDiffer {
  designs,  ///< acceleration structure, checkpointing, and what a design brings; ratios are speed-ups
  views,    ///< scene and camera at the same resolution; means are over views
  machines  ///< the machine, its keys, and options of the tracer that follow from a machine; times are compared
};

/// Name of the design of these inputs (of grtx.stats/1) and this configuration: its structure, checkpointing, and those
/// of its keys that are no number; of several the one with most of them. A structure's name, as in
/// "ellipsoid+checkpoint", if no design has it; "" if unknown.
std::string design_name(const nlohmann::ordered_json& inputs, const nlohmann::ordered_json& config);

/// A property in which results differ, for display: "ert", "0.01".
struct Fact {
  std::string name, value;
};

class Subject {
 public:
  Subject() = default;
  /// inputs: of grtx.stats/1. config: resolved, key -> value. more: inputs known from elsewhere, which override
  /// `inputs` unless "".
  Subject(const nlohmann::ordered_json& inputs, const nlohmann::ordered_json& config,
          const std::map<std::string, std::string>& more = {});

  /// The scene's file name without extension, and the camera's name; "" if not recorded.
  const std::string& scene() const { return scene_; }
  const std::string& camera() const { return camera_; }
  /// An input that does not describe the view: "machine", "mode", "k", "width". "" if missing.
  std::string setting(const std::string& name) const;
  /// "hall, view 0, 64 × 64, k = 8, machine paper, mode cycle, model version 7", as far as known.
  std::string text() const { return text(setting("k")); }
  /// The same with this text in the place of its k, as "8 (walk 64)".
  std::string text(const std::string& k) const;
  /// The part of text() on machine, mode and model version.
  std::string machine_text() const;

  /// Facts of this subject that differ from the other's, except allowed ones; empty if comparable. Ignores accel and
  /// checkpoint, and options of checkpointing unless both use it. Between two designs, ignores what either of them
  /// brings and has at the value that it brings.
  std::vector<Fact> differences(const Subject& other, MayDiffer may) const;
  /// Value of a fact by its name in differences(); "" if missing.
  std::string fact(const std::string& name) const;
  /// A fact that is required for comparison but missing, e.g. "camera"; "" if all are known.
  std::string unknown() const;

  /// Keys for grouping: all but design, view and mode; and the view. without: names of settings and keys to leave out.
  std::string settings_text(const std::set<std::string>& without = {}) const;
  std::string view_text() const;

 private:
  std::map<std::string, std::string> settings_, view_, checkpoint_settings_;
  nlohmann::ordered_json config_ = nlohmann::ordered_json::object();
  std::string scene_, camera_;
  std::string design_;               ///< as design_name()
  std::set<std::string> of_design_;  ///< options and keys that the design brings, at the values that it brings
  bool checkpoint_ = false;
};

/// Names each subject by the facts in which they differ: "paper", "paper-charged"; "hall, 64 × 64". A subject without
/// such facts takes its text in `otherwise`; names that are still equal are numbered.
std::vector<std::string> set_apart(const std::vector<Subject>& subjects, const std::vector<std::string>& otherwise);

/// "machines paper and paper-charged, mode cycle, model version 7": machine_text() for several subjects.
std::string machines_text(const std::vector<Subject>& subjects);

}  // namespace grtx::report
