// SMs on threads of their own: the same statistics for any number of threads and any order of construction.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/traced_view.h"
#include "temporary_folder.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

class SmThreadsTest : public ::testing::Test {
 protected:
  void SetUp() override { frontend::synthesise({"flat", 1500, 11, 1}, base_ + ".ply"); }
  void trace(frontend::AccelKind kind, bool checkpoint) const {
    const frontend::Scene scene = frontend::load_scene(base_ + ".ply");
    const frontend::Camera camera = frontend::load_cameras(base_ + ".cameras.json")[0];
    test::write_view(base_ + ".grtx", scene, camera, 32, 24, kind, checkpoint);
  }
  /// Statistics without the host's, and what the run said.
  std::string run(unsigned sms, const BuildOptions& build, const std::vector<std::string>& settings = {},
                  Cycle watchdog = 2'000'000) const {
    ChildProcess child("simulation", [&] {
      GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", settings);
      config.sms = sms;
      SimulationOptions options;
      options.watchdog_cycles = watchdog;
      options.build = build;
      ::testing::internal::CaptureStderr();
      const SimulationResult result = test::simulate_priced(base_ + ".grtx", config, options);
      const std::string said = ::testing::internal::GetCapturedStderr();
      ordered_json stats = result.document.at("stats");
      for (auto it = stats.begin(); it != stats.end();) it = it.key().starts_with("host.") ? stats.erase(it) : ++it;
      return stats.dump() + said + (result.violations.empty() ? "" : "violations");
    });
    return child.result();
  }
  void expect_the_same(frontend::AccelKind kind, bool checkpoint) const {
    trace(kind, checkpoint);
    const std::string alone = run(8, {});
    ASSERT_THAT(alone, ::testing::HasSubstr("gpu.cycles"));
    for (const unsigned threads : {2U, 3U, 7U}) {
      // As written for two, shuffled for the others.
      EXPECT_EQ(run(8, shared(threads, threads - 2), {}, 20'000), alone) << threads << " threads";
    }
  }
  /// So many threads, whatever the host has. At every eighth long wait they are taken not to have their cores.
  static BuildOptions shared(unsigned threads, std::uint64_t construction_order = 0) {
    BuildOptions build;
    build.construction_order = construction_order;
    build.threads = threads;
    build.crowded = [asked = 0U]() mutable { return ++asked % 8 == 0; };
    return build;
  }
  const grtx::test::TemporaryFolder folder_;
  const std::string base_ = folder_.path("a");
};

TEST_F(SmThreadsTest, Baseline) { expect_the_same(frontend::AccelKind::tri20, false); }
TEST_F(SmThreadsTest, Software) { expect_the_same(frontend::AccelKind::tlas_sphere, false); }
TEST_F(SmThreadsTest, Hardware) { expect_the_same(frontend::AccelKind::tri20, true); }
TEST_F(SmThreadsTest, Grtx) { expect_the_same(frontend::AccelKind::tlas_sphere, true); }

// The watchdog looks while all threads stand still, which is when SMs move from thread to thread.
TEST_F(SmThreadsTest, SmsMoveFromThreadToThread) {
  trace(frontend::AccelKind::tlas_sphere, true);
  const std::string alone = run(8, {});
  for (const unsigned threads : {2U, 3U}) EXPECT_EQ(run(8, shared(threads), {}, 2'000), alone) << threads << " threads";
}

// In turns: a thread for each SM or two, then one for all, from wherever they are.
TEST_F(SmThreadsTest, AHostThatIsCrowdedNowAndThen) {
  trace(frontend::AccelKind::tlas_sphere, true);
  const std::string alone = run(8, {});
  for (const unsigned threads : {2U, 7U}) {
    BuildOptions build = shared(threads);
    build.crowded = [calm = false]() mutable { return calm = !calm; };
    EXPECT_EQ(run(8, build, {}, 500), alone) << threads << " threads";
  }
}

TEST_F(SmThreadsTest, MoreThreadsThanSms) {
  trace(frontend::AccelKind::tlas_sphere, true);
  EXPECT_EQ(run(2, shared(16)), run(2, {}));
}

TEST_F(SmThreadsTest, ARunThatCannotHaveThemSaysSo) {
  trace(frontend::AccelKind::tri20, false);
  BuildOptions build;
  build.run_ahead = false;
  build.threads = 3;
  EXPECT_THAT(run(4, build), ::testing::HasSubstr("one thread is used, not 3: the clocks follow the kernel"));
  build.run_ahead = true;
  EXPECT_THAT(run(1, build), ::testing::HasSubstr("one thread is used, not 3: there is one SM"));
  EXPECT_THAT(run(4, build, {"crossbar.link_capacity=1"}),
              ::testing::HasSubstr("one thread is used, not 3: crossbar.link_capacity is not above"));
  build.threads = 4096;
  EXPECT_THAT(run(4, build), ::testing::HasSubstr("of 4096 threads are used: the host has no more cores"));
}

}  // namespace
}  // namespace grtx::sim
