// SPDX-License-Identifier: Apache-2.0
// Sampled mode: what the interval follows from, and runs of a view that is large enough.
#include "grtx/rtl_tlm/estimate/sampled_simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/lab/cost/energy_statistics.h"
#include "paths.h"
#include "rtl_tlm/traced_view.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

TEST(SampledEstimate, FollowsFromWhatTookTimeInEachSm) {
  // At a stride of 8 the first SM's misses come out at 80 of 100, the second's at 240 of 200; the third had none.
  const SampledWork work{{{100, 10}, {200, 30}, {0, 0}}, {{1000, 100}, {1000, 150}}, 0.5};
  const SampledEstimate estimate = estimate_from_stride(4000, 8, work);
  EXPECT_FALSE(estimate.whole);
  EXPECT_DOUBLE_EQ(estimate.log_cycles, std::log(4000.0));
  EXPECT_EQ(estimate.degrees_of_freedom, 2.0);
  ASSERT_EQ(estimate.evidence.size(), 4U);
  EXPECT_DOUBLE_EQ(estimate.evidence[0].residual, -0.2);
  EXPECT_DOUBLE_EQ(estimate.evidence[0].influence, -20.0 / 300);
  EXPECT_DOUBLE_EQ(estimate.evidence[1].influence, 40.0 / 300);
  // Instructions count as far as they decide how long the run is: half.
  EXPECT_DOUBLE_EQ(estimate.evidence[2].influence, 0.5 * -200.0 / 2000);
  EXPECT_DOUBLE_EQ(estimate.evidence[3].influence, 0.5 * 200.0 / 2000);
}

TEST(SampledEstimate, WithoutSubsamplesHasTheIntervalOfTheBias) {
  const SampledEstimate estimate = estimate_from_stride(1000, 8, {});
  const double reach = student_quantile(0.975, estimate.bias.degrees) * estimate.bias.cycles;
  EXPECT_NEAR(cycles_interval(estimate).high, 1000.0 * std::exp(reach), 1e-6);
}

TEST(SampledEstimate, LargerStridesAreWorthLess) {
  EXPECT_LE(stride_bias(4).cycles, stride_bias(8).cycles);
  EXPECT_LT(stride_bias(8).cycles, stride_bias(16).cycles);
  EXPECT_LT(stride_bias(16).ratio, stride_bias(64).ratio);
}

/// A generated view of more than 3 million visits.
class SampledSimulation : public ::testing::Test {
 protected:
  void SetUp() override { write_trace(1.0); }
  void write_trace(double fov_scale) {
    frontend::synthesise({"hall", 20000, 5, 1}, base_ + ".ply");
    const frontend::Scene scene = frontend::load_scene(base_ + ".ply");
    const frontend::Camera camera = frontend::load_cameras(base_ + ".cameras.json")[0].fov_scaled(fov_scale);
    test::write_view(trace(), scene, camera, 64, 48, frontend::AccelKind::tri20, false);
    ASSERT_GT(traces::Reader(trace()).totals().visits(), kFewestSampledVisits);
  }
  void TearDown() override {
    for (const char* end : {".ply", ".cameras.json", ".grtx"}) std::filesystem::remove(base_ + end);
  }
  std::string trace() const { return base_ + ".grtx"; }
  /// Document and violations of a run in a process of its own.
  ordered_json run(const std::vector<std::string>& settings, double target_error) const {
    ChildProcess child("simulation", [&] {
      SimulationOptions options;
      options.price = lab::describe_energy;
      const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/table1.toml", settings);
      const SampledResult r = simulate_sampled(trace(), config, options, target_error);
      EXPECT_LE(r.cycles.low, r.cycles.value);
      EXPECT_GE(r.cycles.high, r.cycles.value);
      return ordered_json{{"document", r.result.document}, {"violations", r.result.violations}}.dump();
    });
    const ordered_json answer = ordered_json::parse(child.result());
    EXPECT_EQ(answer.at("violations"), ordered_json::array());
    return answer.at("document");
  }
  static double value(const ordered_json& document, const std::string& name) {
    return document.at("stats").at(name).at("value").get<double>();
  }

 private:
  std::string base_ = ::testing::TempDir() + "/sampled_" + std::to_string(::getpid());
};

TEST_F(SampledSimulation, HasAnIntervalAndEnergyAndATargetBelowItIsCycleMode) {
  const ordered_json sampled = run({"gpu.sms=2"}, 0.0);
  EXPECT_EQ(sampled.at("inputs").at("mode"), "sampled");
  EXPECT_EQ(value(sampled, "gpu.sampled.stride"), 8.0);
  EXPECT_GT(value(sampled, "gpu.sampled.half_width"), 0.01);
  EXPECT_GT(value(sampled, "gpu.energy_nj"), 0.0);
  EXPECT_EQ(sampled.at("sampled").at("whole"), false);

  const ordered_json exact = run({"gpu.sms=2"}, 1e-6);
  EXPECT_EQ(value(exact, "gpu.sampled.stride"), 1.0);
  EXPECT_EQ(value(exact, "gpu.sampled.half_width"), 0.0);
  EXPECT_EQ(value(exact, "gpu.sampled.cycles_low"), value(exact, "gpu.cycles"));
  EXPECT_EQ(exact.at("inputs").at("mode"), "sampled");
  const double truth = value(exact, "gpu.cycles");
  EXPECT_LE(value(sampled, "gpu.sampled.cycles_low"), truth);
  EXPECT_GE(value(sampled, "gpu.sampled.cycles_high"), truth);
}

TEST_F(SampledSimulation, LanesThatMeetAtTheSameNodesAreNotSampled) {
  write_trace(0.01);  // all rays go the same way
  const ordered_json exact = run({"gpu.sms=2"}, 0.0);
  EXPECT_EQ(value(exact, "gpu.sampled.stride"), 1.0);
  EXPECT_EQ(value(exact, "gpu.sampled.half_width"), 0.0);
  EXPECT_EQ(exact.at("notes").at(0).at("id"), "merging");
  EXPECT_GT(value(exact, "gpu.rt.merge_factor"), 1.6);
}

TEST_F(SampledSimulation, RefusesATargetOutOfRange) {
  for (const double target : {-0.1, 1.0, std::nan("")}) {
    EXPECT_THROW(simulate_sampled(trace(), GpuConfig(), {}, target), Error) << target;
  }
}

}  // namespace
}  // namespace grtx::sim
