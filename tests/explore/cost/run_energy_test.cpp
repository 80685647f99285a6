// SPDX-License-Identifier: Apache-2.0
// Energy of a run against sums by hand: counted actions times their prices.
#include "grtx/explore/cost/run_energy.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/explore/cost/operator_cost.h"
#include "grtx/explore/cost/sram_cost.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::explore {
namespace {

// Central energy of a part in nJ, for one machine an elaboration.
double energy_of(const std::string& part, const std::map<std::string, double>& statistics,
                 const std::vector<std::string>& settings = {}) {
  ChildProcess child("energy", [&] {
    CostOptions options{.nm = 45};
    const sim::GpuConfig config = sim::load_config("", settings);
    const auto value = [&](const std::string& name) {
      const auto found = statistics.find(name);
      return found == statistics.end() ? 0.0 : found->second;
    };
    const auto parts = run_energy(value, config, sim::machine_inventory(config, {.design = "grtx"}), options, {});
    double sum = 0.0;
    for (const EnergyPart& p : parts) sum += p.name == part || part == "total" ? p.nanojoules.central : 0.0;
    return std::to_string(sum);
  });
  return std::stod(child.result());
}

TEST(RunEnergy, AStatisticThatIsMissingIsNamed) {
  const auto energy = [](const std::string& missing) {
    ChildProcess child("energy", [&] {
      const sim::GpuConfig config = sim::load_config("", {});
      const auto value = [&](const std::string& name) -> std::optional<double> {
        if (name == missing) return std::nullopt;
        return 1.0;
      };
      run_energy(value, config, sim::machine_inventory(config, {.design = "grtx"}), {}, {}, "s.json");
      return std::string("priced");
    });
    try {
      return child.result();
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_EQ(energy("gpu.l1.fills"),
            "s.json: gpu.l1.fills: is missing, or no number: the energy of the run cannot be told");
  EXPECT_EQ(energy("gpu.dram.bytes"), "priced");  // a memory that is not ours may not say
  EXPECT_EQ(energy(""), "priced");
}

TEST(RunEnergy, EveryStatisticThatIsPricedIsDeclared) {
  // Every part that a configuration can add. One that is misspelt would be a fault of ours: std::logic_error.
  EXPECT_GE(energy_of("total", {}), 0.0);
}

TEST(RunEnergy, NothingDoneInNoTimeCostsNothing) { EXPECT_EQ(energy_of("total", {}), 0.0); }

TEST(RunEnergy, WhatUnitsHavePricedThemselvesIsPartOfTheTotal) {
  const std::map<std::string, double> statistics = {{"gpu.energy_nj.own", 12.5}};
  EXPECT_NEAR(energy_of("own", statistics), 12.5, 1e-6);
  EXPECT_NEAR(energy_of("total", statistics), 12.5, 1e-6);
}

TEST(RunEnergy, ALineFromGddr6) { EXPECT_NEAR(energy_of("dram", {{"gpu.dram.bytes", 128}}), 7.68, 1e-6); }

TEST(RunEnergy, ATriangleTestIsItsOperatorsAndRegisters) {
  // 23 add at 3.45, 24 mul at 9.64, 4 compare at 0.36 pJ; 37 stages of 416 bits at 0.009 pJ.
  const double pj = 23 * 3.45 + 24 * 9.64 + 4 * 0.36 + 37 * 416 * 0.009;
  EXPECT_NEAR(energy_of("rt.ray_triangle", {{"gpu.rt.ray_triangle.tests", 1000}}), pj, 1e-3);
}

/// Energy of reading and of writing a row of an SM's register file, a register of 32 lanes. For three read ports there
/// are three copies, and a write goes to each.
struct RegisterFileCost {
  explicit RegisterFileCost(std::uint64_t registers) {
    const SramCost copy = sram_cost({.bits = registers * 32, .word_bits = 32 * 32, .two_ports = true, .nm = 45});
    read_pj = copy.read_pj;
    write_pj = 3.0 * copy.write_pj;
  }
  double read_pj = 0.0, write_pj = 0.0;
};

TEST(RunEnergy, AnInstructionReadsThreeRegistersAndWritesOne) {
  const double fma = operator_cost("fp_fma", 32).energy_pj.central;
  for (const unsigned registers : {65536U, 16384U}) {
    const RegisterFileCost file(registers);
    ASSERT_GT(file.read_pj, 0.0);
    const double pj = 32 * fma + 3 * file.read_pj + file.write_pj;
    EXPECT_NEAR(
        energy_of("simt", {{"gpu.simt.instructions.total", 1000}}, {"simt.registers=" + std::to_string(registers)}), pj,
        1e-3)
        << registers;
  }
}

TEST(RunEnergy, AStepOfAHeapReadsAndWritesThreeOfTheWordsOfARow) {
  const RegisterFileCost file(65536);
  const double pj = operator_cost("fp_compare", 32).energy_pj.central + (file.read_pj + file.write_pj) * 3.0 / 32.0;
  // A step takes two cycles: of the unit where hits enter, of the SIMT core where they are taken out.
  const std::map<std::string, double> cycles = {{"gpu.rt.any_hit.unit.busy_cycles", 1500},
                                                {"gpu.simt.heap_cycles", 500}};
  EXPECT_NEAR(energy_of("rt.any_hit_unit", cycles, {"rt.any_hit_unit.enabled=true"}), pj, 1e-3);
  EXPECT_EQ(energy_of("rt.any_hit_unit", {}, {"rt.any_hit_unit.enabled=true"}), 0.0);
}

TEST(RunEnergy, MorePipelinesOrASharedOperatorDoNotChangeATestsEnergy) {
  const std::map<std::string, double> tests = {{"gpu.rt.ray_triangle.tests", 1000}};
  const double base = energy_of("rt.ray_triangle", tests);
  EXPECT_NEAR(energy_of("rt.ray_triangle", tests, {"rt.triangle.count=16"}), base, 1e-3);
  // Rounded up to whole operators and stages.
  EXPECT_NEAR(energy_of("rt.ray_triangle", tests, {"rt.triangle.interval=2"}) / base, 1.0, 0.05);
}

TEST(RunEnergy, LeakageIsPowerTimesTime) {
  const double once = energy_of("leakage", {{"gpu.time_us", 10}});
  EXPECT_GT(once, 0.0);
  EXPECT_NEAR(energy_of("leakage", {{"gpu.time_us", 30}}), 3.0 * once, 1e-3 * once);
}

}  // namespace
}  // namespace grtx::explore
