#include "grtx/rtl_tlm/gpu/mode_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <map>

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
  constexpr SimulationMode kFast = SimulationMode::fast, kCycle = SimulationMode::cycle,
                           kSampled = SimulationMode::sampled;
  static const std::vector<ModeKey> keys = {
      {kFast, "rt.memory.by_shader", "is not modelled by --mode fast"},
      {kFast, "rt.checkpoint.implementation", "must be tlm with --mode fast, which has no clock for RTL"},
      {kFast, "rt.box.implementation", "must be tlm with --mode fast, which has no clock for RTL"},
      {kFast, "rt.transform.implementation", "must be tlm with --mode fast, which has no clock for RTL"},
      {kSampled, "rt.checkpoint.implementation", "must be tlm with --mode sampled: RTL is compared on whole traces"},
      {kSampled, "rt.box.implementation", "must be tlm with --mode sampled: RTL is compared on whole traces"},
      {kSampled, "rt.transform.implementation", "must be tlm with --mode sampled: RTL is compared on whole traces"},
      {kFast, "gpu.rt_units", "must be 1 with --mode fast"},
      {kFast, "dram.scheduling", "is not modelled by --mode fast, which approximates fr_fcfs"},
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
      {kCycle, "fast.spread"},
  };
  return keys;
}

Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode) {
  const Settings settings(config);
  for (const ModeKey& key : mode_keys()) {
    if (key.mode == mode && key.refused != nullptr && settings.differ(key.key))
      return {std::string(key.key), key.refused};
  }
  modules::OwnKeys own = config.own;
  modules::ParameterList brought;
  own.parameters(brought);
  for (const modules::Parameter& key : brought.items()) {
    if (mode == SimulationMode::fast && settings.differ(key.name)) return {key.name, "is not modelled by --mode fast"};
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

std::vector<IdleKey> idle_keys(const GpuConfig& config) {
  const std::vector<std::string> with_file = memory_systems_with_file();
  const bool by_file = std::find(with_file.begin(), with_file.end(), config.dram_model) != with_file.end();
  const std::string& scheduling = config.dram.channel.scheduling;
  const Settings settings(config);
  GpuConfig copy = config;
  std::vector<IdleKey> idle;
  for (const modules::Parameter& parameter : config_keys(copy)) {
    const std::string& key = parameter.name;
    if (!settings.differ(key)) continue;
    if (key == "l1.write_back_buffer" && config.l1.private_writes.policy == modules::WritePolicy::write_through) {
      idle.push_back({key, "l1.private_writes = write_through"});
    }
    if (!key.starts_with("dram.")) continue;
    const bool of_simulators = key.starts_with("dram.simulator.");
    const bool of_all =
        key == "dram.model" || key == "dram.mhz" || key == "dram.fixed_latency" || key == "dram.channels";
    if (by_file ? !of_simulators && !of_all : of_simulators && config.dram_model == kBuiltInMemory) {
      idle.push_back({key, "dram.model = " + config.dram_model});
    } else if ((key == "dram.hit_cap" && (scheduling == modules::kFrFcfs || scheduling == "fcfs")) ||
               (key == "dram.age_cap" && scheduling == "fcfs")) {
      idle.push_back({key, "dram.scheduling = " + scheduling});
    } else if (key == "dram.channels" && by_file && !config.dram_simulator.per_slice) {
      idle.push_back({key, "dram.simulator.per_slice = false"});
    } else if (key == "dram.group_bytes" && config.dram.channel.bank_groups == 1) {
      idle.push_back({key, "dram.bank_groups = 1"});
    } else if (key == "dram.timing.rfc" && config.dram.channel.timing.refi == 0) {
      idle.push_back({key, "dram.timing.refi = 0"});
    }
  }
  return idle;
}

void warn_of_ignored_keys(const GpuConfig& config, const std::vector<SimulationMode>& modes, std::string_view what) {
  const std::vector<std::string_view> keys = ignored_keys(config, modes);
  const auto warn = [](const auto& names, const std::string& where) {
    if (names.empty()) return;
    fmt::print(stderr, "grtx: configuration: {} {} no effect {}\n", fmt::join(names, ", "),
               names.size() == 1 ? "has" : "have", where);
  };
  warn(keys, fmt::format("in {}", what));
  std::map<std::string, std::vector<std::string>> idle;  // by reason
  for (const IdleKey& each : idle_keys(config)) idle[each.because].push_back(each.key);
  for (const auto& [because, names] : idle) warn(names, "with " + because);
}

}  // namespace grtx::sim
