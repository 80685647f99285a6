#include "grtx/apps/grtx/dropped_fills.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

namespace grtx::sim {

void warn_of_dropped_fills(const nlohmann::ordered_json& statistics, std::string_view design) {
  if (!statistics.contains("gpu.l1.fills") || !statistics.contains("gpu.l1.fills_bypassed")) return;  // an own L1
  constexpr double kTolerated = 0.001;
  const double fills = statistics.at("gpu.l1.fills").at("value");
  const double dropped = statistics.at("gpu.l1.fills_bypassed").at("value");
  if (dropped <= kTolerated * fills) return;
  fmt::print(stderr,
             "grtx: {}: {:.1f} % of the fills of the L1 were dropped, their victims found no room: raise "
             "l1.write_back_buffer\n",
             design, 100.0 * dropped / fills);
}

}  // namespace grtx::sim
