// SPDX-License-Identifier: Apache-2.0
// Content of the page of `grtx ray`, and its generation: one HTML file that shows how rays were traced.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "grtx/report/ray/ray_replay.h"
#include "grtx/report/ray/warp_timeline.h"

namespace grtx::report {

/// A Gaussian to draw.
struct DrawnGaussian {
  std::uint32_t number = 0;
  std::array<float, 3> mean{};
  std::array<float, 9> half_axes{};  ///< three half-axis vectors of the ellipsoid at its kernel radius
  std::array<float, 3> colour{};     ///< RGB, without the view-dependent part
  float opacity = 0.0f;
  float kernel_radius = 3.0f;  ///< in standard deviations; the half axes reach as far
};

struct DrawnRay {
  std::uint32_t group = 0, frame = 0;
  unsigned lane = 0;
  std::uint32_t pixel = 0;
  traces::RayKind kind = traces::RayKind::primary;
  ReplayedRay replayed;
  bool traced_again = false;
  std::vector<float> transmittance;  ///< [round] after the round; empty unless traced_again
  std::array<float, 3> origin{}, direction{};
};

/// Chosen rays of one warp, and its nodes.
struct DrawnWarp {
  RayNodes nodes;
  std::vector<DrawnRay> rays;
  std::vector<WarpSlice> timeline;  ///< empty if no timeline was given
};

/// What the rays of the same pixel did in another trace of the view.
struct PixelBeside {
  std::string trace;   ///< file
  std::string design;  ///< structure, checkpoints and k in words
  std::uint64_t rounds = 0, visits = 0, processed = 0;
  std::uint64_t median = 0;  ///< visits of the median ray of its frame
};

struct RayPage {
  std::string title;
  std::string trace;  ///< file
  std::string trace_hash;
  const traces::Header* header = nullptr;
  std::string scene;                ///< file; "": not given
  std::string picture;              ///< data: URI of a picture of the view; "": not given
  std::string timeline;             ///< file; "": not given
  std::string timeline_config;      ///< hash of the configuration that was simulated for it
  std::uint64_t median_visits = 0;  ///< of the frame's rays; 0: not known
  std::vector<PixelBeside> beside;  ///< this trace first; empty: no other was given
  std::vector<DrawnWarp> warps;
  std::vector<DrawnGaussian> gaussians;
};

std::string ray_page(const RayPage& page);

}  // namespace grtx::report
