// Parts of a machine: rates in proportion, latencies kept, and always a machine that can be built.
#include "grtx/rtl_tlm/estimate/sampled/scaled_machine.h"
#include "paths.h"

#include <gtest/gtest.h>

#include <ostream>

namespace grtx::sim {
namespace {

GpuConfig paper() { return load_config(grtx::paths::source_dir() + "/configs/paper.toml", {}); }

/// Bytes a second of all channels.
double bandwidth(const GpuConfig& c) {
  return c.interleave.slices * c.memory_mhz * c.dram.channel.burst_bytes / c.dram.channel.timing.ccd;
}

TEST(HalfSm, IsASixteenthOfThePapersMachine) {
  const GpuConfig whole = paper();
  const ScaledMachine half = half_sm(whole);
  const GpuConfig& c = half.config;
  EXPECT_EQ(c.sms, 1U);
  EXPECT_EQ(c.rt.warp_buffer.entries, 4U);
  EXPECT_EQ(c.l1.geometry.bytes, 65536U);
  EXPECT_EQ(c.l2_bytes, 4U * 1024 * 1024 / 16);
  EXPECT_NEAR(bandwidth(c) / bandwidth(whole), 1.0 / 16, 1e-9);
  EXPECT_DOUBLE_EQ(half.model.memory_share, 1.0 / 16);
  EXPECT_EQ(half.model.call_slots, 4U);
  // Latencies in nanoseconds stay, within half a clock of the slower memory.
  const auto nanoseconds = [](const GpuConfig& config, double clocks) { return clocks * 1e3 / config.memory_mhz; };
  const double clock = nanoseconds(c, 1.0);
  EXPECT_NEAR(nanoseconds(c, c.dram.channel.timing.rcd), nanoseconds(whole, whole.dram.channel.timing.rcd), clock / 2);
  EXPECT_NEAR(nanoseconds(c, static_cast<double>(c.dram.fixed_latency)),
              nanoseconds(whole, static_cast<double>(whole.dram.fixed_latency)), clock / 2);
}

TEST(IdleNeighbours, TakesWholeChannelsWhereTheyDivide) {
  const GpuConfig whole = paper();
  const ScaledMachine part = idle_neighbours(whole);
  EXPECT_EQ(part.config.interleave.slices, 1U);
  EXPECT_EQ(part.config.memory_mhz, whole.memory_mhz);
  EXPECT_EQ(part.config.l2_bytes, whole.l2_bytes / 4);
  EXPECT_DOUBLE_EQ(part.model.memory_share, 0.25);
  EXPECT_EQ(part.model.call_slots, 8U);
}

struct Machine {
  const char* name;
  std::vector<std::string> settings;
  friend void PrintTo(const Machine& machine, std::ostream* out) { *out << machine.name; }
};
class ScaledMachines : public ::testing::TestWithParam<Machine> {};

TEST_P(ScaledMachines, CanBeBuiltAndKeepTheMemorysShare) {
  const GpuConfig whole = load_config(grtx::paths::source_dir() + "/configs/paper.toml", GetParam().settings);
  for (const ScaledMachine& machine : {half_sm(whole), idle_neighbours(whole)}) {
    EXPECT_NO_THROW(check_config(machine.config, GetParam().name));
    EXPECT_EQ(machine.config.sms, 1U);
    EXPECT_NEAR(bandwidth(machine.config) / bandwidth(whole), machine.model.memory_share, 1e-9);
    EXPECT_GE(machine.config.resident_warps, machine.config.rt.warp_buffer.entries * machine.config.rt_units);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Configurations, ScaledMachines,
    ::testing::Values(Machine{"paper", {}}, Machine{"one_sm", {"gpu.sms=1"}}, Machine{"three_sms", {"gpu.sms=3"}},
                      Machine{"many", {"gpu.sms=128", "l2.slices=16"}}, Machine{"odd_slices", {"l2.slices=3"}},
                      Machine{"one_warp", {"rt.warp_buffer.entries=1"}},
                      Machine{"odd_warps", {"rt.warp_buffer.entries=5"}},
                      Machine{"tiny_caches", {"l1.bytes=2048", "l1.ways=16", "l2.bytes=65536", "l2.slices=2"}},
                      Machine{"direct_mapped", {"l1.ways=1"}},
                      Machine{"xor", {"l2.xor_hash=true", "dram.bank_xor=true"}},
                      Machine{"two_units", {"gpu.rt_units=2", "gpu.resident_warps=16"}}),
    [](const auto& i) { return std::string(i.param.name); });

}  // namespace
}  // namespace grtx::sim
