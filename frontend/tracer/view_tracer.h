// SPDX-License-Identifier: Apache-2.0
// From a scene to images, counters and trace of one view or a sequence of views, for any structures and options.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grtx/frontend/accel/accel_options.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/kernel.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/render_options.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/frontend/tracer/tracer_options.h"

namespace grtx::frontend {

class AccelerationStructure;
class MultiObjectWorld;
class PreparedGaussians;

struct TraceFile {
  std::uint64_t bytes = 0;
  std::uint64_t visits = 0;         ///< node visits in it
  std::uint64_t decoded_bytes = 0;  ///< size of all groups as a simulation reads them
  std::uint64_t largest_group = 0;  ///< bytes of the largest, decoded
};

/// A sequence is traced into one file, frame after frame. Counters are added, the footprint is the largest of a frame.
struct TracedView {
  RenderResult result;                        ///< with the first frame's image, pixel costs and sequences
  std::vector<Image> further;                 ///< images of the other frames of a sequence
  SecondaryPlan plan;                         ///< of the secondary rays among them; empty without objects
  std::map<std::string, std::string> inputs;  ///< what the result was made from, as in the trace's header
  std::optional<TraceFile> trace;             ///< when one was written
};

/// Owns a scene and its structure; traces views or sequences of it, as often as needed.
class ViewTracer {
 public:
  /// kernel: must be that of all options passed to trace().
  ViewTracer(Scene scene, Camera camera, Kernel kernel = {});
  /// cameras: of the frames, one or more, all of one resolution.
  ViewTracer(Scene scene, std::vector<Camera> cameras, Kernel kernel = {});
  ~ViewTracer();
  ViewTracer(const ViewTracer&) = delete;
  ViewTracer& operator=(const ViewTracer&) = delete;

  const Scene& scene() const { return scene_; }
  const Camera& camera() const { return cameras_.front(); }  ///< of the first frame
  const PreparedGaussians& gaussians() const { return *gaussians_; }
  Kernel kernel() const { return kernel_; }
  const OpticalObjects& objects() const { return objects_; }
  /// The structure of the last build().
  const AccelerationStructure& accel() const { return *accel_; }

  /// Sets the frames' cameras, as in the constructor. The structure stays: it does not depend on cameras.
  void look(const std::vector<Camera>& cameras);
  /// Sets glass and mirror, in file coordinates.
  void place(const OpticalObjects& objects) { objects_ = objects; }
  /// Builds the structure to trace from now on, or keeps the last one if it has the same options. Otherwise frees the
  /// last one first, because it may be large.
  const AccelerationStructure& build(const AccelOptions& options);
  /// Channels of harmonics beyond what fp16 holds, which are the largest it holds; 0 unless Gaussians are quantised.
  std::uint64_t clamped_sh() const { return clamped_sh_; }
  /// How many structures build() has made.
  unsigned structures_built() const { return structures_built_; }

  /// Call after build(). trace_file: "" writes none. inputs: further entries of its header, besides scene and camera.
  /// Secondary rays are planned again each time: that two structures have the same plan is part of the proof that their
  /// images agree. render.secondary is ignored. Throws Error.
  TracedView trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file = "",
                   const std::map<std::string, std::string>& inputs = {}) const;

 private:
  void round_sh(bool quantised);

  Scene scene_;                 ///< harmonics rounded to fp16 where Gaussians are quantised
  std::vector<float> full_sh_;  ///< then: as they were
  std::uint64_t clamped_sh_ = 0;
  std::vector<Camera> cameras_;
  const Kernel kernel_;
  std::unique_ptr<const PreparedGaussians> gaussians_;  ///< in the form that the structure's layout needs
  OpticalObjects objects_;
  std::unique_ptr<AccelerationStructure> accel_;
  unsigned structures_built_ = 0;
};

/// Traces views or sequences of several objects, as often as needed; the objects may be moved in between.
class ObjectViewTracer {
 public:
  /// As MultiObjectWorld. name: of the list, for the inputs of results.
  ObjectViewTracer(std::string name, std::vector<Scene> scenes, const std::vector<Placement>& placements,
                   std::vector<Camera> cameras, const AccelOptions& options, Kernel kernel = {});
  ~ObjectViewTracer();
  ObjectViewTracer(const ObjectViewTracer&) = delete;
  ObjectViewTracer& operator=(const ObjectViewTracer&) = delete;

  const MultiObjectWorld& world() const { return *world_; }
  Kernel kernel() const { return kernel_; }
  /// As ViewTracer::look().
  void look(const std::vector<Camera>& cameras);
  void move(const std::vector<Placement>& placements);
  /// As ViewTracer::trace(), but without secondary rays.
  TracedView trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file = "",
                   const std::map<std::string, std::string>& inputs = {}) const;

 private:
  const std::string name_;
  std::vector<Camera> cameras_;
  const Kernel kernel_;
  const std::unique_ptr<MultiObjectWorld> world_;
};

}  // namespace grtx::frontend
