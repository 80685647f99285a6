// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/idle_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "grtx/modules/rt_unit/rt_unit_table.h"

namespace grtx::sim {

std::vector<IdleKey> idle_keys(const GpuConfig& config) {
  const std::vector<std::string> with_file = memory_systems_with_file();
  const bool by_file = std::find(with_file.begin(), with_file.end(), config.dram_model) != with_file.end();
  const std::string& scheduling = config.dram.channel.scheduling;
  const nlohmann::ordered_json values = config_json(config), defaults = config_json(GpuConfig{});
  const std::vector<modules::PartInfo> parts = modules::part_table(config.rt, config.own);
  GpuConfig copy = config;
  std::vector<IdleKey> idle;
  for (const modules::Parameter& parameter : config_keys(copy)) {
    const std::string& key = parameter.name;
    if (values.at(key) == defaults.at(key)) continue;
    if (key == "l1.write_back_buffer" && config.l1.private_writes.policy == modules::WritePolicy::write_through) {
      idle.push_back({key, "l1.private_writes = write_through"});
    }
    for (const modules::PartInfo& part : parts) {
      for (const modules::PartIdleKeys& keys : part.idle_keys) {
        if (keys.key.ends_with('.') ? key.starts_with(keys.key) : key == keys.key) idle.push_back({key, keys.because});
      }
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

void warn_of_idle_keys(const GpuConfig& config) { warn_of(idle_keys(config)); }

void warn_of(const std::vector<IdleKey>& keys) {
  std::map<std::string, std::vector<std::string>> idle;  // by reason
  for (const IdleKey& each : keys) idle[each.because].push_back(each.key);
  for (const auto& [because, names] : idle) {
    fmt::print(stderr, "grtx: configuration: {} {} no effect with {}\n", fmt::join(names, ", "),
               names.size() == 1 ? "has" : "have", because);
  }
}

}  // namespace grtx::sim
