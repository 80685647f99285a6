// SPDX-License-Identifier: Apache-2.0
// Cases of a regression at a time: when each begins, and in what order they are told.
#include "grtx/rtl_tlm/regress/regression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "temporary_folder.h"

namespace grtx::sim {
namespace {

TEST(Regression, ACaseBeginsAsSoonAsAnyBeforeItHasEnded) {
  const grtx::test::TemporaryFolder folder;
  const std::string begun = folder.path("begun");
  for (const char* name : {"a", "b", "c"}) {
    write_file(folder.path(std::string(name) + ".case.toml"), "trace = 't.grtx'\n");
  }
  RegressionOptions options;
  options.folder = folder.path();
  options.jobs = 2;
  options.silent = true;
  options.reason = "the first";
  options.simulate = [&](const RegressionCase& c, const GpuConfig&) {
    if (c.name == "c") write_file(begun, "c");
    for (int i = 0; c.name == "a" && !std::filesystem::exists(begun); ++i) {
      if (i == 1000) throw Error(c.file, "", "the third case waits for the first, though the second has ended");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    SimulationResult result;
    result.document = {{"schema", "grtx.statistics/1"},
                       {"config", nlohmann::ordered_json::object()},
                       {"inputs", nlohmann::ordered_json::object()},
                       {"stats", {{"gpu.cycles", {{"value", 1}}}}}};
    return result;
  };
  std::vector<std::string> names;
  for (const RegressionOutcome& outcome : run_regression(options)) {
    EXPECT_EQ(outcome.kind, RegressionOutcome::Kind::recorded) << outcome.message;
    names.push_back(outcome.regression_case.name);
  }
  EXPECT_THAT(names, testing::ElementsAre("a", "b", "c"));
}

}  // namespace
}  // namespace grtx::sim
