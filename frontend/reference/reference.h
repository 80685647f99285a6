// SPDX-License-Identifier: Apache-2.0
// The fp64 brute-force renderer: no BVH, shares no code with the tracer but the scene, the camera and the
// description of glass and mirror.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

enum class ReferenceProxy { icosahedron20, icosphere80, sphere };

inline constexpr unsigned kReferenceTile = 8;  ///< pixels along each side of a tile of rays

struct ReferenceOptions {
  ReferenceProxy proxy = ReferenceProxy::icosahedron20;
  bool sort_by_peak = false;    ///< false: t_hit of the proxy's entry; true: t_alpha
  bool adaptive_radius = true;  ///< false: fixed 3 sigma
  unsigned kernel_degree = 2;   ///< n of the response exp(-4.5 (d / 3)^n), d in sigma
  double ert = 0.001;           ///< transmittance threshold
  bool count_inside = false;    ///< InsideRule::count (sphere only)
  bool sh_from_centre = false;  ///< SH direction: ray (false) or normalize(mean - origin)
  OpticalObjects objects;       ///< glass and mirror, file coordinates
  unsigned threads = 0;         ///< 0: all
  bool quiet = true;
  /// Most tiles of kReferenceTile pixels along each side, evenly spread over the image; pixels between them stay black.
  /// 0: the whole image.
  unsigned tiles_a_side = 0;
  bool keep_sequences = false;   ///< also return what each ray blended, for tests
  bool keep_candidates = false;  ///< also return each ray's hits and near misses, for tests
};

struct ReferenceHit {
  std::uint32_t gaussian = 0;
  double t = 0.0;  ///< sort key
  double alpha = 0.0;
};

/// A Gaussian that a ray hits or narrowly misses, with the values that decide it, so that a different decision of
/// another renderer can be explained. Kept when d2 <= 1.05 kappa^2 and alpha >= 0.95 / 255, even behind the origin.
struct ReferenceCandidate {
  std::uint32_t gaussian = 0;
  double t = 0.0;       ///< sort key if it is a hit
  double alpha = 0.0;   ///< min(0.99, o exp(-d2 / 2)); a hit needs 1/255
  double radius = 0.0;  ///< sqrt(d2) / kappa; a hit needs at most 1
  double entry = 0.0;   ///< t at which the ray enters the proxy; a hit needs > 0 (inside = skip)
  double exit = 0.0;
  bool hit = false;
};

struct ReferenceResult {
  Image image;
  std::vector<std::size_t> rendered;  ///< indices of the pixels of the chosen tiles, ascending; empty: all
  std::vector<std::vector<ReferenceHit>>
      sequences;  ///< per pixel, along its path, blended only; empty unless asked for
  std::vector<std::vector<ReferenceCandidate>> candidates;  ///< per pixel, by (t, id); empty unless asked for
};

ReferenceResult render_reference(const Scene& scene, const Camera& camera, const ReferenceOptions& options);

}  // namespace grtx::frontend
