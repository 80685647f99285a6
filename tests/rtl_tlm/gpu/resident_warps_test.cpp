// SPDX-License-Identifier: Apache-2.0
// Warps that an SM holds: as many as it has slots for, or as its register file has registers for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using ::testing::HasSubstr;

struct Case {
  std::uint64_t registers;
  unsigned per_thread, payload, slots, warps;
};

TEST(ResidentWarps, FollowFromRegistersWhereThoseAreGiven) {
  // registers / (32 (per_thread + payload)), rounded down, never more than there are slots.
  const Case cases[] = {{65536, 0, 0, 48, 48},   {65536, 32, 0, 48, 48},  {65536, 64, 0, 48, 32},
                        {65536, 64, 32, 48, 21}, {65536, 128, 0, 48, 16}, {65536, 255, 0, 48, 8},
                        {98304, 96, 0, 32, 32},  {98304, 96, 32, 32, 24}, {8160, 255, 0, 48, 1}};
  for (const Case& c : cases) {
    const GpuConfig config = load_config(
        "", {"gpu.resident_warps=" + std::to_string(c.slots), "simt.registers=" + std::to_string(c.registers),
             "simt.registers_per_thread=" + std::to_string(c.per_thread),
             "simt.payload_registers=" + std::to_string(c.payload)});
    EXPECT_EQ(config.resident(), c.warps) << c.registers << " " << c.per_thread << " " << c.payload;
    EXPECT_EQ(config.sm(0).resident_warps, c.warps);
  }
}

std::string refusal(const std::vector<std::string>& settings) {
  try {
    load_config("", settings);
    return "";
  } catch (const Error& error) {
    return error.place() + ": " + error.rule();
  }
}

TEST(ResidentWarps, RefuseAProgramThatDoesNotFit) {
  EXPECT_THAT(refusal({"simt.registers=8159", "simt.registers_per_thread=255"}),
              HasSubstr("simt.registers_per_thread: must leave simt.registers for a warp"));
  EXPECT_THAT(refusal({"simt.payload_registers=32"}), HasSubstr("needs simt.registers_per_thread"));
  EXPECT_THAT(refusal({"simt.registers_per_thread=255", "gpu.rt_units=9"}), HasSubstr("gpu.rt_units"));
}

// Fewer warps by their registers are fewer warps: the run is that of so many slots.
TEST(ResidentWarps, ARunIsThatOfSoManySlots) {
  const test::ObservedRun run;
  const auto slots = run.run({}, {"gpu.resident_warps=3"});
  const auto registers = run.run({}, {"simt.registers=16384", "simt.registers_per_thread=120"});  // 4.27
  const auto payload =
      run.run({}, {"simt.registers=16384", "simt.registers_per_thread=120", "simt.payload_registers=32"});  // 3.37
  for (const auto& [name, entry] : slots.items()) {
    if (name.starts_with("host.") || name.starts_with("gpu.energy")) continue;  // the register file is another
    EXPECT_EQ(payload.at(name), entry) << name;
  }
  EXPECT_NE(registers.at("gpu.cycles"), slots.at("gpu.cycles"));
}

}  // namespace
}  // namespace grtx::sim
