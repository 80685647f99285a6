// SPDX-License-Identifier: Apache-2.0
// Boxes as leaves: a shader on the SM tests what lies in them, one call after the other for a ray that waits for it.
#include <gtest/gtest.h>

#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::sim {
namespace {

using test::statistic;

/// One ray: its first leaf is missed, its second hit.
void write_one_ray(const std::string& path, traces::AccelKind kind) {
  const test::TinyTrace tiny{1, 1};
  traces::Header header = test::tiny_header(tiny);
  header.accel = kind;
  traces::RayGroup group = test::tiny_group(tiny, 0);
  if (traces::has_box_leaves(kind)) {
    group.nodes[0].child_kinds[0] = group.nodes[0].child_kinds[1] = traces::NodeKind::procedural;
  }
  traces::Ray& ray = group.rays[0];
  ray.events[1].detail = static_cast<std::uint8_t>(traces::LeafOutcome::miss);
  ray.events[2].kind_shifts = traces::Event::pack(traces::EventKind::visit_leaf);
  ray.rounds[0].k_count = ray.rounds[0].processed_count = 1;
  ray.processed.resize(1);
  traces::Writer writer(path, header);
  writer.append(group);
  writer.finish();
}

nlohmann::ordered_json stats_of(traces::AccelKind kind, const std::vector<std::string>& settings) {
  const traces::testing::TemporaryFile file("box");
  write_one_ray(file.path(), kind);
  return test::small_statistics(file.path(), settings);
}

TEST(BoxLeaves, EachIsACallOfTheIntersectionShaderAndAHitOneOfTheAnyHitShaderToo) {
  const auto stats = stats_of(traces::AccelKind::box, {});
  EXPECT_EQ(statistic(stats, "gpu.rt.intersection_calls"), 2U);
  EXPECT_EQ(statistic(stats, "gpu.rt.any_hit_calls"), 1U);
  EXPECT_EQ(statistic(stats, "gpu.simt.intersection.batches"), 2U);
  EXPECT_EQ(statistic(stats, "gpu.simt.any_hit.batches"), 1U);
  EXPECT_EQ(statistic(stats, "gpu.simt.instructions.intersection"), 2U * (28 + 24));
  EXPECT_EQ(statistic(stats, "gpu.rt.ray_sphere.operations"), 0U);
  EXPECT_EQ(statistic(stats, "gpu.rt.ray_transform.operations"), 0U);
  // Blending reads the record of one Gaussian, 48 B in two sectors; two matrices of 48 B lie in three.
  EXPECT_GE(statistic(stats, "gpu.simt.lsu.loads.gaussian"), 2U + 3U);
}

// A single ray waits for each: its run is longer by exactly what the shader is.
TEST(BoxLeaves, EveryInstructionOfTheShaderIsACycleOfTheRay) {
  const std::uint64_t usual = statistic(stats_of(traces::AccelKind::box, {}), "gpu.cycles");
  const auto cycles = [&](const std::string& key, unsigned value) {
    return statistic(stats_of(traces::AccelKind::box, {"simt.cost." + key + "=" + std::to_string(value)}),
                     "gpu.cycles");
  };
  EXPECT_EQ(cycles("intersection_fixed", 28 + 100), usual + 200);
  EXPECT_EQ(cycles("intersection_transform", 24 + 100), usual + 200);
  EXPECT_EQ(cycles("any_hit_fixed", 12 + 100), usual + 100);
}

// The intersection shader calls the any-hit shader itself: two boxes are two calls, one triangle that is hit is one.
// 39 core cycles are 100 of the DRAM's, so nothing is rounded.
TEST(BoxLeaves, TheAnyHitShaderOfABoxIsNoFurtherCall) {
  for (const auto& [kind, calls] : {std::pair{traces::AccelKind::box, 2U}, std::pair{traces::AccelKind::tri20, 1U}}) {
    const auto cycles = [kind = kind](const std::vector<std::string>& settings) {
      return statistic(stats_of(kind, settings), "gpu.cycles");
    };
    const std::uint64_t usual = cycles({});
    EXPECT_EQ(cycles({"simt.cost.call_fixed=78"}), usual + calls * 78U);
    EXPECT_EQ(cycles({"simt.cost.call_per_lane=39"}), usual + calls * 39U) << "one lane";
    EXPECT_EQ(cycles({"simt.cost.call_fixed=78", "simt.cost.call_per_lane=39"}), usual + calls * 117U);
  }
}

}  // namespace
}  // namespace grtx::sim
