// SPDX-License-Identifier: Apache-2.0
// Whole runs of small traces: conservation, determinism, independence of how the model is built and stepped.
#include "grtx/rtl_tlm/run/simulation.h"

#include <gtest/gtest.h>

#include <set>

#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "paths.h"
#include "rtl_tlm/silent_dram.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using traces::testing::RandomOptions;
using traces::testing::TemporaryFile;

/// The statistics file of a run in a process of its own, with its violations.
ordered_json simulated(const std::string& path, const GpuConfig& config, const SimulationOptions& options = {}) {
  ChildProcess child("simulation", [&] {
    const SimulationResult result = test::simulate_priced(path, config, options);
    ordered_json document = result.document;
    document["violations"] = result.violations;
    document["binding_bound"] = result.binding_bound;
    return document.dump();
  });
  return ordered_json::parse(child.result());
}

ordered_json without_host(ordered_json document) {
  for (auto it = document["stats"].begin(); it != document["stats"].end();) {
    it = it.key().starts_with("host.") ? document["stats"].erase(it) : std::next(it);
  }
  return document;
}

GpuConfig small() { return load_config(grtx::paths::source_dir() + "/configs/small.toml", {}); }

std::uint64_t value(const ordered_json& document, const std::string& name) {
  return document.at("stats").at(name).at("value").get<std::uint64_t>();
}

RandomOptions random_options(bool two_level, bool checkpoint) {
  RandomOptions options;
  options.seed = 7;
  options.groups = 24;
  options.warp_size = 32;
  options.two_level = two_level;
  options.checkpoint = checkpoint;
  options.capacity = checkpoint ? 200 : 0;
  return options;
}

void write_random(const std::string& path, const RandomOptions& options) {
  const auto trace = traces::testing::random_trace(options);
  traces::testing::write_trace(path, trace.header, trace.groups);
}

TEST(Simulation, TinyTraceExecutesEveryEventOnce) {
  const TemporaryFile file("tiny");
  test::write_tiny_trace(file.path(), {4, 32});
  const ordered_json result = simulated(file.path(), small());
  EXPECT_EQ(result["violations"], ordered_json::array());
  EXPECT_EQ(value(result, "gpu.rt.node_visits"), 4U * 32 * 3);
  // All lanes of a warp visit the same three nodes in step: one fetch a node and warp, two 32 B sectors each.
  EXPECT_EQ(value(result, "gpu.rt.node_fetches"), 4U * 3);
  EXPECT_EQ(value(result, "gpu.rt.node_sectors"), 4U * 3 * 2);
  EXPECT_EQ(value(result, "gpu.rt.any_hit.batches"), 4U * 2);
  EXPECT_EQ(value(result, "gpu.simt.blended"), 4U * 32 * 2);
  // Three nodes of 64 B and their records miss once: no node sector is read twice from DRAM.
  EXPECT_EQ(value(result, "gpu.l2.node.misses"), 3U * 2);
}

TEST(Simulation, SameInputsGiveTheSameStatistics) {
  const TemporaryFile file("same");
  write_random(file.path(), random_options(true, true));
  EXPECT_EQ(without_host(simulated(file.path(), small())).dump(), without_host(simulated(file.path(), small())).dump());
}

TEST(Simulation, HostStatisticsComeLast) {
  const TemporaryFile file("host");
  test::write_tiny_trace(file.path());
  const ordered_json result = simulated(file.path(), small());
  bool host = false;
  for (const auto& [name, entry] : result["stats"].items()) {
    EXPECT_TRUE(!host || name.starts_with("host.")) << name << " stands behind a host statistic";
    host = host || name.starts_with("host.");
    EXPECT_FALSE(entry.at("unit").get<std::string>().empty()) << name;
    EXPECT_FALSE(entry.at("description").get<std::string>().empty()) << name;
  }
  EXPECT_TRUE(host);
}

