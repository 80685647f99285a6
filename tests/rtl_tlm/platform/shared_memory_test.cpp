// SPDX-License-Identifier: Apache-2.0
// A GPU on a memory that others use, too: it writes zeros into its own buffers, and nothing anywhere else. With
// keep_data it changes nothing at all.
#include <gtest/gtest.h>

#include <set>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "paths.h"
#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/platform/shared_memory.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using test::others_byte;
using test::SharedMemory;
using traces::testing::TemporaryFile;

/// What two launches have changed: bytes that became 0, became something else, and the regions that they lie in.
struct Changed {
  std::uint64_t zeros = 0, others = 0;
  std::set<std::string> regions;
};

Changed changed_by_launches(bool keep_data) {
  const TemporaryFile file("trace");
  const auto trace = traces::testing::random_trace(
      {.seed = 11, .groups = 12, .warp_size = 32, .checkpoint = true, .capacity = 1000, .two_level = true});
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    GpuComponent::Options options;
    options.machine = load_config(grtx::paths::source_dir() + "/configs/small.toml",
                                  {"l2.bytes=8192", "l2.ways=4", "rt.warp_buffer.spill=true",
                                   "rt.warp_buffer.stack_entries=2", "gpu.resident_warps=2"});
    options.traces = {file.path()};
    options.keep_data = keep_data;
    options.memory = [](Gpu& gpu, const BuildOptions&) { return std::make_unique<SharedMemory>(gpu); };
    test::LaunchedGpu launched_gpu("gpu0", options, {{0}, {0, true}});
    sc_core::sc_start();
    nlohmann::json found = {0, 0, nlohmann::json::array()};
    if (launched_gpu.gpu.results().size() != 2) found[2].push_back("not two launches");
    for (const SimulationResult& result : launched_gpu.gpu.results()) {
      for (const std::string& violation : result.violations) found[2].push_back(violation);
    }
    const auto& bytes = dynamic_cast<SharedMemory&>(launched_gpu.gpu.memory()).contents.bytes;
    const auto& extents = launched_gpu.gpu.gpu().map().extents();
    for (std::uint64_t at = 0; at < bytes.size(); ++at) {
      if (bytes[at] == others_byte(at)) continue;
      ++found[bytes[at] == 0 ? 0 : 1].get_ref<nlohmann::json::number_integer_t&>();
      std::string region = "no region";
      for (const auto& extent : extents) {
        const std::uint64_t end = (extent.base + extent.bytes + 31) / 32 * 32;  // whole sectors
        if (at >= extent.base && at < end) region = extent.name;
      }
      if (found[2].empty() || found[2].back() != region) found[2].push_back(region);
    }
    return found.dump();
  });
  const auto found = nlohmann::json::parse(child.result());
  return {found[0], found[1], found[2].get<std::set<std::string>>()};
}

// Write-backs carried leftovers of reads: thousands of bytes of others' in places where none had been.
TEST(GpuOnASharedMemory, WritesNoLeftoversOfOtherAddresses) {
  const Changed changed = changed_by_launches(false);
  EXPECT_GT(changed.zeros, 1000u);
  EXPECT_EQ(changed.others, 0u);
  EXPECT_EQ(changed.regions, (std::set<std::string>{"k_buffer", "checkpoint", "eviction", "pixel", "stack"}));
}

TEST(GpuOnASharedMemory, ChangesNothingWithKeepData) {
  const Changed changed = changed_by_launches(true);
  EXPECT_EQ(changed.zeros, 0u);
  EXPECT_EQ(changed.others, 0u);
  EXPECT_EQ(changed.regions, std::set<std::string>{});
}

}  // namespace
}  // namespace grtx::sim
