// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/dram/decide/dram_config.h"

namespace grtx::modules {

const CounterTable<DramChannelCounters>& DramChannelCounters::table() {
  using C = DramChannelCounters;
  const auto refreshes = [](const C& c, StatisticList& list, const std::string& prefix) {
    if (c.refreshes == 0 && !list.is_reference()) return;
    list.add(prefix + ".refreshes", c.refreshes, "commands",
             "refreshes of all banks of a channel, due before its last column command", StatisticKind::count);
  };
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::reads, "reads", "requests", "read requests")
          .sum(&C::writes, "writes", "requests", "write requests")
          .sum(&C::bytes, "bytes", "B", "bytes read and written")
          .sum(&C::responses, "responses", "requests", "responses begun")
          .sum(&C::refused)
          .sum(&C::row_hits, "row_hits", "requests", "requests that found their row open")
          .sum(&C::row_misses, "row_misses", "requests", "requests that needed an activate")
          .sum(&C::row_conflicts, "row_conflicts", "requests", "requests that needed a precharge first")
          .sum(&C::activates, "activates", "commands", "activate commands")
          .sum(&C::precharges, "precharges", "commands", "precharge commands")
          .sum(&C::refreshes)
          .described(refreshes)
          .sum(&C::bursts, "bursts", "commands", "column commands")
          .sum(&C::aged, "aged", "requests", "requests that reached the age cap of the scheduler")
          .sum(&C::queue_clocks, "queue_clocks", "burst-clocks", "queued bursts summed over memory clocks")
          .sum(&C::full_clocks, "queue_full_clocks", "clocks",
               "clocks in which a request waited for room in a channel's queue")
          .sum(&C::latency_clocks)
          .mean({"", &C::latency_clocks}, {"", [](const C& c) { return c.reads + c.writes; }}, "access_latency",
                "clocks", "mean from arrival in the queue to the last data, memory clocks, without the fixed latency");
  return table;
}

DramCounters dram_counters(const DramChannelConfig& config, const std::vector<DramChannelCounters>& channels,
                           std::uint64_t clocks) {
  DramCounters sum;
  for (const DramChannelCounters& channel : channels) sum.channel += channel;
  sum.clocks = clocks;
  const double peak = static_cast<double>(channels.size()) * config.burst_bytes / config.timing.ccd;
  if (clocks > 0) {
    sum.bandwidth_utilisation = static_cast<double>(sum.channel.bytes) / (peak * static_cast<double>(clocks));
    sum.of_peak.part = sum.channel.bytes * config.timing.ccd;
    sum.of_peak.whole = channels.size() * config.burst_bytes * clocks;
  }
  return sum;
}

void describe(const DramCounters& c, const std::vector<DramChannelCounters>& channels, StatisticList& list,
              const std::string& prefix) {
  DramChannelCounters::table().describe(c.channel, list, prefix);
  list.add({prefix + ".bandwidth_utilisation", c.bandwidth_utilisation, "1", "bytes / peak bytes of the elapsed time",
            0.0, StatisticKind::share, c.of_peak});
  for (std::size_t i = 0; i < channels.size(); ++i) {
    list.add(prefix + ".channel" + std::to_string(i) + ".bytes", channels[i].bytes, "B", "bytes read and written",
             StatisticKind::count);
  }
}

}  // namespace grtx::modules
