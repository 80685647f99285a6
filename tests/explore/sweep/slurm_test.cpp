// SPDX-License-Identifier: Apache-2.0
// The same sweep as a job array of a real Slurm, which the test starts for itself, equals the local one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "explore/sweep/sweep_bench.h"
#include "paths.h"

namespace grtx::explore {
namespace {

using Texts = std::vector<std::string>;

class SlurmSweep : public test::SweepBench {
 protected:
  SlurmSweep() {
    // Ports of its own: tests run side by side.
    const std::string port = std::to_string(20000 + 2 * (::getpid() % 5000));
    const test::Outcome started = test::shell("GRTX_SLURM_PORT=" + port + " " + script("start"));
    if (started.code != 0) {
      EXPECT_EQ(started.code, 77) << started.output;
      skip = started.output;
      return;
    }
    ::setenv("SLURM_CONF", (folder + "/slurm/slurm.conf").c_str(), 1);
  }
  ~SlurmSweep() override { test::shell(script("stop")); }
  std::string script(const std::string& action) const {
    return grtx::paths::source_dir() + "/scripts/slurm_local.sh " + action + " " + folder + "/slurm";
  }
  std::string skip;
};

TEST_F(SlurmSweep, EqualsTheLocalOneAlsoWhenKilledAndWhenAJobIsLost) {
  if (!skip.empty()) GTEST_SKIP() << skip;
  write_plan();
  ASSERT_EQ(sweep("local.sqlite").code, 0);
  std::filesystem::remove_all(folder + "/traces");
  kill_sweep("slurm.sqlite", std::chrono::milliseconds(1500), "--launcher slurm");
  const test::Outcome outcome = sweep("slurm.sqlite", "--launcher slurm --jobs 2");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const test::Outcome same =
      test::shell(grtx::paths::program() + " sweep --compare " + folder + "/local.sqlite " + folder + "/slurm.sqlite");
  EXPECT_EQ(same.code, 0) << same.output;

  // A job that is cancelled under way: its point says so, the others are done.
  const std::string hang = program(
      "if [ $1 = sim ] && [ $# -gt 4 ] && grep -q '\"rt.checkpoint.lanes\" = 1$' \"${4%.toml}.below.toml\" && mkdir " +
      folder + "/once 2>/dev/null; then sleep 1; scancel ${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}; sleep 60; fi");
  EXPECT_EQ(sweep("lost.sqlite", "--launcher slurm --program " + hang).code, 1);
  EXPECT_EQ(rows("lost.sqlite", "SELECT status, reason, count(*) FROM point GROUP BY status, reason", 3),
            (Texts{"done||7", "killed|Slurm ended its job without a result (state CANCELLED)|1"}));
}

}  // namespace
}  // namespace grtx::explore
