// Damaged configurations, plans, statistics and databases: each is read, or refused with an Error. Nothing else.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "explore/sweep/fake_tracer_rules.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/explore/report/run_results.h"
#include "grtx/explore/report/sweep_results.h"
#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/plan.h"
#include "grtx/explore/sweep/task.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/regress/regression_case.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "mutations.h"
#include "paths.h"
#include "sweep_database.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;

class ExploreFuzz : public ::testing::Test {
 protected:
  ExploreFuzz() : folder_((fs::temp_directory_path() / ("grtx_fuzz_" + std::to_string(::getpid()))).string()) {
    fs::create_directories(folder_);
  }
  ~ExploreFuzz() override { fs::remove_all(folder_); }

  template <class Read>
  void fuzz(const std::string& name, const std::string& original, const Read& read, std::uint64_t times = 300) {
    const std::string path = folder_ + "/" + name;
    std::mt19937_64 random(testing_fuzz::seed());
    std::uint64_t refused = 0;
    for (std::uint64_t i = 0; i < testing_fuzz::count(times); ++i) {
      const std::string bytes = testing_fuzz::mutated(original, random);
      { std::ofstream(path, std::ios::binary) << bytes; }
      try {
        read(path);
      } catch (const Error&) {
        ++refused;
      } catch (const std::exception& error) {
        ADD_FAILURE() << name << ", mutation " << i << " of seed " << testing_fuzz::seed() << ": " << error.what();
        write_file((fs::temp_directory_path() / ("grtx_find_" + std::to_string(i) + "_" + name)).string(), bytes);
      }
    }
    EXPECT_GT(refused, 0U) << name << ": no mutation was noticed";
  }

  std::string folder_;
  const test::FakeTracerRules tracer_;
};

TEST_F(ExploreFuzz, Configurations) {
  fuzz("c.toml", read_file(grtx::paths::source_dir() + "/configs/small.toml"),
       [](const std::string& path) { (void)load_config(path, {}); });
}

TEST_F(ExploreFuzz, Plans) {
  fuzz("p.toml",
       "designs = ['baseline', 'grtx']\nmode = 'fast'\nconfirm = 'cycle'\n[[scene]]\npreset = 'object'\ncount = 100\n"
       "views = [0, 1]\nwidth = 8\n[set]\ngpu.sms = 2\n[tracer]\nk = 8\n[limits]\nseconds = 5\n[grid]\n"
       "l1.latency = {from = 10, to = 40, steps = 3, integer = true}\n[random]\ncount = 5\nseed = 3\n[random.axes]\n"
       "l2.latency = [100, 200]\n",
       [&](const std::string& path) { (void)load_plan(path, tracer_); });
  fuzz(
      "s.toml",
      "[[scene]]\npreset = 'object'\ncount = 100\n[[parameter]]\nkey = 'l1.latency'\nvalues = [10, 20]\n[[objective]]\n"
      "value = 'gpu.time_us'\n[[constraint]]\nvalue = 'cost.mm2'\nat_most = 1.5\nrelative = true\n[reference]\n"
      "l1.latency = 20\n[search]\ngenerations = 2\npopulation = 8\nseed = 1\n",
      [&](const std::string& path) { (void)load_search_plan(path, tracer_); });
}

TEST_F(ExploreFuzz, CasesOfARegression) {
  fuzz("a.case.toml",
       "trace = 'a.grtx'\nmachine = 'paper'\nset = ['gpu.sms=2']\nmode = 'sampled'\nshare = 0.5\nseed = 2\n"
       "statistics = ['gpu.*']\n[tolerance]\n'gpu.l1.*' = 0.1\n[[update]]\ndate = 2026-11-23\nreason = 'x'\n",
       [&](const std::string&) { (void)load_regression(folder_); });
}

TEST_F(ExploreFuzz, StatisticsAndResults) {
  const std::string statistics =
      R"({"schema": "grtx.stats/1", "config": {"gpu.sms": 2}, "inputs": {"accel": "tri20", "checkpoint": "off"}, )"
      R"("stats": {"gpu.cycles": {"value": 12, "unit": "cycles", "description": "d"}, )"
      R"("gpu.rt.stall.memory": {"value": 1.5, "unit": "cycles", "description": ""}}})";
  fuzz("s.json", statistics, [](const std::string& path) { (void)read_statistics(path); });
  fuzz("r.json", statistics, [](const std::string& path) { (void)read_run_results(path); });
  const std::string result =
      R"({"key": "k", "kind": "point", "status": "failed", "reason": "r", "seconds": 1.5, "bytes": 3})";
  fuzz("k.json", result, [](const std::string& path) { (void)read_outcome(path); });
}

TEST_F(ExploreFuzz, Databases) {
  const std::string original = folder_ + "/original.sqlite";
  testing_sweep::make_points(original, {{{"id", 1}, {"values", {{"gpu.time_us", 2.0}, {"cost.mm2", 3.0}}}}});
  const std::string bytes = read_file(original);
  fuzz(
      "d.sqlite", bytes, [](const std::string& path) { (void)read_sweep_results(path); }, 100);
  fuzz(
      "w.sqlite", bytes, [](const std::string& path) { (void)SweepDatabase(path).meta("plan"); }, 100);
}

}  // namespace
}  // namespace grtx::sim
