#include "grtx/rtl_tlm/estimate/sampled/scaled_machine.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace grtx::sim {
namespace {

/// value * factor, rounded, at least `least`.
unsigned scaled(unsigned value, double factor, unsigned least) {
  return std::max(least, static_cast<unsigned>(std::lround(value * factor)));
}

}  // namespace

ModelMachine model_of(const GpuConfig& config) {
  ModelMachine machine;
  machine.sms = config.sms;
  machine.resident_warps = config.resident_warps;
  machine.call_slots = config.rt.warp_buffer.entries * config.rt_units;
  return machine;
}

ModelRates nominal_rates(const GpuConfig& config) {
  const double bursts = config.interleave.slices * config.memory_mhz / config.core_mhz / config.dram.channel.timing.ccd;
  // A miss takes the crossbar twice, the L2 and the DRAM, some 300 cycles with the paper's latencies. An RT unit asks
  // for a sector a cycle at most. An SM's MSHRs allow so many misses in the time of one under load. Channels are 60 to
  // 95 % busy in runs that they limit.
  ModelRates rates;
  rates.step_cycles = 300.0;
  rates.sm_sectors = 0.85 * config.rt_units;
  rates.sm_far = 0.6 * config.l1.mshr_entries / 256.0;
  rates.memory_sectors = 0.9 * bursts * config.dram.channel.burst_bytes / modules::kSectorBytes;
  return rates;
}

GpuConfig one_sm(const GpuConfig& config, double share) {
  GpuConfig part = config;
  part.sms = 1;
  const double channels = config.interleave.slices * share;
  unsigned slices = std::max(1u, static_cast<unsigned>(std::ceil(channels - 1e-9)));
  if (config.interleave.xor_hash) slices = std::bit_ceil(slices);
  part.interleave.slices = slices;
  const std::uint64_t smallest = slices * std::uint64_t{config.l2.geometry.line_bytes} * config.l2.geometry.ways;
  part.l2_bytes =
      std::max(smallest, static_cast<std::uint64_t>(std::llround(static_cast<double>(config.l2_bytes) * share)));
  const double rate = std::min(1.0, channels / slices);  // of a channel
  if (rate > 0.999) return part;
  part.memory_mhz = config.memory_mhz * rate;
  part.dram.fixed_latency = static_cast<Cycle>(std::llround(static_cast<double>(config.dram.fixed_latency) * rate));
  modules::DramChannelConfig& channel = part.dram.channel;
  channel.age_cap = static_cast<Cycle>(std::llround(static_cast<double>(channel.age_cap) * rate));
  channel.banks = scaled(channel.banks, rate, channel.bank_groups);
  channel.banks -= channel.banks % channel.bank_groups;
  if (channel.bank_xor) channel.banks = std::bit_floor(channel.banks);
  channel.queue = scaled(channel.queue, rate, 8);
  modules::DramTiming& t = channel.timing;  // CCD, RRD and FAW are rates: they stay in clocks
  for (unsigned* clocks : {&t.rcd, &t.ras, &t.rp, &t.rc, &t.cl, &t.wl, &t.cdlr, &t.wr, &t.rtp, &t.turn}) {
    *clocks = scaled(*clocks, rate, 1);
  }
  for (unsigned* clocks : {&t.cdlr_l, &t.rcd_wr, &t.refi, &t.rfc}) {
    if (*clocks != 0) *clocks = scaled(*clocks, rate, 1);
  }
  modules::L2Slice::Config& l2 = part.l2;
  l2.mshr_entries = scaled(l2.mshr_entries, rate, 8);
  l2.queue = scaled(l2.queue, rate, 8);
  l2.reply_queue = std::max(l2.mshr_merges, scaled(l2.reply_queue, rate, 8));
  l2.dram_queue = std::max(l2.geometry.sectors(), scaled(l2.dram_queue, rate, 8));
  part.crossbar.output_buffer = scaled(part.crossbar.output_buffer, rate, 4);
  return part;
}

ScaledMachine half_sm(const GpuConfig& config) {
  const bool divides = config.rt.warp_buffer.entries % 2 == 0;
  const double part = divides ? 0.5 : 1.0;
  const double share = part / config.sms;
  ScaledMachine machine{one_sm(config, share), model_of(config)};
  if (divides) {
    GpuConfig& c = machine.config;
    c.rt.warp_buffer.entries /= 2;
    c.resident_warps = std::max(c.rt.warp_buffer.entries * c.rt_units, c.resident_warps / 2);
    const std::uint64_t line_set = std::uint64_t{c.l1.geometry.line_bytes};
    c.l1.geometry.ways = std::max(1u, c.l1.geometry.ways / 2);
    c.l1.geometry.bytes = std::max(line_set * c.l1.geometry.ways, c.l1.geometry.bytes / 2);
    c.l1.mshr_entries = std::max(1u, c.l1.mshr_entries / 2);
  }
  machine.model.sms = 1;
  machine.model.resident_warps = machine.config.resident_warps;
  machine.model.call_slots = machine.config.rt.warp_buffer.entries * config.rt_units;
  machine.model.memory_share = share;
  return machine;
}

ScaledMachine idle_neighbours(const GpuConfig& config) {
  const double share = std::min(1.0, 2.0 / config.sms);
  ScaledMachine machine{one_sm(config, share), model_of(config)};
  machine.model.sms = 1;
  machine.model.memory_share = share;
  return machine;
}

}  // namespace grtx::sim
