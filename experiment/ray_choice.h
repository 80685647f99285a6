// SPDX-License-Identifier: Apache-2.0
// Selects rays of a trace: those of a pixel, or of a warp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {

struct RayChoice {
  std::vector<unsigned> pixel;        ///< x, y; empty if a warp is chosen
  std::optional<std::uint64_t> warp;  ///< index of the warp, if no pixel is given
  std::uint32_t frame = 0;            ///< frame of the pixel
};
/// "--pixel X,Y" or "--warp W".
std::string place_of(const RayChoice& choice);

/// Chosen rays of one group (warp).
struct ChosenRays {
  traces::RayGroup group;
  std::vector<unsigned> lanes;
};
/// Finds the chosen rays. Those of a pixel include its secondary rays. Throws Error naming the file `trace` if there
/// are none.
std::vector<ChosenRays> chosen_rays(const std::string& trace, const traces::Reader& reader, const RayChoice& choice);

}  // namespace grtx::experiment
