// From a plan to what must be run: the traces and the points, each with a key that is the hash of its inputs.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/lab/sweep/plan.h"
#include "grtx/lab/sweep/point_config.h"
#include "grtx/rtl_tlm/gpu/machine_use.h"

namespace grtx::sim {

struct SweepTrace {
  std::string key;
  std::string scene;                   ///< its name in the plan
  nlohmann::ordered_json options;      ///< everything the trace is made from: hashes, view, resolved tracer options
  std::string structure;               ///< TracerRules::structure(); of one that cannot be made ""
  std::vector<std::string> arguments;  ///< of `grtx trace`, without -o, --scene and --cameras
  std::string scene_file, cameras;     ///< absolute; of a generated scene relative to the traces' folder
  std::vector<std::string> synth;      ///< arguments of `grtx synth` without -o; empty for a scene file
  std::string files_hash;              ///< of a scene file's SceneInput; "" for a generated scene
};

struct SweepPoint {
  std::string key;
  std::string trace_key;
  std::string machine;  ///< its name
  std::string mode;
  std::string scene;
  std::string design;
  nlohmann::ordered_json coordinates;  ///< what the plan varies at this point
  PointConfig config;
  MachineUse use;      ///< which units the machine has, for its cost
  std::string broken;  ///< why it cannot run at all; "" when it can
};

struct SweepPoints {
  std::vector<std::shared_ptr<const SweepTrace>> traces;
  std::vector<SweepPoint> points;  ///< in the plan's order; scenes, views, designs, then what is varied
};

/// Makes the points of a plan's scenes, whose files are read once.
class PointMaker {
 public:
  /// A view of one of the plan's scenes.
  struct Place {
    std::size_t scene = 0;  ///< index in the plan
    unsigned view = 0;
  };
  struct Made {
    std::shared_ptr<const SweepTrace> trace;  ///< of all points that have it
    SweepPoint point;
  };
  /// plan and tracer must outlive it. program: version, part of every key. Throws Error when a scene or camera file
  /// cannot be read.
  PointMaker(const SweepPlan& plan, const TracerRules& tracer, std::string program);
  ~PointMaker();
  PointMaker(const PointMaker&) = delete;
  PointMaker& operator=(const PointMaker&) = delete;

  /// Scenes in the plan's order, each with its views.
  const std::vector<Place>& places() const { return places_; }
  /// design: "" when tracer.accel and tracer.checkpoint say it. varied: what this point sets besides the plan's
  /// settings; "design" among it overrides the design.
  Made make(const Place& place, const std::string& design, const Coordinates& varied);

 private:
  struct Scene;
  struct Asked;
  struct Traced;
  const Traced& traced(Asked asked);

  const SweepPlan& plan_;
  const TracerRules& tracer_;
  std::string program_;
  std::vector<Scene> scenes_;
  std::vector<Place> places_;
  PointConfigs configs_;
  std::unique_ptr<std::map<Asked, Traced>> asked_;  ///< asking the tracer takes as long as a hundred points
};

/// Points that resolve to the same inputs are one. A combination of values that no machine or tracer takes is a point
/// with `broken` set. program: version, part of every key. Throws Error when a scene or camera file cannot be read.
SweepPoints expand(const SweepPlan& plan, const TracerRules& tracer, const std::string& program);

/// The same point in another mode, and its key alone.
std::string key_in_mode(const SweepPoint& point, const std::string& mode, const std::string& program);
SweepPoint in_mode(const SweepPoint& point, const std::string& mode, const std::string& program);

/// A configuration as a file that `--config` takes.
std::string config_toml(const nlohmann::ordered_json& config);

/// The configuration of a point. Throws Error for one of another version of the program.
GpuConfig config_from(const nlohmann::ordered_json& config);

}  // namespace grtx::sim
