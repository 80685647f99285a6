// SPDX-License-Identifier: Apache-2.0
// The secondary rays of a view, with the start of each, and the groups (warps) that they are traced in.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/event.h"

namespace grtx::frontend {

class AccelerationStructure;
class PreparedGaussians;

struct SecondaryRay {
  std::uint32_t pixel = 0;
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f};
  float limit = 0.0f;          ///< no hit beyond it counts; infinity when nothing lies ahead
  float transmittance = 1.0f;  ///< left over by the pieces before it
};

/// Consecutive rays of SecondaryPlan::rays, all of one kind.
struct SecondaryGroup {
  traces::RayKind kind = traces::RayKind::glass;
  std::uint32_t first = 0;
  std::uint32_t count = 0;  ///< 1 .. warp_size
};

/// Made for one view by plan_secondary(); empty without objects.
struct SecondaryPlan {
  OpticalObjects objects;  ///< in scene coordinates (recentred)
  /// Ordered by number of surfaces met, then glass before mirror, then in the order of the primary rays; so only the
  /// last group of each such run is not full, and its rays are neighbours.
  std::vector<SecondaryRay> rays;
  std::vector<SecondaryGroup> groups;
  std::uint64_t truncated = 0;  ///< paths with max_bounces surfaces that would have met another

  /// t of the first surface that a primary ray meets, in fp32; infinity if it meets none.
  float primary_limit(const glm::vec3& origin, const glm::vec3& direction) const;
};

/// Follows each path and traces the pieces that end on a surface, without recording, because only a ray whose
/// transmittance is still at or above the threshold goes on. `objects` in file coordinates. `pixels`: groups of primary
/// rays (map_pixels). The result is the same for any number of threads.
SecondaryPlan plan_secondary(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
                             const Camera& camera, const TracerOptions& options, const OpticalObjects& objects,
                             bool linear_mapping, unsigned threads, unsigned warp_size = 32);

}  // namespace grtx::frontend
