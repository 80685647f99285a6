// The way from a scene to the images, the counters and the trace of one view or a sequence of views, for whatever
// structures and options.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/accel/multi_object.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/tracer_options.h"

namespace grtx::frontend {

struct TraceFile {
  std::uint64_t bytes = 0;
  std::uint64_t visits = 0;         ///< node visits in it
  std::uint64_t decoded_bytes = 0;  ///< of all groups, as a simulation reads them
  std::uint64_t largest_group = 0;  ///< bytes of the largest, decoded
};

/// A sequence is traced into one file, frame after frame. Its counters add up, its footprint is the largest of a frame.
struct TracedView {
  RenderResult result;                        ///< with the first frame's image, pixel costs and sequences
  std::vector<Image> further;                 ///< images of the other frames of a sequence
  SecondaryPlan plan;                         ///< of the secondary rays among them; empty without objects
  std::map<std::string, std::string> inputs;  ///< what the result is of, as in the trace's header
  std::optional<TraceFile> trace;             ///< when one was written
};

/// Owns scene and structure; views or sequences of one scene, traced as often as one likes.
class ViewTracer {
 public:
  /// kernel: that of all options given to trace().
  ViewTracer(Scene scene, Camera camera, Kernel kernel = {});
  /// cameras: of the frames, one or more, all of one resolution.
  ViewTracer(Scene scene, std::vector<Camera> cameras, Kernel kernel = {});
  ViewTracer(const ViewTracer&) = delete;
  ViewTracer& operator=(const ViewTracer&) = delete;

  const Scene& scene() const { return scene_; }
  const Camera& camera() const { return cameras_.front(); }  ///< of the first frame
  const PreparedGaussians& gaussians() const { return gaussians_; }
  Kernel kernel() const { return kernel_; }
  const OpticalObjects& objects() const { return objects_; }
  /// The structure that the last build() made.
  const AccelerationStructure& accel() const { return *accel_; }

  /// The frames that are traced from now on, as in the constructor. The structure stays: no camera is part of it.
  void look(const std::vector<Camera>& cameras);
  /// Glass and mirror, in file coordinates, from now on.
  void place(const OpticalObjects& objects) { objects_ = objects; }
  /// The structure that is traced from now on. The last one is freed before, for it may be large; it stays when it is
  /// of the same options.
  const AccelerationStructure& build(const AccelOptions& options);
  /// How many structures build() has made.
  unsigned structures_built() const { return structures_built_; }

  /// After build(). trace_file: "" writes none. inputs: text for its header, beside scene and camera. Secondary rays
  /// are planned anew each time: that the plans of two structures agree is part of the proof that their images do.
  /// render.secondary is not looked at. Throws Error.
  TracedView trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file = "",
                   const std::map<std::string, std::string>& inputs = {}) const;

 private:
  const Scene scene_;
  std::vector<Camera> cameras_;
  const Kernel kernel_;
  const PreparedGaussians gaussians_;
  OpticalObjects objects_;
  std::unique_ptr<AccelerationStructure> accel_;
  unsigned structures_built_ = 0;
};

/// Views or sequences of several objects, traced as often as one likes; they may be moved in between.
class ObjectViewTracer {
 public:
  /// As MultiObjectWorld. name: of the list, for the inputs of results.
  ObjectViewTracer(std::string name, std::vector<Scene> scenes, const std::vector<Placement>& placements,
                   std::vector<Camera> cameras, const AccelOptions& options, Kernel kernel = {});

  const MultiObjectWorld& world() const { return world_; }
  Kernel kernel() const { return kernel_; }
  /// As ViewTracer::look().
  void look(const std::vector<Camera>& cameras);
  void move(const std::vector<Placement>& placements) { world_.move(placements); }
  /// As ViewTracer::trace(), but for secondary rays, of which there are none.
  TracedView trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file = "",
                   const std::map<std::string, std::string>& inputs = {}) const;

 private:
  const std::string name_;
  std::vector<Camera> cameras_;
  const Kernel kernel_;
  MultiObjectWorld world_;
};

}  // namespace grtx::frontend
