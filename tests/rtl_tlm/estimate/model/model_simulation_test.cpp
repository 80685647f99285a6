// Model mode: fast mode's own cycles where it has run, between them near them, and nothing run twice.
#include "grtx/rtl_tlm/estimate/model/model_simulation.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/estimate/model/anchors.h"
#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using test::statistic;

class ModelMode : public ::testing::Test {
 protected:
  nlohmann::ordered_json run(const std::vector<std::string>& settings, SimulationMode mode) const {
    std::vector<std::string> all = {"l1.bytes=32768", "l2.bytes=1048576"};
    all.insert(all.end(), settings.begin(), settings.end());
    if (mode == SimulationMode::fast) return run_.run({}, all, mode);
    SimulationOptions options;
    options.price = describe_energy;
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", all);
    return simulate_model(run_.path("t.grtx"), config, options).document.at("stats");
  }
  std::uint64_t model(const std::vector<std::string>& settings) const {
    return statistic(run(settings, SimulationMode::model), "gpu.cycles");
  }
  std::uint64_t fast(const std::vector<std::string>& settings) const {
    return statistic(run(settings, SimulationMode::fast), "gpu.cycles");
  }
  std::vector<std::string> anchor_files() const {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(run_.path("")))) {
      if (entry.path().string().find(".anchors-") != std::string::npos) files.push_back(entry.path().string());
    }
    return files;
  }
  test::ObservedRun run_;
};

TEST_F(ModelMode, GivesFastModesCyclesWhereFastModeHasRun) {
  for (const char* entries : {"rt.warp_buffer.entries=1", "rt.warp_buffer.entries=4"}) {
    const auto estimate = run({entries}, SimulationMode::model);
    const auto truth = run({entries}, SimulationMode::fast);
    EXPECT_EQ(statistic(estimate, "gpu.cycles"), statistic(truth, "gpu.cycles")) << entries;
    EXPECT_EQ(statistic(estimate, "gpu.rt.node_visits"), statistic(truth, "gpu.rt.node_visits")) << entries;
    for (const StatisticOfModel& s : statistics_of_model()) {
      EXPECT_EQ(estimate.at(s.name).at("value").get<double>(), truth.at(s.name).at("value").get<double>()) << s.name;
    }
  }
}

TEST_F(ModelMode, LiesNearFastModeBetweenThem) {
  for (const char* entries : {"rt.warp_buffer.entries=2", "rt.warp_buffer.entries=3"}) {
    for (const char* l1 : {"l1.bytes=32768", "l1.bytes=65536"}) {
      EXPECT_NEAR(static_cast<double>(model({entries, l1})) / static_cast<double>(fast({entries, l1})), 1.0, 0.15)
          << entries << " " << l1;
    }
  }
}

TEST_F(ModelMode, TakesTheRunsThatAreKept) {
  const std::uint64_t first = model({"rt.warp_buffer.entries=1"});
  const std::vector<std::string> files = anchor_files();
  ASSERT_EQ(files.size(), 1U);
  auto kept = nlohmann::ordered_json::parse(read_file(files[0]));
  kept["anchors"][0]["cycles"] = 2.0 * static_cast<double>(first);
  write_file(files[0], kept.dump());
  EXPECT_EQ(model({"rt.warp_buffer.entries=1"}), 2 * first) << "read, not run";
  kept["program"] = "grtx 0.0.0";
  write_file(files[0], kept.dump());
  EXPECT_EQ(model({"rt.warp_buffer.entries=1"}), first) << "of another program: run again";
  write_file(files[0], "{\"schema\": 1");
  EXPECT_EQ(model({"rt.warp_buffer.entries=1"}), first) << "damaged: run again";
}

TEST_F(ModelMode, MeasuresWhatItDoesNotModel) {
  model({});
  EXPECT_EQ(anchor_files().size(), 1U);
  model({"rt.checkpoint.lanes=2"});
  EXPECT_EQ(anchor_files().size(), 1U) << "without effect in the model";
  model({"l1.latency=60"});
  EXPECT_EQ(anchor_files().size(), 2U);
  EXPECT_EQ(model({"rt.warp_buffer.entries=1", "l1.latency=60"}), fast({"rt.warp_buffer.entries=1", "l1.latency=60"}));
}

TEST_F(ModelMode, RefusesWhatFastModeRefuses) {
  EXPECT_THROW(model({"gpu.rt_units=2"}), Error);
  EXPECT_EQ(unmodelled(load_config("", {"gpu.rt_units=2"}), SimulationMode::model).key, "gpu.rt_units");
  using Names = std::vector<std::string_view>;
  EXPECT_EQ(ignored_keys(load_config("", {"rt.checkpoint.lanes=2", "l1.mshr_merges=4", "fast.stride=2"}),
                         {SimulationMode::model}),
            (Names{"l1.mshr_merges", "rt.checkpoint.lanes"}));
}

}  // namespace
}  // namespace grtx::sim
