// Which rays of a trace somebody asks for: those of a pixel, or of a warp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct RayChoice {
  std::vector<unsigned> pixel;        ///< x, y; or none
  std::optional<std::uint64_t> warp;  ///< in its place
  std::uint32_t frame = 0;            ///< of the pixel
};
/// "--pixel X,Y" or "--warp W".
std::string place_of(const RayChoice& choice);

/// Rays of one group.
struct ChosenRays {
  traces::RayGroup group;
  std::vector<unsigned> lanes;
};
/// Those that glass and mirrors make of a pixel's ray are with it. Throws Error, which names the file `trace`, when
/// there are none.
std::vector<ChosenRays> chosen_rays(const std::string& trace, const traces::Reader& reader, const RayChoice& choice);

}  // namespace grtx::sim
