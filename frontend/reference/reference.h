// The fp64 brute-force renderer: no BVH, shares no code with the tracer but the scene, the camera and the
// description of glass and mirror.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "frontend/camera.h"
#include "frontend/image.h"
#include "frontend/optical_objects.h"
#include "frontend/scene.h"

namespace grtx::frontend {

enum class ReferenceProxy { icosahedron20, icosphere80, sphere };

struct ReferenceOptions {
  ReferenceProxy proxy = ReferenceProxy::icosahedron20;
  bool sort_by_peak = false;    ///< false: t_hit of the proxy's entry; true: t_alpha
  bool adaptive_radius = true;  ///< false: fixed 3 sigma
  double ert = 0.001;           ///< transmittance threshold
  bool count_inside = false;    ///< inside = count (sphere only)
  bool sh_from_centre = false;  ///< SH direction: ray (false) or normalize(mean - origin)
  OpticalObjects objects;       ///< glass and mirror, file coordinates
  unsigned threads = 0;         ///< 0: all
  bool quiet = true;
  bool keep_sequences = false;  ///< also return what each ray blended, for tests
};

struct ReferenceHit {
  std::uint32_t gaussian = 0;
  double t = 0.0;  ///< sort key
  double alpha = 0.0;
};

struct ReferenceResult {
  Image image;
  std::vector<std::vector<ReferenceHit>>
      sequences;  ///< per pixel, along its path, blended only; empty unless asked for
};

ReferenceResult render_reference(const Scene& scene, const Camera& camera, const ReferenceOptions& options);

}  // namespace grtx::frontend
