#include "grtx/rtl_tlm/gpu/mode_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>

namespace grtx::sim {
namespace {

/// Whether a key has another value than its default.
class Settings {
 public:
  explicit Settings(const GpuConfig& config) : values_(config_json(config)), defaults_(config_json(GpuConfig{})) {}
  bool differ(std::string_view key) const {
    const std::string name(key);
    return values_.at(name) != defaults_.at(name);
  }

 private:
  nlohmann::ordered_json values_, defaults_;
};

}  // namespace

const std::vector<ModeKey>& mode_keys() {
  constexpr SimulationMode kFast = SimulationMode::fast, kCycle = SimulationMode::cycle;
  static const std::vector<ModeKey> keys = {
      {kFast, "rt.warp_buffer.spill", "is not modelled by --mode fast"},
      {kFast, "rt.memory.by_shader", "is not modelled by --mode fast"},
      {kFast, "gpu.rt_units", "must be 1 with --mode fast"},
      // What only queues have that fast mode does not fill.
      {kFast, "l1.mshr_merges"},
      {kFast, "l1.rotating_priority"},
      {kFast, "l1.link_latency"},
      {kFast, "l2.mshr_merges"},
      {kFast, "l2.reply_queue"},
      {kFast, "dram.age_cap"},
      {kFast, "simt.cost.node_fetch"},
      {kCycle, "fast.stride"},
      {kCycle, "fast.seed"},
  };
  return keys;
}

Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode) {
  const Settings settings(config);
  for (const ModeKey& key : mode_keys()) {
    if (key.mode == mode && key.refused != nullptr && settings.differ(key.key)) return {key.key, key.refused};
  }
  return {};
}

std::vector<std::string_view> ignored_keys(const GpuConfig& config, const std::vector<SimulationMode>& modes) {
  const Settings settings(config);
  const auto ignores = [](SimulationMode mode, std::string_view name) {
    return std::any_of(mode_keys().begin(), mode_keys().end(), [&](const ModeKey& key) {
      return key.mode == mode && key.key == name && key.refused == nullptr;
    });
  };
  std::vector<std::string_view> ignored;
  for (const ModeKey& key : mode_keys()) {
    if (modes.empty() || key.mode != modes.front() || key.refused != nullptr || !settings.differ(key.key)) continue;
    if (std::all_of(modes.begin(), modes.end(), [&](SimulationMode mode) { return ignores(mode, key.key); })) {
      ignored.push_back(key.key);
    }
  }
  return ignored;
}

void warn_of_ignored_keys(const GpuConfig& config, const std::vector<SimulationMode>& modes, std::string_view what) {
  const std::vector<std::string_view> keys = ignored_keys(config, modes);
  if (!keys.empty()) {
    fmt::print(stderr, "grtx: configuration: {} {} no effect in {}\n", fmt::join(keys, ", "),
               keys.size() == 1 ? "has" : "have", what);
  }
}

}  // namespace grtx::sim
