// SPDX-License-Identifier: Apache-2.0
// The ray-box and the ray-transform unit in SystemVerilog against the SystemC unit, each in an RT unit of its own on
// the same trace: every statistic, retirement, batch and memory request, to the cycle. The bridge holds each result
// against the host's arithmetic by itself (rtl_tlm/rtl/intersection_rtl.cpp); here that arithmetic is held against the
// tracer.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/tracer/node_intersection.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/rtl_tlm/rtl/intersection_operands.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "rtl_tlm/rt_unit/rt_bench.h"
#include "rtl_tlm/rtl/rtl_against_tlm.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using namespace test;

class IntersectionRtl : public modules::SystemCTest {
 protected:
  void SetUp() override {
    modules::SystemCTest::SetUp();
    if (!has_rtl()) GTEST_SKIP() << "no Verilator when this was built";
  }
};

// GRTX_RTL_CASES: how many (bench/rtl_random.sh).
unsigned cases() {
  const char* wanted = std::getenv("GRTX_RTL_CASES");
  return wanted != nullptr ? static_cast<unsigned>(std::stoul(wanted)) : 24;
}

TEST_F(IntersectionRtl, BoxesAgreeToTheCycleOnRandomTracesAndConfigurations) {
  modules::IntersectionUnit::Counters sum;
  for (unsigned seed = 0; seed < cases() && !HasFailure(); ++seed) {
    sum.add(expect_rtl_agrees(RtlUnit::box, seed).ray_box);
  }
  EXPECT_GT(sum.operations, 200 * cases());
  EXPECT_GT(sum.tests, sum.operations) << "children that are operations of their own";
  EXPECT_GT(sum.queue_cycles, 100 * cases());
  fmt::print("{} cases: {} operations, {} tests, {} lane cycles in the queue\n", cases(), sum.operations, sum.tests,
             sum.queue_cycles);
}

TEST_F(IntersectionRtl, TransformsAgreeToTheCycleOnRandomTracesAndConfigurations) {
  modules::IntersectionUnit::Counters sum;
  for (unsigned seed = 0; seed < cases() && !HasFailure(); ++seed) {
    sum.add(expect_rtl_agrees(RtlUnit::transform, seed).ray_transform);
  }
  EXPECT_GT(sum.operations, 50 * cases());
  EXPECT_GT(sum.queue_cycles, 10 * cases());
  fmt::print("{} cases: {} operations, {} lane cycles in the queue\n", cases(), sum.operations, sum.queue_cycles);
}