TEST(Simulation, HasTheStatisticsThatScriptsRelyOn) {
  const TemporaryFile file("names");
  test::write_tiny_trace(file.path());
  const ordered_json stats = simulated(file.path(), small())["stats"];
  for (const char* name : {"gpu.cycles",
                           "gpu.time_us",
                           "gpu.rt.node_visits",
                           "gpu.rt.node_fetches",
                           "gpu.rt.node_fetch_latency",
                           "gpu.l1.node.hit_rate",
                           "gpu.l1.accesses",
                           "gpu.l2.accesses",
                           "gpu.l2.hit_rate",
                           "gpu.dram.bytes",
                           "gpu.rt.any_hit.batches",
                           "gpu.rt.simt_efficiency",
                           "gpu.rt.occupancy",
                           "gpu.rt.stall.memory",
                           "gpu.bound.issue",
                           "gpu.bound.unit.box",
                           "gpu.bound.unit.triangle",
                           "gpu.bound.l1_port",
                           "gpu.bound.dram_bandwidth",
                           "gpu.bound.rt_port",
                           "gpu.bound.longest_ray",
                           "host.wall_seconds",
                           "host.peak_rss_bytes",
                           "host.cycles_per_second",
                           "host.sm_cycles_per_second",
                           "host.slowdown",
                           "host.node_visits_per_second"}) {
    EXPECT_TRUE(stats.contains(name)) << name;
  }
}

struct Kind {
  const char* name;
  bool two_level;
  bool checkpoint;
  unsigned objects = 0;
  friend void PrintTo(const Kind& c, std::ostream* out) { *out << c.name; }
};

class SimulationKinds : public ::testing::TestWithParam<Kind> {};

TEST_P(SimulationKinds, ConservesAndDoesNotDependOnConstructionOrderOrIdleSkip) {
  const TemporaryFile file(GetParam().name);
  RandomOptions random = random_options(GetParam().two_level, GetParam().checkpoint);
  if (GetParam().objects != 0) random.depth = 2;
  random.objects = GetParam().objects;
  write_random(file.path(), random);
  const ordered_json reference = without_host(simulated(file.path(), small()));
  EXPECT_EQ(reference["violations"], ordered_json::array());
  for (const std::uint64_t order : {1U, 2U, 3U}) {
    SimulationOptions options;
    options.build.construction_order = order;
    options.build.idle_skip = order != 3;
    options.build.run_ahead = order != 2;
    EXPECT_EQ(without_host(simulated(file.path(), small(), options)).dump(), reference.dump()) << "order " << order;
  }
}

// The parts that only alternatives build.
TEST(Simulation, AlternativesDoNotDependOnConstructionOrderOrIdleSkip) {
  const TemporaryFile file("alternatives");
  write_random(file.path(), random_options(true, true));
  const GpuConfig config = load_config(
      grtx::paths::source_dir() + "/configs/small.toml",
      {"gpu.rt_units=2", "rt.memory.by_shader=true", "rt.warp_buffer.spill=true", "rt.warp_buffer.stack_entries=2"});
  const ordered_json reference = without_host(simulated(file.path(), config));
  EXPECT_EQ(reference["violations"], ordered_json::array());
  EXPECT_GT(value(reference, "gpu.rt.stack.spills"), 0U);
  for (const std::uint64_t order : {1U, 2U, 3U}) {
    SimulationOptions options;
    options.build.construction_order = order;
    options.build.idle_skip = order != 3;
    EXPECT_EQ(without_host(simulated(file.path(), config, options)).dump(), reference.dump()) << "order " << order;
  }
}

// The points of the series are the run cut into pieces: their weighted mean is the mean of the run.
TEST(Simulation, OccupancyOverTimeAddsUpToTheRun) {
  const TemporaryFile file("series");
  write_random(file.path(), random_options(true, true));
  const ordered_json result = simulated(file.path(), small());
  const ordered_json& series = result.at("over_time");
  const auto& ends = series.at("end_of_interval").at("values");
  ASSERT_GE(ends.size(), 2U);
  EXPECT_LE(ends.size(), 65U);
  EXPECT_EQ(ends.back(), value(result, "gpu.cycles"));
  double warps = 0.0, selections = 0.0;
  std::uint64_t before = 0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const auto end = ends[i].get<std::uint64_t>();
    ASSERT_GT(end, before);
    const double length = static_cast<double>(end - before);
    warps += series.at("rt.occupancy").at("values").at(i).get<double>() * length;
    selections += series.at("rt.selections").at("values").at(i).get<double>() * length;
    before = end;
  }
  const double units = 2.0;  // small.toml: 2 SMs
  EXPECT_NEAR(warps * units, static_cast<double>(value(result, "gpu.rt.occupancy_integral")), 1e-3);
  EXPECT_NEAR(selections * units, static_cast<double>(value(result, "gpu.rt.selections")), 1e-3);
  EXPECT_EQ(series.at("resident_warps").at("values").back(), 0U);
}

