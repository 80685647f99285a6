// Which secondary rays a view has, with what each starts from, and the groups (warps) they are traced in.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/event.h"

namespace grtx::frontend {

struct SecondaryRay {
  std::uint32_t pixel = 0;
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f};
  float limit = 0.0f;          ///< no hit beyond it counts; infinity when nothing lies ahead
  float transmittance = 1.0f;  ///< what the pieces before it left
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
  /// By number of surfaces met, then glass before mirror, then in the order of the primary rays; so a group is full but
  /// for the last of each run, and its rays stay neighbours.
  std::vector<SecondaryRay> rays;
  std::vector<SecondaryGroup> groups;
  std::uint64_t truncated = 0;  ///< paths that met max_bounces surfaces and would have met another

  /// How far a primary ray may go. fp32 of the first surface's parameter.
  float primary_limit(const glm::vec3& origin, const glm::vec3& direction) const;
};

/// Follows each path and traces the pieces that end on a surface, without recording, because only a ray whose
/// transmittance is still at or above the threshold goes on. `objects` in file coordinates. `pixels`: groups of primary
/// rays (map_pixels). The result is the same for any number of threads.
SecondaryPlan plan_secondary(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
                             const Camera& camera, const TracerOptions& options, const OpticalObjects& objects,
                             bool linear_mapping, unsigned threads, unsigned warp_size = 32);

}  // namespace grtx::frontend
