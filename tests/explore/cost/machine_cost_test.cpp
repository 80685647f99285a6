// SPDX-License-Identifier: Apache-2.0
// The whole machine: sums, scaling with parameters, and the RT unit against published silicon.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "grtx/base/child_process.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::explore {
namespace {

nlohmann::json cost_of(const std::vector<std::string>& settings, const std::string& design = "grtx",
                       const CostOptions& options = {}) {
  ChildProcess child("cost", [&] {
    const sim::GpuConfig config = sim::load_config("", settings);
    return cost_json(machine_cost(config, design, sim::machine_inventory(config, {.design = design}), options)).dump();
  });
  return nlohmann::json::parse(child.result());
}

const nlohmann::json& node(const nlohmann::json& tree, const std::string& path) {
  const nlohmann::json* at = &tree;
  std::size_t begin = 0;
  while (begin < path.size()) {
    const std::size_t dot = std::min(path.find('.', begin), path.size());
    for (const auto& child : (*at)["children"]) {
      if (child["name"] == path.substr(begin, dot - begin)) at = &child;
    }
    begin = dot + 1;
  }
  return *at;
}

double area(const nlohmann::json& cost, const std::string& path) {
  return node(cost["tree"], path)["area_mm2"]["central"].get<double>();
}

void expect_sums(const nlohmann::json& n) {
  double mm2 = 0.0;
  std::uint64_t bits = 0;
  for (const auto& item : n["items"]) {
    mm2 += item["area_mm2"]["central"].get<double>();
    if (item.contains("bits")) bits += item["bits"].get<std::uint64_t>();
  }
  for (const auto& child : n["children"]) {
    const double copies = child["copies"].get<double>();
    mm2 += copies * child["area_mm2"]["central"].get<double>();
    bits += child["copies"].get<std::uint64_t>() *
            (child["flip_flop_bits"].get<std::uint64_t>() + child["memory_bits"].get<std::uint64_t>());
    expect_sums(child);
  }
  EXPECT_NEAR(n["area_mm2"]["central"].get<double>(), mm2, 1e-9 + 1e-9 * mm2) << n["name"];
  EXPECT_EQ(n["flip_flop_bits"].get<std::uint64_t>() + n["memory_bits"].get<std::uint64_t>(), bits) << n["name"];
}

TEST(MachineCost, EveryLevelIsTheSumOfWhatIsBelow) {
  const auto cost = cost_of({});
  expect_sums(cost["tree"]);
  EXPECT_EQ(node(cost["tree"], "sm0")["copies"], 8);
  EXPECT_GT(area(cost, "sm0.rt"), 0.0);
}

TEST(MachineCost, MoreOfAPartCostsMoreOfIt) {
  const auto base = cost_of({});
  const struct {
    const char* setting;
    const char* path;
  } cases[] = {{"rt.box.count=8", "sm0.rt.ray_box"},
               {"rt.box.latency=26", "sm0.rt.ray_box"},
               {"rt.triangle.count=8", "sm0.rt.ray_triangle"},
               {"rt.transform.latency=8", "sm0.rt.ray_transform"},
               {"rt.warp_buffer.entries=16", "sm0.rt.warp_buffer"},
               {"rt.warp_buffer.stack_entries=16", "sm0.rt.warp_buffer"},
               {"rt.checkpoint.lanes=32", "sm0.rt.checkpoint_unit"},
               {"rt.checkpoint.write_queue=32", "sm0.rt.checkpoint_unit"},
               {"rt.memory.queue=512", "sm0.rt.memory_scheduler"},
               {"rt.prefetch.records=8", "sm0.rt.sibling_prefetcher"},
               {"l1.bytes=262144", "sm0.l1d"},
               {"l1.mshr_entries=512", "sm0.l1d"},
               {"l2.bytes=8388608", "l2_slice0"},
               {"gpu.sms=16", ""}};
  for (const auto& c : cases) {
    const auto more = cost_of({c.setting});
    EXPECT_GT(area(more, c.path), area(base, c.path)) << c.setting;
    EXPECT_GT(area(more, ""), area(base, "")) << c.setting;
  }
  EXPECT_LT(area(cost_of({"rt.box.interval=2"}), "sm0.rt.ray_box"), area(base, "sm0.rt.ray_box"));
}

TEST(MachineCost, FromSixtyFourRowsOnAMemoryIsAnSram) {
  const auto kind = [](const char* setting) {
    const auto cost = cost_of({setting});
    const std::string unit = "sm0.rt.checkpoint_unit";  // a temporary makes GCC 14 fear for the reference
    for (const auto& item : node(cost["tree"], unit)["items"]) {
      if (item["name"] == "write_queue") return item["kind"].get<std::string>();
    }
    return std::string();
  };
  EXPECT_EQ(kind("rt.checkpoint.write_queue=63"), "flip-flops");
  EXPECT_EQ(kind("rt.checkpoint.write_queue=64"), "SRAM");
}

// "209.091161.18": area and leakage of 1,000 and more filled their columns.
TEST(MachineCost, ColumnsOfALargeChipStandApart) {
  ChildProcess child("cost", [] {
    const sim::GpuConfig config = sim::load_config("", {"gpu.sms=128"});
    return cost_text(machine_cost(config, "grtx", sim::machine_inventory(config, {.design = "grtx"}), {.nm = 45}), 2,
                     false);
  });
  std::istringstream lines(child.result());
  std::string line;
  while (std::getline(lines, line) && !line.starts_with("module")) continue;
  ASSERT_TRUE(lines);
  unsigned large = 0;
  for (std::getline(lines, line); !line.empty(); std::getline(lines, line)) {
    if (line.size() < 40) continue;  // a name of its own line
    const std::string numbers = line.substr(21);
    for (std::size_t end = 9; end <= numbers.size(); end += end < 18 ? 9 : 7) {
      EXPECT_TRUE(end == numbers.size() || numbers[end] == ' ') << line;
    }
    large += numbers.find('.') != std::string::npos && std::stod(numbers.substr(32, 7)) >= 1000.0 ? 1U : 0U;
  }
  EXPECT_GT(large, 0U);
}

TEST(MachineCost, WhatADesignDoesNotUseIsNotThere) {
  EXPECT_GT(area(cost_of({}, "grtx"), "sm0.rt"), area(cost_of({}, "sw"), "sm0.rt"));
  EXPECT_GT(area(cost_of({}, "sw"), "sm0.rt"), area(cost_of({}, "baseline"), "sm0.rt"));
  EXPECT_LT(area(cost_of({"rt.prefetch.enabled=false"}), "sm0.rt"), area(cost_of({}), "sm0.rt"));
}

// One box row with its sort, one triangle, one transform: the configuration of the published cross-check, 0.35 mm2 an
// RT core of Turing (12 nm, die photo). The model's band is 0.6 to 1.8 of its central figure at a control factor of 2.
TEST(MachineCost, RtUnitIsOfTheOrderOfPublishedSilicon) {
  CostOptions options{.nm = 12, .control = 2.0};
  const auto cost = cost_of({"rt.box.count=1", "rt.triangle.count=1", "rt.transform.count=1"}, "baseline", options);
  const double mm2 = area(cost, "sm0.rt");
  EXPECT_GT(1.8 * mm2, 0.35);
  EXPECT_LT(0.6 * mm2, 0.35);
}

TEST(MachineCost, CheckpointLanesAreTheRealKnob) {
  const auto share = [](unsigned lanes) {
    const auto with = cost_of({"rt.checkpoint.lanes=" + std::to_string(lanes), "rt.box.count=1", "rt.triangle.count=1",
                               "rt.transform.count=1"});
    return area(with, "sm0.rt.checkpoint_unit") / area(with, "sm0.rt");
  };
  double last = 0.0;
  for (const unsigned lanes : {1u, 4u, 8u, 32u}) {
    const double now = share(lanes);
    EXPECT_GT(now, last) << lanes;
    EXPECT_LT(now, 0.5) << lanes;
    last = now;
  }
}

}  // namespace
}  // namespace grtx::explore
