// SPDX-License-Identifier: Apache-2.0
// Several Gaussian objects in one scene by three-level instancing: scene TLAS -> TLAS of an object -> shared BLAS
// (paper, "Support for Dynamic and Multi-Object Scenes"). Objects are moved by rebuilding the scene TLAS alone.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/traces/header.h"

namespace grtx::frontend {

/// The part that all placements of one file share; never changes once built.
struct SharedObject {
  Scene scene;
  PreparedGaussians gaussians;
  std::uint64_t header = 0;  ///< byte address of its TLAS's header
  std::uint64_t root = 0;
  std::uint32_t first_record = 0;  ///< records of its Gaussians begin here: placements share them
  Box bounds;                      ///< of all its Gaussians' boxes, object space

  SharedObject(Scene s, Kernel kernel) : scene(std::move(s)), gaussians(scene, kernel) {}
};

/// A placement as rays see it.
struct PlacedObject {
  const SharedObject* object = nullptr;
  std::uint32_t first_gaussian = 0;  ///< ids of its Gaussians in the whole scene begin here
  glm::dmat3 to_object{1.0};         ///< world differences to object space: transposed rotation / scale
  glm::dvec3 position{0.0};          ///< the object space's origin in scene coordinates
  Box box;                           ///< contains the object, widened against rounding

  /// The ray in object space, with the same parameter t: its direction is not of unit length there.
  TraceRay to_object_ray(const TraceRay& ray) const;
};

class MultiObjectWorld {
 public:
  /// options.kind must be two-level. Placements name scenes by index. Throws Error.
  MultiObjectWorld(std::vector<Scene> scenes, const std::vector<Placement>& placements, const AccelOptions& options,
                   Kernel kernel);
  MultiObjectWorld(const MultiObjectWorld&) = delete;
  MultiObjectWorld& operator=(const MultiObjectWorld&) = delete;

  /// Moves the objects: takes as many placements of the same objects. Rebuilds only the scene TLAS (a frame's update);
  /// all other bytes of the node image stay as they are.
  void move(const std::vector<Placement>& placements);

  const AccelOptions& options() const { return options_; }
  const Proxy& proxy() const { return proxy_; }
  const FacePatches& patches() const { return patches_; }
  const NodeImage& image() const { return *image_; }
  std::uint64_t root() const { return image_->sizes().header_bytes(); }  ///< root of the scene TLAS
  std::uint64_t blas_header() const { return blas_root_ - image_->sizes().header_bytes(); }
  std::uint64_t blas_root() const { return blas_root_; }
  std::uint64_t scene_tlas_bytes() const { return scene_tlas_bytes_; }  ///< reserved for it at the image's start
  const std::vector<std::unique_ptr<SharedObject>>& objects() const { return objects_; }
  const std::vector<PlacedObject>& placed() const { return placed_; }
  std::uint64_t gaussians() const { return gaussians_; }  ///< Gaussians of all placements
  const glm::dvec3& offset() const { return offset_; }    ///< scene coordinates + offset = world coordinates
  std::string hash() const;                               ///< hash of the files' contents and the placements
  /// The placement that holds the Gaussian with this id.
  const PlacedObject& owner(std::uint32_t id) const;
  const GaussianRecord& record(std::uint32_t id) const {
    const PlacedObject& placed = owner(id);
    return placed.object->gaussians.record(id - placed.first_gaussian);
  }
  /// Record number of the Gaussian with this id, counted through the files: 0 to records() - 1.
  std::uint32_t record_number(std::uint32_t id) const {
    const PlacedObject& placed = owner(id);
    return placed.object->first_record + (id - placed.first_gaussian);
  }
  std::uint64_t records() const { return records_; }                                    ///< Gaussians of all files
  unsigned sh_degree() const { return sh_degree_; }                                     ///< the largest of the files'
  const std::vector<traces::SceneLeaf>& scene_leaves() const { return scene_leaves_; }  ///< ascending addresses
  double build_seconds() const { return build_seconds_; }                               ///< the first update included
  double update_seconds() const { return update_seconds_; }  ///< time of the scene TLAS's last update
  /// Bytes that the last update wrote: header and nodes of the scene TLAS.
  std::uint64_t update_bytes() const { return update_bytes_; }

 private:
  void take_objects(std::vector<Scene> scenes, Kernel kernel);
  void build_structure();  ///< shared BLAS and the objects' TLASes
  void update();
  void place();
  void write_scene_tlas();

  AccelOptions options_;
  Proxy proxy_;
  FacePatches patches_;
  std::vector<std::unique_ptr<SharedObject>> objects_;
  std::vector<Placement> placements_;
  std::vector<PlacedObject> placed_;
  glm::dvec3 offset_{0.0};
  std::unique_ptr<NodeImage> image_;
  std::uint64_t scene_tlas_bytes_ = 0;
  std::uint64_t blas_root_ = 0;
  std::uint64_t gaussians_ = 0;
  std::uint64_t records_ = 0;
  unsigned sh_degree_ = 0;
  std::vector<traces::SceneLeaf> scene_leaves_;
  std::uint64_t update_bytes_ = 0;
  double build_seconds_ = 0.0;
  double update_seconds_ = 0.0;
};

/// All placed Gaussians as one scene, in the order of their ids, with the world's hash. SH of degree > 0 is not
/// rotated, so only placements without rotation may have it: throws Error otherwise.
Scene flatten(const MultiObjectWorld& world, const std::vector<Placement>& placements);

}  // namespace grtx::frontend
