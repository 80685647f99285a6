// What a result is of: machine, view, options, mode, version of the model. A figure stands beside it, and figures of
// two results are compared or averaged only where it is the same. This decides it for runs and for points of sweeps.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::sim {

/// In what two results may differ.
enum class MayDiffer {
  designs,  ///< structure and checkpointing: the ratio is a speed-up
  views     ///< scene and camera, at one resolution: a mean is over views
};

/// A fact in which results differ, as people read it: "ert", "0.01".
struct Fact {
  std::string name, value;
};

class Subject {
 public:
  Subject() = default;
  /// inputs: of grtx.stats/1. config: resolved, key -> value. more: inputs that are known from elsewhere, and better;
  /// empty ones are not.
  Subject(const nlohmann::ordered_json& inputs, const nlohmann::ordered_json& config,
          const std::map<std::string, std::string>& more = {});

  /// The scene's file without folder and ending, the camera's name; "" where the inputs do not say it.
  const std::string& scene() const { return scene_; }
  const std::string& camera() const { return camera_; }
  /// An input that is not of the view: "machine", "mode", "k", "width". "" when there is none.
  std::string setting(const std::string& name) const;
  /// "hall, view 0, 64 × 64, k = 8, machine paper, mode cycle, model version 7", of what is known.
  std::string text() const;
  /// The last three of these: what a time depends on besides the view.
  std::string machine_text() const;

  /// Facts of this one that the other has otherwise; empty: alike. What makes a design is none of them, nor what only
  /// checkpoints read where one of both has none.
  std::vector<Fact> differences(const Subject& other, MayDiffer may) const;
  /// The value of what differences() names; "" when there is none.
  std::string fact(const std::string& name) const;
  /// What must be known of a result before it is put beside another, and is not: "camera"; "": all is known.
  std::string unknown() const;

  /// Everything but design, view and mode, as a key; and the view.
  std::string settings_text() const;
  std::string view_text() const;

 private:
  std::map<std::string, std::string> settings_, view_, checkpoint_settings_;
  nlohmann::ordered_json config_ = nlohmann::ordered_json::object();
  std::string scene_, camera_;
  bool checkpoint_ = false;
};

/// Of each, what sets it apart from the others: "paper", "paper-charged"; "hall, 64 × 64". Where nothing does, its text
/// in `otherwise`; those that are still equal are numbered.
std::vector<std::string> set_apart(const std::vector<Subject>& subjects, const std::vector<std::string>& otherwise);

/// "machines paper and paper-charged, mode cycle, model version 7": machine_text() of several.
std::string machines_text(const std::vector<Subject>& subjects);

}  // namespace grtx::sim
