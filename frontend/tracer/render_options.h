// SPDX-License-Identifier: Apache-2.0
// How a view is rendered, and what comes of it.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/tracer_counters.h"

namespace grtx::frontend {

struct SecondaryPlan;

struct RenderOptions {
  unsigned threads = 0;         ///< 0: all
  bool linear_mapping = false;  ///< groups of consecutive pixels instead of tiles
  unsigned warp_size = 32;      ///< rays of a group: 4, 8, 16 or 32
  bool count_unique = false;    ///< visits_unique and footprint (slower)
  bool count_hits = false;      ///< RenderResult::hits (traces the view once more)
  bool keep_sequences = false;  ///< per-pixel blended ids, for tests
  bool pixel_costs = false;     ///< fill RenderResult::pixel_costs
  bool quiet = true;
  const char* doing = "tracing";  ///< for the progress bar
  std::uint64_t first_group = 0;  ///< index of the view's first group in the trace, after those of earlier frames
  const SecondaryPlan* secondary =
      nullptr;  ///< of this view and these options (plan_secondary); null: primary rays only
};

/// Work of a pixel's rays, secondary ones included.
struct PixelCost {
  std::uint32_t visits = 0;       ///< nodes processed
  std::uint32_t rounds = 0;       ///< traceRay calls
  std::uint32_t blended = 0;      ///< hits
  std::uint32_t checkpoints = 0;  ///< checkpoint entries written

  PixelCost& operator+=(const PixelCost& o) {
    visits += o.visits;
    rounds += o.rounds;
    blended += o.blended;
    checkpoints += o.checkpoints;
    return *this;
  }
};

struct RenderResult {
  Image image;
  TracerCounters counters;             ///< of all rays
  TracerCounters secondary;            ///< of the secondary rays among them
  std::uint64_t footprint_bytes = 0;   ///< distinct node bytes touched by the view; 0 unless count_unique
  double seconds = 0.0;                ///< tracing alone
  std::vector<PixelCost> pixel_costs;  ///< by pixel, row by row, top row first; empty unless asked for
  std::vector<std::vector<std::uint32_t>> sequences;  ///< per pixel, along its path; empty unless keep_sequences
};

}  // namespace grtx::frontend
