// SPDX-License-Identifier: Apache-2.0
// Gaussians as the tracer reads them: world-to-unit transforms, radii, and the world-space geometry of their proxies.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/base/huge_pages.h"
#include "grtx/frontend/gaussian/face_patches.h"
#include "grtx/frontend/gaussian/float4.h"
#include "grtx/frontend/gaussian/kernel.h"
#include "grtx/frontend/gaussian/leaf_widths.h"
#include "grtx/frontend/gaussian/primitive_box.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/gaussian/quantised_gaussian.h"
#include "grtx/frontend/gaussian/slab_intersection.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

/// One cache line: everything the hit function reads. `to_unit` rows map world differences to the frame in which the
/// Gaussian's bounding ellipsoid is the unit sphere: p = to_unit (x - mean).
struct alignas(64) GaussianRecord {
  glm::vec3 mean{0.0f};
  float kappa2 = 0.0f;  ///< squared kernel radius, sigma^2
  glm::vec3 to_unit[3];
  float opacity = 0.0f;
};
static_assert(sizeof(GaussianRecord) == 64);

class PreparedGaussians {
 public:
  /// quantised: each Gaussian is rounded as its leaf of layout quantised holds it; wide leaves do not round.
  PreparedGaussians(const Scene& scene, Kernel kernel, bool quantised = false);

  std::size_t size() const { return records_.size(); }
  const GaussianRecord& record(std::uint32_t g) const { return records_[g]; }
  bool quantised() const { return quantised_; }
  const MeanGrid& mean_grid() const { return widths_.grid; }                  ///< if quantised
  bool wide(std::uint32_t g) const { return quantised_ && widths_.wide[g]; }  ///< its leaf is a wide one
  std::uint64_t wide_count() const { return widths_.count; }
  const QuantisedGaussian& code(std::uint32_t g) const { return codes_[g]; }  ///< if quantised, and not wide
  /// World position of a proxy vertex given in unit space: mean + to_world v. fp32, always the same operations.
  glm::vec3 to_world(std::uint32_t g, const glm::vec3& v) const {
    const glm::vec3* a = &to_world_[3 * static_cast<std::size_t>(g)];
    const glm::vec3& m = records_[g].mean;
    return {((a[0].x * v.x + a[0].y * v.y) + a[0].z * v.z) + m.x, ((a[1].x * v.x + a[1].y * v.y) + a[1].z * v.z) + m.y,
            ((a[2].x * v.x + a[2].y * v.y) + a[2].z * v.z) + m.z};
  }
  /// Column `axis` of to_world: a half axis of the ellipsoid, as a world difference.
  glm::vec3 half_axis(std::uint32_t g, int axis) const {
    const glm::vec3* a = &to_world_[3 * static_cast<std::size_t>(g)];
    return {a[0][axis], a[1][axis], a[2][axis]};
  }
  /// World box of face `face` of the proxy (of the whole ellipsoid for the sphere), widened against rounding.
  Box face_box(std::uint32_t g, const Proxy& proxy, unsigned face) const;
  /// World box of the whole proxy; contains every face_box exactly. `corners`: box of the eight transformed corners of
  /// the object-space box instead of the tight one.
  Box instance_box(std::uint32_t g, const Proxy& proxy, bool corners) const;

  /// Margin by which boxes of faces are widened on every side; box: of a face's vertices.
  float margin_of(const Box& box) const;

  /// Face boxes of the Gaussians [begin, end), bit for bit as face_box(); boxes of one Gaussian's faces lie together.
  /// The caller sets the primitive numbers.
  void write_face_boxes(std::size_t begin, std::size_t end, const Proxy& proxy, PrimitiveBox* boxes) const;
  /// Patch boxes of each Gaussian in turn; each contains its faces' boxes exactly.
  void write_patch_boxes(std::size_t begin, std::size_t end, const Proxy& proxy, const FacePatches& patches,
                         PrimitiveBox* boxes) const;
  void write_instance_boxes(std::size_t begin, std::size_t end, const Proxy& proxy, bool corners,
                            PrimitiveBox* boxes) const;

  /// Prefetches record and to_world of g.
  void prefetch(std::uint32_t g) const {
    __builtin_prefetch(&records_[g]);
    const glm::vec3* rows = &to_world_[3 * static_cast<std::size_t>(g)];
    __builtin_prefetch(rows);
    __builtin_prefetch(rows + 2);
  }

 private:
  struct WideBox;

  /// to_world: columns are the half axes.
  void set_maps(std::size_t g, const glm::dvec3 (&to_unit)[3], const glm::dmat3& to_world);
  void set_whole(std::size_t g, const Scene& scene, const Kernel& kernel);
  /// Returns false if no code holds the Gaussian: it is wide.
  bool set_quantised(std::size_t g, const Scene& scene, const Kernel& kernel);
  void read_code(std::size_t g);  ///< sets record and maps to what the code holds
  Box widened(Box box) const;
  /// Writes the world positions of the proxy's vertices; returns how many.
  unsigned write_vertices(std::size_t g, const Proxy& proxy, Float4* world) const;

  HugePageVector<GaussianRecord> records_;
  HugePageVector<glm::vec3> to_world_;  ///< three rows per Gaussian
  bool quantised_;
  LeafWidths widths_;
  HugePageVector<QuantisedGaussian> codes_;
  float absolute_margin_ = 0.0f;
};

}  // namespace grtx::frontend
