// SPDX-License-Identifier: Apache-2.0
// Readers of configurations, plans, regressions, statistics, results of tasks and databases to fill.
#include <filesystem>

#include "explore/sweep/fake_tracer_rules.h"
#include "fuzz/readers.h"
#include "fuzz/result_seeds.h"
#include "grtx/base/atomic_file.h"
#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/plan.h"
#include "grtx/explore/sweep/task.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/regress/regression_case.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "paths.h"

namespace grtx::fuzzing {
namespace {

namespace fs = std::filesystem;

using Seeds = std::vector<std::string>;
Seeds one(const std::string& text) { return {text}; }

std::string source_file(const std::string& name) { return read_file(grtx::paths::source_dir() + "/" + name); }

}  // namespace

const std::vector<InputReader>& explore_readers() {
  static const std::vector<InputReader> all = {
      {"configuration", "c.toml", [](const std::string& path) { (void)sim::load_config(path, {}); }, nullptr,
       [] { return Seeds{source_file("configs/table1.toml")}; }},
      {"plan", "p.toml",
       [](const std::string& path) {
         static const explore::test::FakeTracerRules tracer;
         (void)explore::load_plan(path, tracer);
       },
       nullptr,
       [] {
         return one(
             "designs = ['baseline', 'grtx']\nconfirm = 'cycle'\n[[scene]]\npreset = 'object'\ncount "
             "= "
             "100\nviews = [0, 1]\nwidth = 8\n[set]\ngpu.sms = 2\n[tracer]\nk = 8\n[limits]\nseconds = 5\n[grid]\n"
             "l1.latency = {from = 10, to = 40, steps = 3, integer = true}\n[random]\ncount = 5\nseed = 3\n"
             "[random.axes]\nl2.latency = [100, 200]\n");
       }},
      {"search_plan", "q.toml",
       [](const std::string& path) {
         static const explore::test::FakeTracerRules tracer;
         (void)explore::load_search_plan(path, tracer);
       },
       nullptr,
       [] {
         return one(
             "[[scene]]\npreset = 'object'\ncount = 100\n[[parameter]]\nkey = 'l1.latency'\nvalues = [10, 20]\n"
             "[[objective]]\nvalue = 'gpu.time_us'\n[[constraint]]\nrule = 'cost.mm2 <= 1.5 * reference'\n"
             "[reference]\nl1.latency = 20\n[search]\ngenerations = 2\npopulation = 8\nseed = 1\n");
       }},
      {"case", "a.case.toml",
       [](const std::string& path) { (void)sim::load_regression(fs::path(path).parent_path().string()); }, nullptr,
       [] {
         return one(
             "trace = 'a.grtx'\nmachine = 'paper'\nset = ['gpu.sms=2']\nmode = 'windows'\nshare = 0.5\n"
             "seed = 2\nstatistics = ['gpu.*']\n[tolerance]\n'gpu.l1.*' = 0.1\n[[update]]\n"
             "date = 2026-11-23\nreason = 'x'\n");
       }},
      {"statistics", "s.json", [](const std::string& path) { (void)sim::read_statistics(path); }, nullptr,
       [] { return Seeds{kStatistics}; }},
      {"task_result", "k.json", [](const std::string& path) { (void)explore::read_outcome(path); }, nullptr,
       [] {
         return one(R"({"key": "k", "kind": "point", "status": "failed", "reason": "r", "seconds": 1.5, )"
                    R"("bytes": 3})");
       }},
      {"database_filled", "w.sqlite", [](const std::string& path) { (void)explore::SweepDatabase(path).meta("plan"); },
       nullptr, [] { return Seeds{database()}; }},
  };
  return all;
}

}  // namespace grtx::fuzzing