INSTANTIATE_TEST_SUITE_P(All, SimulationKinds,
                         ::testing::Values(Kind{"baseline", false, false}, Kind{"sw", true, false},
                                           Kind{"hw", false, true}, Kind{"grtx", true, true},
                                           Kind{"sw_objects", true, false, 3}, Kind{"grtx_objects", true, true, 3}),
                         [](const auto& test_case) { return std::string(test_case.param.name); });

TEST(Simulation, ASubsetOfGroupsRunsOnlyThese) {
  const TemporaryFile file("subset");
  test::write_tiny_trace(file.path(), {6, 32});
  SimulationOptions options;
  options.groups = {1, 4};
  const ordered_json result = simulated(file.path(), small(), options);
  EXPECT_EQ(result["violations"], ordered_json::array());
  EXPECT_EQ(value(result, "gpu.rt.node_visits"), 2U * 32 * 3);
}

TEST(Simulation, ADamagedTraceIsBadInput) {
  const TemporaryFile file("damaged");
  test::write_tiny_trace(file.path());
  std::string bytes = read_file(file.path());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x40);
  write_file(file.path(), bytes);
  EXPECT_THROW(simulated(file.path(), small()), Error);
}

TEST(Simulation, APolicyOfTheDramIsToldWhoAsksAndForWhat) {
  /// Writes down who asks for what.
  class Listening final : public modules::FrFcfs {
   public:
    explicit Listening(std::set<std::string>& heard) : FrFcfs(1024), heard_(heard) {}
    modules::DramChoice choose(Cycle now, const modules::DramQueues& queues) override {
      const modules::DramChoice choice = FrFcfs::choose(now, queues);
      if (choice.column == modules::DramQueues::kNone) return choice;
      const modules::QueuedRequest& request = queues.hit[choice.column];
      heard_.insert(std::string(request.write ? "write " : "read ") + std::string(name_of(request.origin.region)) +
                    " of " + std::to_string(request.origin.sm));
      return choice;
    }

   private:
    std::set<std::string>& heard_;
  };
  const TemporaryFile file("origin");
  const RandomOptions random{.seed = 3, .groups = 96, .warp_size = 32, .depth = 6, .checkpoint = true};
  auto made = traces::testing::random_trace(random);
  traces::testing::write_trace(file.path(), made.header, made.groups);
  ChildProcess child("simulation", [&] {
    std::set<std::string> heard;
    modules::register_dram_scheduling(
        "listening", [&](const modules::DramChannelConfig&) { return std::make_unique<Listening>(heard); });
    test::simulate_priced(file.path(), load_config("", {"dram.scheduling=listening", "gpu.sms=2"}), {});
    std::string all;
    for (const std::string& one : heard) all += one + "\n";
    return all;
  });
  const std::string heard = child.result();
  for (const char* one : {"read leaf of 0", "read leaf of 1", "read gaussian of 0", "read gaussian of 1"}) {
    EXPECT_NE(heard.find(one), std::string::npos) << one << heard;
  }
  EXPECT_EQ(heard.find("read tlas of 255"), std::string::npos) << heard;
}

TEST(Simulation, NoProgressIsReportedAsADeadlock) {
  const TemporaryFile file("slow");
  test::write_tiny_trace(file.path());
  SimulationOptions options;
  options.watchdog_cycles = 100'000;
  ChildProcess child("simulation", [&] {
    ::testing::internal::CaptureStderr();
    try {
      test::make_a_silent_dram();
      test::simulate_priced(file.path(), load_config("", {"dram.scheduling=silent"}), options);
    } catch (const std::runtime_error& error) {
      return std::string(error.what()) + "\n" + ::testing::internal::GetCapturedStderr();
    }
    return std::string("no error");
  });
  const std::string text = child.result();
  EXPECT_NE(text.find("deadlock in core cycle"), std::string::npos) << text;
  for (const char* part :
       {"gpu.distributor", "gpu.sm0.simt", "load-store unit", "gpu.sm0.rt.warp_buffer", "gpu.sm0.rt.memory_scheduler",
        "gpu.sm0.rt.ray_box", "gpu.sm0.rt.ray_triangle", "gpu.sm0.rt.sibling_prefetcher", "gpu.sm0.l1d: mshr",
        "miss queue", "gpu.crossbar: requests", "gpu.crossbar: replies", "gpu.l2_slice0: pipe", "dram queue",
        "dram channel 0", "gpu.sm1.simt"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in the dump: " << text;
  }
}

}  // namespace
}  // namespace grtx::sim