/// What a run with the faulty block says; empty: nothing.
std::string run_with_fault(RtlUnit unit, unsigned fault) {
  traces::testing::RandomOptions trace{
      .seed = 5, .groups = 2, .warp_size = 32, .bvh_width = 2, .depth = 3, .two_level = true};
  const auto made = traces::testing::random_trace(trace);
  BenchOptions options;
  options.rt.ray_box = options.rt.ray_transform = {1, 3, 1};
  RtlBenchOptions block{.faulty_block = true, .fault = fault};
  use_rtl(unit, options.parts, block);
  try {
    seen(made.header, made.groups, options);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST_F(IntersectionRtl, SeededFaultsOfTheBoxUnitAreCaughtWithTheirMessage) {
  EXPECT_EQ(run_with_fault(RtlUnit::box, 0), "") << "the block without its faults";
  EXPECT_THAT(
      run_with_fault(RtlUnit::box, 1),
      ::testing::ContainsRegex("rt.ray_box \\(RTL\\): warp [0-9]+ lane [0-9]+: test 0 of visit [0-9]+: child [01] "
                               "in order must be slot [01] from t = 0x[0-9a-f]+"));
  EXPECT_THAT(run_with_fault(RtlUnit::box, 2),
              ::testing::ContainsRegex("rt.ray_box \\(RTL\\): warp [0-9]+ lane [0-9]+: is lost: the queue holds [0-9]+ "
                                       "lanes of [0-9]+"));
  EXPECT_THAT(
      run_with_fault(RtlUnit::box, 3),
      ::testing::ContainsRegex("rt.ray_box \\(RTL\\): warp [0-9]+ lane [0-9]+: test 0 of visit [0-9]+: child [01] "
                               "in order must be slot 1 from t = 0x[0-9a-f]+.*, and is slot 2 from t = "));
}

TEST_F(IntersectionRtl, SeededFaultsOfTheTransformUnitAreCaughtWithTheirMessage) {
  EXPECT_EQ(run_with_fault(RtlUnit::transform, 0), "") << "the block without its faults";
  EXPECT_THAT(
      run_with_fault(RtlUnit::transform, 1),
      ::testing::ContainsRegex("rt.ray_transform \\(RTL\\): warp [0-9]+ lane [0-9]+: transform 0 of visit [0-9]+: "
                               "reciprocal [xyz] is 0x[0-9a-f]+ in place of 0x[0-9a-f]+"));
  EXPECT_THAT(run_with_fault(RtlUnit::transform, 2),
              ::testing::ContainsRegex("rt.ray_transform \\(RTL\\): warp [0-9]+ lane [0-9]+: is lost: the queue holds "
                                       "[0-9]+ lanes of [0-9]+"));
  EXPECT_THAT(
      run_with_fault(RtlUnit::transform, 3),
      ::testing::ContainsRegex("rt.ray_transform \\(RTL\\): warp [0-9]+ lane [0-9]+: transform 0 of visit [0-9]+: "
                               "origin [xyz] is 0x[0-9a-f]+ in place of 0x[0-9a-f]+"));
}

// The program prints an Error as one line and ends with exit code 2; all else is an internal error, 3.
TEST(IntersectionRtlRun, AFaultInARunOfTheWholeGpuIsAnErrorThatNamesTheUnit) {
  if (!has_rtl()) GTEST_SKIP() << "no Verilator when this was built";
  traces::testing::TemporaryFile file("faulty_rtl");
  traces::testing::RandomOptions random{.groups = 4, .warp_size = 32, .bvh_width = 2};
  const auto trace = traces::testing::random_trace(random);
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  ChildProcess child("simulation", [&]() -> std::string {
    // Tests before this one may have set the time resolution.
    sc_core::sc_curr_simcontext = sc_core::sc_default_global_context = new sc_core::sc_simcontext;
    SimulationOptions options;
    RtlBenchOptions block{.faulty_block = true, .fault = 3};
    use_rtl(RtlUnit::box, options.build.parts.sm.rt_parts, block);
    try {
      simulate(file.path(), load_config("", {"gpu.sms=2", "l2.slices=2", "rt.box.count=1", "rt.box.latency=3"}),
               options);
    } catch (const Error& error) {
      return error.what();
    } catch (const std::exception& error) {
      return std::string("internal error: ") + error.what();
    }
    return "";
  });
  EXPECT_THAT(child.result(),
              ::testing::ContainsRegex("^gpu.sm[01].rt.ray_box \\(RTL\\): warp [0-9]+ lane [0-9]+: test 0"));
}

TEST_F(IntersectionRtl, RefusesWhatItDoesNotHave) {
  const auto refusal = [](void (*change)(modules::RtUnitConfig&)) {
    modules::RtUnitConfig rt;
    rt.box_implementation = rt.transform_implementation = modules::UnitImplementation::rtl;
    change(rt);
    return std::string(rtl_refusal(rt).key);
  };
  EXPECT_EQ(refusal([](auto&) {}), "");
  EXPECT_EQ(refusal([](auto& rt) { rt.ray_box.count = 9; }), "box.count");
  EXPECT_EQ(refusal([](auto& rt) { rt.ray_box.latency = 65; }), "box.latency");
  EXPECT_EQ(refusal([](auto& rt) { rt.ray_box.interval = 128; }), "box.interval");
  EXPECT_EQ(refusal([](auto& rt) { rt.warp_buffer.entries = 33; }), "warp_buffer.entries");
  EXPECT_EQ(refusal([](auto& rt) { rt.ray_transform.count = 9; }), "transform.count");
  EXPECT_EQ(refusal([](auto& rt) { rt.ray_transform.latency = 65; }), "transform.latency");
  EXPECT_EQ(refusal([](auto& rt) { rt.ray_transform.interval = 128; }), "transform.interval");
}

TEST_F(IntersectionRtl, RefusesTracesWhoseBoxesItCannotRead) {
  traces::Header header = small_header();
  for (const auto layout : {traces::NodeLayout::compact, traces::NodeLayout::compressed}) {
    header.layout = layout;
    BenchOptions options;
    use_rtl(RtlUnit::box, options.parts, {});
    EXPECT_THAT([&] { RtBench bench(header, options); },
                ::testing::ThrowsMessage<Error>(::testing::HasSubstr("needs rt.box.implementation = tlm")));
  }
}

// A node's codes become fp32 boxes as the tracer decodes them; then the tracer's own test of the node and the
// arithmetic of the bridge must find the same children, entered at the same t, in the same order.
TEST(IntersectionOperands, TheTestOfANodeIsTheTracersBitForBit) {
  std::mt19937 random(11);
  const auto uniform = [&](float from, float to) { return std::uniform_real_distribution<float>(from, to)(random); };
  const frontend::InternalLayout layout = frontend::internal_layout(6);
  const frontend::NodeTest test = frontend::node_test(frontend::SimdPath::portable, layout);
  unsigned hits = 0, several = 0;
  for (unsigned i = 0; i < 20000; ++i) {
    alignas(32) std::uint8_t node[128] = {};
    const bool grid = i % 3 == 0;  // few values: boxes touch
    float origin[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
      origin[axis] = grid ? static_cast<float>(random() % 5) - 2.0f : uniform(-2.0f, 2.0f);
      node[18 + axis] = static_cast<std::uint8_t>(static_cast<int>(random() % 4) - 1);
    }
    std::memcpy(node, origin, sizeof origin);
    for (unsigned slot = 0; slot < 6; ++slot) {
      node[layout.child_info + slot] = random() % 5 == 0 ? 0 : 1;
      for (unsigned axis = 0; axis < 3; ++axis) {
        unsigned a = random() % 256, b = random() % 256;
        if (grid) a &= 0xc0, b &= 0xc0;
        node[layout.bounds + 2 * axis * 6 + slot] = static_cast<std::uint8_t>(std::min(a, b));
        node[layout.bounds + (2 * axis + 1) * 6 + slot] = static_cast<std::uint8_t>(std::max(a, b));
      }
    }
    glm::vec3 from, direction;
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = grid ? static_cast<float>(random() % 5) - 2.0f : uniform(-3.0f, 3.0f);
      direction[axis] = random() % 8 == 0 ? (random() % 2 == 0 ? 0.0f : -0.0f) : uniform(-1.0f, 1.0f);
      if (grid) direction[axis] = static_cast<float>(random() % 3) - 1.0f;
    }
    if (!grid && i % 8 != 1) {  // at a corner of a box
      const auto slot = static_cast<unsigned>(random() % 6);
      for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned code = node[layout.bounds + (2 * axis + (i + axis) % 2) * 6 + slot];
        const float at =
            origin[axis] + std::ldexp(static_cast<float>(code), static_cast<std::int8_t>(node[18 + axis]) - 8);
        direction[static_cast<int>(axis)] = (at - from[static_cast<int>(axis)]) * 0.5f;
      }
    }
    const frontend::SlabRay ray(from, direction);
    const frontend::NodeQuery query{random() % 2 == 0 ? 0.0f : uniform(-1.0f, 1.0f), random() % 2 == 0 ? 0.0f : 1.0f};
    frontend::NodeHits expected;
    test(node, 0, ray, query, expected);

    BoxOperands operands{};
    for (unsigned axis = 0; axis < 3; ++axis) {
      operands.origin[axis] = from[static_cast<int>(axis)];
      operands.inverse[axis] = reciprocal_for_slabs(direction[static_cast<int>(axis)]);
      const float step = std::ldexp(1.0f, static_cast<std::int8_t>(node[18 + axis]) - 8);
      for (unsigned slot = 0; slot < 6; ++slot) {
        const auto code = [&](unsigned upper) {
          return static_cast<float>(node[layout.bounds + (2 * axis + upper) * 6 + slot]);
        };
        operands.lower[slot][axis] = origin[axis] + code(0) * step;
        operands.upper[slot][axis] = origin[axis] + code(1) * step;
      }
    }
    operands.t_offset = query.t_offset;
    operands.t_min = query.t_min;
    operands.t_max = 1.5f;
    operands.used = expected.info.valid;
    const BoxOutcome outcome = box_outcome(operands);
    ASSERT_EQ(outcome.hits, expected.count) << i;
    hits += outcome.hits;
    several += outcome.hits > 1 ? 1 : 0;
    for (unsigned place = 0; place < outcome.hits; ++place) {
      const BoxChild& child = outcome.order[place];
      ASSERT_TRUE(expected.hit >> child.slot & 1) << i;
      ASSERT_EQ(child.t, std::bit_cast<std::uint32_t>(expected.enter[child.slot])) << i;
      ASSERT_EQ(static_cast<int>(place), expected.rank[child.slot]) << i;
      ASSERT_EQ(child.beyond, expected.enter[child.slot] > 1.5f) << i;
    }
  }
  EXPECT_GT(hits, 10000u);
  EXPECT_GT(several, 2000u);
}

