// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/monitored_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <utility>

#include "grtx/rtl_tlm/gpu/gpu.h"

namespace grtx::sim {

MonitoredMemory::MonitoredMemory(Gpu& gpu, std::string model, bool check) : model_(std::move(model)) {
  for (std::size_t i = 0; i < gpu.dram.size(); ++i) {
    monitors_.push_back(std::make_unique<modules::AtMonitor>(fmt::format("memory_monitor{}", i).c_str()));
    if (!check) {
      gpu.dram[i].bind(monitors_.back()->target);
      continue;
    }
    modules::AtProtocolChecker::Config rules;
    rules.period_fs = gpu.core().period_fs();
    rules.address_limit = gpu.base() + gpu.memory_bytes();
    checkers_.push_back(
        std::make_unique<modules::AtProtocolChecker>(fmt::format("memory_checker{}", i).c_str(), rules));
    gpu.dram[i].bind(checkers_.back()->target);
    checkers_.back()->initiator.bind(monitors_.back()->target);
  }
}

bool MonitoredMemory::restart(modules::Caches) {
  for (const auto& monitor : monitors_) monitor->restart();
  for (const auto& checker : checkers_) checker->restart();
  return true;
}

bool MonitoredMemory::idle() const {
  return std::all_of(monitors_.begin(), monitors_.end(), [](const auto& monitor) { return monitor->idle(); });
}

void MonitoredMemory::dump_state(std::ostream& out) const {
  for (const auto& monitor : monitors_) {
    const MemoryTraffic& t = monitor->traffic();
    out << monitor->name() << ": " << t.reads << " reads, " << t.writes << " writes, " << t.responses
        << " responses, outstanding " << monitor->outstanding()
        << (monitor->outstanding() == 0 && !monitor->idle() ? ", response open" : "") << '\n';
  }
}

void MonitoredMemory::statistics(modules::StatisticList& list, const std::string& prefix) const {
  describe_traffic(list, prefix);
  double sum = 0.0;
  std::uint64_t responses = 0;
  for (const auto& monitor : monitors_) {
    sum += monitor->mean_latency_ns() * static_cast<double>(monitor->traffic().responses);
    responses += monitor->traffic().responses;
  }
  list.add(prefix + ".latency", responses == 0 ? 0.0 : sum / static_cast<double>(responses), "ns",
           "mean from the begin of a request to the begin of its response, at the socket",
           modules::StatisticKind::mean);
}

std::vector<std::string> MonitoredMemory::violations() const {
  std::vector<std::string> all;
  for (const auto& checker : checkers_) {
    for (const std::string& message : checker->messages()) all.push_back("base protocol: " + message);
  }
  return all;
}

}  // namespace grtx::sim
