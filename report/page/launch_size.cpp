// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/launch_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "grtx/base/error.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/points.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

double slots_of(const ordered_json& config) {
  try {
    const sim::GpuConfig machine = explore::config_from(config);
    return static_cast<double>(machine.sms) * machine.resident();
  } catch (const Error&) {  // of another version: its slots are not known
    return 0.0;
  }
}

unsigned pixels(const ordered_json& inputs, const char* side) {
  const std::string text = inputs.contains(side) ? explore::text_of(inputs.at(side)) : "";
  const bool digits = !text.empty() && text.size() < 7 && text.find_first_not_of("0123456789") == std::string::npos;
  return digits ? static_cast<unsigned>(std::stoul(text)) : 0;
}

/// A side of the image, grown: whole tiles of eight pixels.
unsigned grown(unsigned side, double factor) {
  constexpr double kTile = 8.0;
  return static_cast<unsigned>(kTile * std::ceil(side * factor / kTile));
}

}  // namespace

double LaunchSize::warps_to_fill() const {
  const double twice = kWarpsPerSlot * slots;
  if (warps < twice || tail <= sim::kMostTail || tail >= 1.0) return twice;
  // Until the last start the run grows with the warps that waited for a slot.
  return slots + (warps - slots) * tail / (1.0 - tail);
}

LaunchSize launch_size(const ordered_json& statistics, const ordered_json& config, const ordered_json& inputs) {
  const auto groups = statistics.find("gpu.distributor.groups");
  if (groups == statistics.end() || !groups->at("value").is_number()) return {};
  const std::size_t frames = frames_of(statistics);
  const auto value = [&statistics](const std::string& name) {
    const auto found = statistics.find(name);
    return found != statistics.end() && found->at("value").is_number() ? found->at("value").get<double>() : 0.0;
  };
  // The tail is that of the last launch, of a sequence its last frame's.
  const double cycles = value(frames == 1 ? "gpu.cycles" : fmt::format("gpu.frame{}.cycles", frames - 1)),
               tail = value("gpu.distributor.tail_cycles");
  return {groups->at("value").get<double>() / static_cast<double>(frames), slots_of(config), pixels(inputs, "width"),
          pixels(inputs, "height"), cycles > 0.0 ? tail / cycles : 0.0};
}

std::vector<LaunchSize> launch_sizes(const RunResults& run) {
  std::vector<LaunchSize> launches;
  for (const DesignResult& design : run.designs) {
    launches.push_back(launch_size(design.statistics, design.config, design.inputs));
  }
  return launches;
}

std::string too_small_text(const std::vector<LaunchSize>& launches, const std::string& what) {
  const LaunchSize* least = nullptr;
  for (const LaunchSize& launch : launches) {
    if (!launch.known() || launch.fills()) continue;
    if (least == nullptr || launch.warps * least->warps_to_fill() < least->warps * launch.warps_to_fill()) {
      least = &launch;
    }
  }
  if (least == nullptr) return "";
  const std::string tail = least->warps < kWarpsPerSlot * least->slots
                               ? ""
                               : fmt::format(", and {:.0f} % of the run is tail", 100.0 * least->tail);
  std::string text = fmt::format("this image has {:.0f} warps for {:.0f} slots{}: too small to compare {}",
                                 least->warps, least->slots, tail, what);
  if (least->width == 0 || least->height == 0) return text;
  const double factor = std::sqrt(least->warps_to_fill() / least->warps);
  return text + fmt::format("; take --width {} --height {} or more", grown(least->width, factor),
                            grown(least->height, factor));
}

}  // namespace grtx::report