// The rows of a Gaussian's matrix with the ray that the tracer has rebased, and the reciprocals of its slab tests.
TEST(IntersectionOperands, TheTransformIsTheTracersBitForBit) {
  std::mt19937 random(12);
  const auto uniform = [&](float from, float to) { return std::uniform_real_distribution<float>(from, to)(random); };
  for (unsigned i = 0; i < 20000; ++i) {
    frontend::GaussianRecord g;
    TransformOperands operands{};
    glm::vec3 direction, origin;
    for (int axis = 0; axis < 3; ++axis) {
      direction[axis] = random() % 16 == 0 ? 0.0f : uniform(-1.0f, 1.0f);
      origin[axis] = uniform(-4.0f, 4.0f);
      g.mean[axis] = uniform(-4.0f, 4.0f);
      for (int c = 0; c < 3; ++c) g.to_unit[axis][c] = random() % 16 == 0 ? 0.0f : uniform(-9.0f, 9.0f);
    }
    const frontend::TraceRay ray(origin, direction);
    const frontend::UnitRay unit = frontend::to_unit_ray(ray, g);
    if (!(unit.length2 > 1e-30f && unit.length2 < 1e30f && unit.d2 < 1e30f)) continue;  // in double
    for (unsigned r = 0; r < 3; ++r) {
      const int row = static_cast<int>(r);
      for (unsigned c = 0; c < 3; ++c) operands.rows[r][c] = g.to_unit[row][static_cast<int>(c)];
      operands.translation[r] = -0.0f;  // adds nothing, whatever the sign of a zero
      operands.origin[r] = unit.peak[row];
      operands.direction[r] = direction[row];
    }
    const TransformOutcome outcome = transform_outcome(operands);
    const frontend::SlabRay slabs(unit.peak, unit.direction);
    for (unsigned r = 0; r < 3; ++r) {
      const int row = static_cast<int>(r);
      ASSERT_EQ(std::bit_cast<std::uint32_t>(outcome.direction[r]), std::bit_cast<std::uint32_t>(unit.direction[row]));
      ASSERT_EQ(std::bit_cast<std::uint32_t>(outcome.inverse[r]), std::bit_cast<std::uint32_t>(slabs.inverse[row]));
      const float matrix[3] = {g.to_unit[row].x, g.to_unit[row].y, g.to_unit[row].z};
      const float point[3] = {unit.peak.x, unit.peak.y, unit.peak.z};
      const float through = frontend::detail::dot3(matrix, point);
      ASSERT_EQ(std::bit_cast<std::uint32_t>(outcome.origin[r]), std::bit_cast<std::uint32_t>(through));
    }
  }
}

