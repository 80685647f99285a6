// SPDX-License-Identifier: Apache-2.0
// configs/dram/gddr6.toml against what its clocks allow: streaming, one bank group, activation limits, the share of
// refresh.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "modules/memory_mocks.h"
#include "paths.h"

namespace grtx::sim {
namespace {

GpuConfig gddr6(const std::vector<std::string>& settings = {}) {
  return load_config(grtx::paths::source_dir() + "/configs/dram/gddr6.toml", settings);
}

using Addresses = std::function<std::uint64_t(unsigned request)>;
std::uint64_t streaming(unsigned i) { return std::uint64_t{i} * 32; }
/// A bank group's blocks only.
std::uint64_t one_group(unsigned i) { return std::uint64_t{i} / 4 * 512 + i % 4 * 32; }
std::uint64_t anywhere(unsigned i) {
  modules::Random random(i);
  return random.below(std::uint64_t{1} << 23) * 32;
}

constexpr unsigned kRequests = 100'000;

/// Clocks a read of 32 B, with the queue full all the time.
double clocks_of_a_read(const modules::DramChannelConfig& config, const Addresses& address) {
  modules::DramChannel channel(config);
  Cycle clock = 1, last = 0;
  const auto take_completions = [&] {
    for (auto& done = channel.completions(); !done.empty(); done.pop()) last = done.front().done;
  };
  for (unsigned i = 0; i < kRequests; ++i) {
    take_completions();
    if (channel.run_until(clock - 1); !channel.can_accept(32)) clock = channel.run_until_room(32) + 1;
    channel.enqueue(clock, i, address(i), 32, false);
  }
  channel.run_until(modules::kNever - 1);
  take_completions();
  return static_cast<double>(last) / kRequests;
}

struct Limit {
  const char* name;
  std::vector<std::string> settings;
  Addresses addresses;
  double clocks;  ///< a read
  bool refresh = false;
  friend void PrintTo(const Limit& limit, std::ostream* out) { *out << limit.name; }
};

class Gddr6 : public ::testing::TestWithParam<Limit> {
 protected:
  /// No faster than the clocks allow, and at most 3 % slower.
  static void expect_limit(double clocks) {
    const modules::DramTiming t = gddr6(GetParam().settings).dram.channel.timing;
    double least = GetParam().clocks;
    double most = least * 1.03;
    if (GetParam().refresh) {
      // In each REFI at least RFC is lost, and at most also the time in which the last row opened is closed and a
      // first one opened, all without data.
      const auto left = [&](unsigned lost) { return 1.0 - static_cast<double>(lost) / t.refi; };
      least /= left(t.rfc);
      most /= left(t.rfc + t.ras + t.rp + t.rcd);
    }
    EXPECT_GE(clocks, least * 0.999);
    EXPECT_LE(clocks, most);
  }
};

TEST_P(Gddr6, ReachesItsLimit) {
  const modules::DramChannelConfig config = gddr6(GetParam().settings).dram.channel;
  expect_limit(clocks_of_a_read(config, GetParam().addresses));
}

const char* kNoRefresh = "dram.timing.refi=0";
INSTANTIATE_TEST_SUITE_P(
    Limits, Gddr6,
    ::testing::Values(Limit{"streaming_is_a_burst_every_ccd", {kNoRefresh}, streaming, 2},
                      Limit{"one_bank_group_is_a_burst_every_ccd_l", {kNoRefresh}, one_group, 4},
                      Limit{"random_is_an_activate_every_rrd", {kNoRefresh}, anywhere, 8},
                      Limit{"random_is_four_activates_every_faw", {kNoRefresh, "dram.timing.faw=48"}, anywhere, 12},
                      Limit{"streaming_without_the_time_of_refresh", {}, streaming, 2, true},
                      Limit{"random_without_the_time_of_refresh", {}, anywhere, 8, true}),
    [](const auto& limit) { return std::string(limit.param.name); });

TEST(Gddr6Part, HasTheDefaultsBandwidthAndUnloadedLatency) {
  const auto nanoseconds = [](const GpuConfig& c, Cycle clocks) {
    return static_cast<double>(clocks) * 1e3 / c.memory_mhz;
  };
  const auto burst = [&](const GpuConfig& c) { return nanoseconds(c, c.dram.channel.timing.ccd); };
  const auto closed_row = [&](const GpuConfig& c) {
    const modules::DramTiming& t = c.dram.channel.timing;
    return nanoseconds(c, t.rcd + t.cl + t.ccd + c.dram.fixed_latency);
  };
  const GpuConfig vulkan_sim;
  EXPECT_NEAR(32.0 / burst(gddr6()), 28.0, 1e-9) << "GB/s of a channel";
  EXPECT_NEAR(burst(gddr6()), burst(vulkan_sim), 1e-9);
  EXPECT_NEAR(closed_row(gddr6()), closed_row(vulkan_sim), 0.3);
}

}  // namespace
}  // namespace grtx::sim
