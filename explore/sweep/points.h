// SPDX-License-Identifier: Apache-2.0
// Expands a plan to traces and points to run. The key of each is the hash of its inputs.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/explore/sweep/plan.h"
#include "grtx/explore/sweep/point_config.h"
#include "grtx/rtl_tlm/gpu/machine_use.h"

namespace grtx::explore {

struct SweepTrace {
  std::string key;
  std::string scene;                   ///< its name in the plan
  nlohmann::ordered_json options;      ///< all inputs: hashes, view, resolved tracer options
  std::string structure;               ///< TracerRules::structure(); "" if it cannot be made
  std::vector<std::string> arguments;  ///< of `grtx trace`, without -o, --scene and --cameras
  std::string scene_file, cameras;     ///< absolute; for a generated scene relative to the traces' folder
  std::vector<std::string> synth;      ///< arguments of `grtx synth` without -o; empty for a scene file
  std::string files_hash;              ///< SceneInput::files_hash; "" for a generated scene
};

struct SweepPoint {
  std::string key;
  std::string trace_key;
  std::string machine;         ///< name of the machine
  std::string machine_option;  ///< PlanMachine::option
  std::string mode;
  std::string scene;
  std::string design;
  nlohmann::ordered_json coordinates;  ///< values that the plan varies, at this point
  PointConfig config;
  sim::MachineUse use;  ///< units that the machine needs, for its cost
  std::string broken;   ///< why it cannot run; "" if it can
};

struct SweepPoints {
  std::vector<std::shared_ptr<const SweepTrace>> traces;
  std::vector<SweepPoint> points;  ///< ordered by scene, view, design, then varied parameters
};

/// Makes points of a plan. Scene and camera files are read once, in the constructor.
class PointMaker {
 public:
  /// A view of one of the plan's scenes.
  struct Place {
    std::size_t scene = 0;  ///< index in the plan
    unsigned view = 0;
  };
  struct TracedPoint {
    std::shared_ptr<const SweepTrace> trace;  ///< shared by all points that use it
    SweepPoint point;
  };
  /// plan and tracer must outlive it. program: version, part of every key. Throws Error if a scene or camera file
  /// cannot be read.
  PointMaker(const SweepPlan& plan, const TracerRules& tracer, std::string program);
  ~PointMaker();
  PointMaker(const PointMaker&) = delete;
  PointMaker& operator=(const PointMaker&) = delete;

  /// Scenes in the plan's order, each with its views.
  const std::vector<Place>& places() const { return places_; }
  /// design: "" if tracer.accel and tracer.checkpoint define it. varied: settings of this point in addition to the
  /// plan's; an entry "design" overrides `design`, an entry "machine" the plan's.
  TracedPoint make(const Place& place, const std::string& design, const Coordinates& varied);

 private:
  struct Scene;
  struct TraceRequest;
  struct ResolvedTrace;
  const ResolvedTrace& traced(TraceRequest request);

  const SweepPlan& plan_;
  const TracerRules& tracer_;
  std::string program_;
  std::vector<Scene> scenes_;
  std::vector<Place> places_;
  std::map<std::string, PointConfigs> configs_;                      ///< by PlanMachine::name
  std::unique_ptr<std::map<TraceRequest, ResolvedTrace>> resolved_;  ///< cache: resolving options is slow
};

/// All points of a plan. Points with the same inputs are merged. Combinations that the machine or tracer does not
/// support have `broken` set. program: version, part of every key. Throws Error if a scene or camera file cannot be
/// read.
SweepPoints expand(const SweepPlan& plan, const TracerRules& tracer, const std::string& program);

/// The key of a point in another mode, and the point itself.
std::string key_in_mode(const SweepPoint& point, const std::string& mode, const std::string& program);
SweepPoint in_mode(const SweepPoint& point, const std::string& mode, const std::string& program);

/// Writes a resolved configuration as a file for `--config`, and a second one beside it that the first includes.
void write_config(const std::string& path, const nlohmann::ordered_json& config);

/// The configuration of a point. Throws Error if it is from an incompatible version of the program.
sim::GpuConfig config_from(const nlohmann::ordered_json& config);

}  // namespace grtx::explore
