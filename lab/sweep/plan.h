// The plan of a sweep, as written in TOML: scenes, designs, tracer options, a base configuration and what is varied.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/lab/sweep/axis.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// A scene file with its cameras, or a scene that `grtx synth` makes.
struct PlanScene {
  std::string name;
  std::string place;             ///< "line N"
  std::string file;              ///< "" for a generated scene
  std::string cameras;           ///< "" for a generated scene: its own
  std::string preset;            ///< of a generated scene
  std::uint64_t count = 100000;  ///< Gaussians of a generated scene
  std::uint64_t seed = 1;
  unsigned sh_degree = 3;
  std::vector<unsigned> views = {0};
  unsigned width = 0, height = 0;  ///< pixels; 0: the camera's
  double fov_scale = 1.0;
  bool evaluation = false;  ///< of a search: kept for the end (role = "evaluation")
};

struct PlanLimits {
  double seconds = 3600.0;    ///< wall time of one simulation or trace
  double memory_mb = 4096.0;  ///< 10^6 bytes of its memory
};

/// A machine as --machine names it.
struct NamedMachine {
  std::string name;    ///< as results have it; "" for none
  std::string option;  ///< as `grtx sim --machine` takes it from any folder: of a file its absolute path
};

/// The paper's designs: baseline, sw, hw, grtx.
const std::vector<std::string>& design_names();

struct SweepPlan {
  std::string path;
  std::string text;
  std::vector<PlanScene> scenes;
  std::vector<std::string> designs = {"grtx"};  ///< empty when tracer.accel or tracer.checkpoint decide
  std::string mode = "cycle";
  std::string confirm;   ///< mode in which the front is simulated again; "" for none
  NamedMachine on;       ///< what `base` lies over
  std::string base;      ///< configuration file; "" for the machine alone
  GpuConfig machine;     ///< what both say
  Coordinates settings;  ///< [set] and [tracer]: what every point has; tracer options as "tracer.NAME"
  std::vector<Coordinates> points;
  PlanLimits limits;
};

/// What the views of a scene are made from.
struct SceneInput {
  std::string files_hash;        ///< FilesRead::hash() of what the tracer opens: cameras, then scene
  bool several_objects = false;  ///< it is a list of objects
};

/// What the sweep asks the tracer, which it does not know itself.
class TracerRules {
 public:
  virtual ~TracerRules() = default;
  /// Throws Error when the option is unknown (naming the nearest) or does not take the value.
  virtual void check(const std::string& option, const std::string& value) const = 0;
  /// All options of a structure with these given: name -> text. Throws Error for what cannot go together.
  virtual std::map<std::string, std::string> resolve(const std::map<std::string, std::string>& options,
                                                     const std::string& accel, bool checkpoint) const = 0;
  /// What the acceleration structure of these options is, as in resolve(): the same text, the same structure of a
  /// scene.
  virtual std::string structure(const std::map<std::string, std::string>& options, const std::string& accel) const = 0;
  /// Reads every file that the tracer opens for these. Throws Error when one is missing or no such file.
  virtual SceneInput input(const std::string& scene, const std::string& cameras) const = 0;
};

/// Paths in the plan are relative to the plan's own folder. Throws Error{path, "line N", rule} for whatever is unknown,
/// missing, of the wrong type or out of range, and for configuration keys and tracer options that are.
SweepPlan load_plan(const std::string& path, const TracerRules& tracer);

}  // namespace grtx::sim
