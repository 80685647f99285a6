// SPDX-License-Identifier: Apache-2.0
// GpuConfig::sampling: one event in so many takes time, the others are done at once by the same units.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/modules/rt_unit/node_fetch_if.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/traced_view.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using ::testing::HasSubstr;

/// A generated view: grtx and baseline.
class Stride : public ::testing::Test {
 protected:
  void SetUp() override {
    frontend::synthesise({"hall", 3000, 5, 1}, base_ + ".ply");
    const frontend::Scene scene = frontend::load_scene(base_ + ".ply");
    const frontend::Camera camera = frontend::load_cameras(base_ + ".cameras.json")[0];
    test::write_view(grtx(), scene, camera, 32, 32, frontend::AccelKind::tlas_tri20, true);
    test::write_view(baseline(), scene, camera, 32, 32, frontend::AccelKind::tri20, false);
  }
  void TearDown() override {
    for (const char* end : {".ply", ".cameras.json", "_grtx.grtx", "_baseline.grtx"})
      std::filesystem::remove(base_ + end);
  }
  std::string grtx() const { return base_ + "_grtx.grtx"; }
  std::string baseline() const { return base_ + "_baseline.grtx"; }

 private:
  std::string base_ = ::testing::TempDir() + "/stride_" + std::to_string(::getpid());
};

/// Table I, every byte charged.
GpuConfig machine(const std::vector<std::string>& settings, unsigned stride = 1, unsigned offset = 0) {
  GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/table1.toml", settings);
  config.sampling = {stride, offset};
  return config;
}

/// Statistics and notes of a run that breaks no law.
ordered_json run(const std::string& trace, const GpuConfig& config) {
  ChildProcess child("simulation", [&] {
    const SimulationResult result = test::simulate_priced(trace, config);
    return ordered_json{{"stats", result.document.at("stats")},
                        {"notes", result.document.at("notes")},
                        {"violations", result.violations}}
        .dump();
  });
  const ordered_json answer = ordered_json::parse(child.result());
  EXPECT_EQ(answer.at("violations"), ordered_json::array());
  return answer;
}

double value(const ordered_json& answer, const std::string& name) {
  return answer.at("stats").at(name).at("value").get<double>();
}

// The laws of conservation hold in each: every event is executed once, with time or without.
TEST_F(Stride, EventsAreExactAndCyclesAreNear) {
  for (const std::string& trace : {grtx(), baseline()}) {
    for (const std::vector<std::string>& keys :
         {std::vector<std::string>{"gpu.sms=1", "gpu.resident_warps=8"},
          {"gpu.sms=1", "gpu.resident_warps=8", "l1.private_writes=write_back", "l1.private_allocate=true",
           "rt.memory.sectors_per_cycle=4", "rt.transform.count=1", "rt.transform.interval=7"}}) {
      const ordered_json all = run(trace, machine(keys));
      for (const unsigned stride : {2u, 8u}) {
        const std::string what = trace + " with " + keys.back() + ", stride " + std::to_string(stride);
        const ordered_json some = run(trace, machine(keys, stride));
        for (const char* exact : {"gpu.rt.node_visits", "gpu.rt.culls", "gpu.rt.any_hit_calls", "gpu.rt.calls",
                                  "gpu.rt.checkpoint.entries_written", "gpu.simt.blended", "gpu.simt.warps"}) {
          if (!all.at("stats").contains(exact)) continue;
          EXPECT_EQ(value(some, exact), value(all, exact)) << what << exact;
        }
        // A small view of few rays: this finds what is wrong, not what errs.
        for (const auto& [near, least, most] :
             {std::tuple("gpu.cycles", 0.8, 1.2), std::tuple("gpu.l1.accesses", 0.9, 1.1),
              std::tuple("gpu.energy_nj", 0.8, 1.2)}) {
          const double ratio = value(some, near) / value(all, near);
          EXPECT_TRUE(ratio > least && ratio < most) << what << ": " << near << " x " << ratio;
        }
        EXPECT_THAT(some.at("notes").dump(), HasSubstr("one in " + std::to_string(stride) + " took time"));
      }
      EXPECT_THAT(all.at("notes").dump(), ::testing::Not(HasSubstr("took time")));
    }
  }
}

TEST_F(Stride, TheSameOffsetGivesTheSameStatisticsAndAnotherOneOthers) {
  const auto stats = [&](unsigned offset) {
    const ordered_json list = run(grtx(), machine({}, 8, offset));
    ordered_json of_the_model = ordered_json::object();
    for (const auto& [name, entry] : list.at("stats").items()) {
      if (!name.starts_with("host.")) of_the_model[name] = entry;
    }
    return of_the_model;
  };
  EXPECT_EQ(stats(3), stats(3));
  EXPECT_NE(stats(3), stats(4));
}

TEST_F(Stride, TakesEveryKeyThatCycleModeTakes) {
  for (const std::vector<std::string>& keys :
       {std::vector<std::string>{"rt.memory.by_shader=true"},
        {"gpu.rt_units=2"},
        {"dram.scheduling=fcfs"},
        {"rt.warp_buffer.spill=true", "rt.warp_buffer.stack_entries=8"},
        {"l1.perfect=true"},
        {"l2.perfect=true"},
        {"l1.line_bytes=256"},
        {"l1.line_bytes=32"},
        {"l2.interleave_bytes=128", "l1.line_bytes=256"},
        {"rt.memory.merge_in_flight=false"},
        {"rt.any_hit_unit.enabled=true"},
        {"l1.private_writes=write_back", "l1.private_allocate=true", "l1.write_back_buffer=1"}}) {
    std::vector<std::string> settings = keys;
    settings.push_back("gpu.sms=2");
    SCOPED_TRACE(keys.front());
    EXPECT_GT(value(run(grtx(), machine(settings, 4)), "gpu.cycles"), 0.0);
  }
}

/// Never runs: it has no functional entry.
class TimedOnly final : public modules::NodeFetchModule {
 public:
  TimedOnly(const sc_core::sc_module_name& name, const modules::NodeTraffic& traffic)
      : NodeFetchModule(name), traffic_(traffic) {}
  const modules::NodeTraffic& traffic() const override { return traffic_; }
  bool has_room() const override { return true; }
  void begin_warp(Cycle, unsigned) override {}
  void visit(modules::LaneId, traces::NodeKind, std::uint64_t, bool) override {}
  void respond(Cycle) override {}
  void issue(Cycle) override {}
  bool busy() const override { return false; }
  bool idle() const override { return true; }
  std::uint64_t progress() const override { return 0; }
  modules::MemorySchedulerCounters counters() const override { return {}; }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream&) const override {}

 private:
  const modules::NodeTraffic& traffic_;
};

TEST_F(Stride, APartWithoutAFunctionalEntryIsRefusedByName) {
  ChildProcess child("simulation", [&] {
    SimulationOptions options;
    options.build.parts.sm.rt_parts.memory_scheduler = [](const char* name, const modules::RtUnitContext& rt) {
      return std::make_unique<TimedOnly>(name, rt.traffic);
    };
    try {
      (void)simulate(grtx(), machine({}, 4), options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("was not refused");
  });
  EXPECT_THAT(child.result(),
              HasSubstr("gpu.sm0.rt.memory_scheduler: has no functional entry, which a sampled run needs"));
}

TEST_F(Stride, AnOffsetIsBelowTheStride) {
  EXPECT_THAT(
      [] {
        (void)load_config("", {"sample.stride=4", "sample.offset=4"});
      },
      ::testing::ThrowsMessage<Error>(HasSubstr("sample.offset: must be below the stride")));
}

}  // namespace
}  // namespace grtx::sim
