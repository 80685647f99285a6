// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/host_speed.h"

#include <algorithm>

#include "grtx/modules/kernel/clock_domain.h"

namespace grtx::sim {

void add_host_speed(modules::StatisticList& host, const HostWork& work, const GpuConfig& config) {
  const auto cycles = static_cast<double>(work.cycles);
  const double wall = std::max(work.wall_seconds, 1e-9);
  const double modelled = cycles * static_cast<double>(modules::ClockDomain::period_fs(config.core_mhz)) * 1e-15;
  host.add("host.cycles_per_second", cycles / wall, "cycles/s", "core cycles of the model a second of wall time",
           modules::StatisticKind::ratio);
  host.add("host.sm_cycles_per_second", cycles * config.sms / wall, "SM-cycles/s",
           "core cycles of all SMs of the model a second of wall time", modules::StatisticKind::ratio);
  host.add("host.node_visits_per_second", static_cast<double>(work.visits) / wall, "visits/s",
           "lane visits of the trace a second of wall time", modules::StatisticKind::ratio);
  host.add("host.slowdown", modelled > 0.0 ? wall / modelled : 0.0, "ratio",
           "wall time over the time that the modelled GPU takes", modules::StatisticKind::ratio);
  host.add("host.cycles_per_cpu_second", cycles / std::max(work.cpu_seconds, 1e-9), "cycles/s",
           "core cycles of the model a second of processor time: what a busy machine does not change",
           modules::StatisticKind::ratio);
}

}  // namespace grtx::sim
