// SPDX-License-Identifier: Apache-2.0
// The paper's hardware-cost table to the byte, from the very module that is simulated; and the buffers in global
// memory.
#include <gtest/gtest.h>

#include "grtx/base/child_process.h"
#include "grtx/explore/cost/checkpoint_storage.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::explore {
namespace {

nlohmann::json storage_of(unsigned warps, const std::string& design) {
  sim::GpuConfig config = sim::load_config("", {"rt.warp_buffer.entries=" + std::to_string(warps), "gpu.sms=1"});
  const auto inventories = sim::machine_inventory(config, {.design = design});
  return cost_json(machine_cost(config, design, inventories, {}));
}

TEST(CheckpointStorage, EqualsThePapersTable) {
  const std::pair<unsigned, std::uint64_t> cases[] = {{4, 546}, {8, 1074}, {16, 2130}, {32, 4242}};
  for (const auto& [warps, bytes] : cases) {
    ChildProcess child("cost", [w = warps] { return storage_of(w, "grtx").dump(); });
    const auto json = nlohmann::json::parse(child.result());
    EXPECT_EQ(json["checkpoint_storage"]["bytes"], bytes) << warps << " warps";
    const auto& bits = json["checkpoint_storage"]["bits"];
    EXPECT_EQ(bits["replay_flag"], warps * 32);
    EXPECT_EQ(bits["source_offset"], warps * 32 * 16);
    EXPECT_EQ(bits["destination_offset"], warps * 32 * 16);
    EXPECT_EQ(bits["source_base"], 64);
    EXPECT_EQ(bits["destination_base"], 64);
    EXPECT_EQ(bits["maximum_size"], 16);
  }
}

TEST(CheckpointStorage, ADesignWithoutCheckpointingHasNone) {
  ChildProcess child("cost", [] { return storage_of(8, "sw").dump(); });
  EXPECT_EQ(nlohmann::json::parse(child.result())["checkpoint_storage"]["bytes"], 0);
}

TEST(BufferSizes, ReproduceThePapersTotals) {
  BufferSizes sizes;  // 5 Nc + Ne = 1563, one of its solutions
  EXPECT_EQ(sizes.bytes_per_ray(), 12504u);
  EXPECT_EQ(sizes.bytes(), 102432768u);
  const double mib = static_cast<double>(sizes.bytes()) / (1024.0 * 1024.0);
  EXPECT_EQ(static_cast<int>(mib * 100.0), 9768);  // 97.6875: the paper's 97.68 is truncated
  sizes.sms = 170;
  EXPECT_EQ(sizes.bytes(), 2176696320u);
  const double gib = static_cast<double>(sizes.bytes()) / (1024.0 * 1024.0 * 1024.0);
  EXPECT_NEAR(gib, 2.03, 0.005);
  EXPECT_NEAR(gib / 32.0, 0.063, 0.0005);
}

}  // namespace
}  // namespace grtx::explore