// A run in which every third test meets numbers that are none, infinite or subnormal is only worth something if they
// reach what the blocks decide.
TEST(IntersectionOperands, AreOfEveryKindAndHitOften) {
  unsigned hits = 0, tied = 0, beyond = 0, none = 0, infinite = 0, subnormal = 0;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    const BoxOperands operands = made_box_operands(seed, 6);
    const BoxOutcome outcome = box_outcome(operands);
    hits += outcome.hits;
    for (unsigned place = 0; place < outcome.hits; ++place) {
      beyond += outcome.order[place].beyond ? 1 : 0;
      if (place > 0) tied += outcome.order[place].t == outcome.order[place - 1].t ? 1 : 0;
    }
    const TransformOutcome transformed = transform_outcome(made_transform_operands(seed));
    for (unsigned axis = 0; axis < 3; ++axis) {
      for (const float x : {transformed.origin[axis], transformed.direction[axis], operands.lower[0][axis]}) {
        none += std::isnan(x) ? 1 : 0;
        infinite += std::isinf(x) ? 1 : 0;
        subnormal += x != 0.0f && std::fpclassify(x) == FP_SUBNORMAL ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hits, 8000u);
  EXPECT_GT(tied, 500u);
  EXPECT_GT(beyond, 500u);
  EXPECT_GT(none, 1000u);
  EXPECT_GT(infinite, 1000u);
  EXPECT_GT(subnormal, 500u);
}

}  // namespace
}  // namespace grtx::sim
