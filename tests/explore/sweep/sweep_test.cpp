// A sweep through the program: results, resuming after SIGKILL at any moment, points that fail, are killed or take too
// long, and the confirmation of the front.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "explore/sweep/sweep_bench.h"
#include "paths.h"

namespace grtx::sim {
namespace {

using test::Outcome;
using testing::ElementsAre;
using testing::HasSubstr;
using Texts = std::vector<std::string>;

class Sweep : public test::SweepBench {};

TEST_F(Sweep, FillsItsDatabaseOnce) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  EXPECT_THAT(rows("a.sqlite", "SELECT value FROM meta WHERE key = 'schema'"), ElementsAre("grtx.sweep/1"));
  EXPECT_THAT(rows("a.sqlite", "SELECT status, count(*) FROM point GROUP BY status", 2), ElementsAre("done|8"));
  EXPECT_THAT(rows("a.sqlite", "SELECT status, count(*) FROM trace GROUP BY status", 2), ElementsAre("done|2"));
  EXPECT_THAT(rows("a.sqlite", "SELECT coordinates FROM point WHERE id = 2"),
              ElementsAre(R"({"tracer.k":4,"rt.warp_buffer.entries":2,"rt.checkpoint.lanes":4})"));
  // The document is that of `grtx sim` on the same trace and configuration.
  const auto document = nlohmann::json::parse(rows("a.sqlite", "SELECT document FROM point WHERE id = 5").at(0));
  const std::string trace =
      rows("a.sqlite", "SELECT path FROM trace JOIN point ON trace.key = trace_key WHERE id = 5").at(0);
  ASSERT_EQ(
      test::shell(grtx::paths::program() + " sim " + folder + "/" + trace + " --config " + grtx::paths::source_dir() +
                  "/configs/small.toml --set rt.warp_buffer.entries=2 --set rt.checkpoint.lanes=1 --quiet "
                  "--stats " +
                  folder + "/s.json")
          .code,
      0);
  auto alone = nlohmann::json::parse(read_file(folder + "/s.json"));
  for (auto entry = alone["stats"].begin(); entry != alone["stats"].end();) {
    entry = entry.key().starts_with("host.") ? alone["stats"].erase(entry) : std::next(entry);
  }
  EXPECT_EQ(document, alone);
  EXPECT_EQ(
      rows("a.sqlite", "SELECT printf('%.9g', value) FROM value WHERE point_id = 5 AND name = 'gpu.cycles'").at(0),
      alone["stats"]["gpu.cycles"]["value"].dump());
  for (const char* name : {"gpu.energy_nj_per_ray", "cost.mm2", "cost.rt_unit_mm2", "cost.leakage_mw"}) {
    EXPECT_THAT(rows("a.sqlite", std::string("SELECT count(*) FROM value JOIN quantity USING(name) WHERE name = '") +
                                     name + "' AND value > 0 AND unit != ''"),
                ElementsAre("8"))
        << name;
  }
  // Nothing is left over, and nothing is run again.
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    EXPECT_THAT((Texts{"a.sqlite", "plan.toml", "traces", "s.json"}),
                testing::Contains(entry.path().filename().string()));
  }
  const Texts before = rows("a.sqlite", "SELECT seconds FROM point ORDER BY id");
  ASSERT_EQ(
      sweep("a.sqlite", "--program " + program("case $1 in trace|synth) exit 9;; sim) [ $# = 4 ] || exit 9;; esac"))
          .code,
      0);
  EXPECT_EQ(rows("a.sqlite", "SELECT seconds FROM point ORDER BY id"), before);
}

TEST_F(Sweep, KilledTwiceAndResumedEqualsAnUndisturbedOne) {
  write_plan();
  ASSERT_EQ(sweep("undisturbed.sqlite").code, 0);
  std::filesystem::remove_all(folder + "/traces");
  std::mt19937 random(std::random_device{}());
  for (int i = 0; i < 2; ++i) {
    const std::chrono::milliseconds after(random() % 400);
    kill_sweep("killed.sqlite", after, i == 0 ? "--jobs 1" : "--jobs 2");
    SCOPED_TRACE(testing::Message() << "killed after " << after.count() << " ms");
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {  // what is there is complete
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos);
    }
  }
  const Outcome resumed = sweep("killed.sqlite");
  EXPECT_EQ(resumed.code, 0) << resumed.output;
  const Outcome same = test::shell(grtx::paths::program() + " sweep --compare " + folder + "/undisturbed.sqlite " +
                                   folder + "/killed.sqlite");
  EXPECT_EQ(same.code, 0) << same.output;
  EXPECT_EQ(rows("killed.sqlite", "SELECT id, key FROM point ORDER BY id", 2),
            rows("undisturbed.sqlite", "SELECT id, key FROM point ORDER BY id", 2));
  EXPECT_FALSE(std::filesystem::exists(folder + "/killed.sqlite.work"));
}

TEST_F(Sweep, ADifferenceIsFound) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  std::filesystem::copy_file(folder + "/a.sqlite", folder + "/b.sqlite");
  {
    Sqlite b(folder + "/b.sqlite", Sqlite::Open::create);
    b.execute("UPDATE value SET value = value + 1 WHERE point_id = 3 AND name = 'gpu.cycles'");
    b.execute("UPDATE point SET seconds = 7 WHERE id = 4");  // may differ
  }
  const Outcome compared =
      test::shell(grtx::paths::program() + " sweep --compare " + folder + "/a.sqlite " + folder + "/b.sqlite");
  EXPECT_EQ(compared.code, 1);
  EXPECT_EQ(std::count(compared.output.begin(), compared.output.end(), '\n'), 1) << compared.output;
  EXPECT_THAT(compared.output, HasSubstr("gpu.cycles"));
}

TEST_F(Sweep, WhatFailsIsRecordedAndSpoilsNothingElse) {
  write_plan("[[point]]\nl1.bytes = 64\n[limits]\nseconds = 4\n");
  // Of the simulations, one of each of these fails; `sim TRACE --config FILE ...`
  const std::string script = program(
      "lanes=$(sed -n 's/^\"rt.checkpoint.lanes\" = //p' \"$4\" 2>/dev/null)\n"
      "warps=$(sed -n 's/^\"rt.warp_buffer.entries\" = //p' \"$4\" 2>/dev/null)\n"
      "case \"$1 $warps $lanes\" in\n"
      "  'sim 2 1') kill -9 $$;;\n"
      "  'sim 2 4') exec sleep 60;;\n"
      "  'sim 4 1') echo 'something else' >&2; echo 'grtx: no luck' >&2; exit 3;;\n"
      "esac");
  EXPECT_EQ(sweep("a.sqlite", "--jobs 2 --program " + script).code, 1);
  EXPECT_EQ(rows("a.sqlite", "SELECT status, reason, count(*) FROM point GROUP BY status, reason", 3),
            (Texts{"done||2", "failed|configuration: l1.bytes: must hold at least l1.ways lines of l1.line_bytes|1",
                   "failed|sim: no luck|2", "killed|sim: ended by SIGKILL|2", "timeout|sim: longer than 4 s|2"}));
  // They stay as they are, until they are asked for.
  EXPECT_EQ(sweep("a.sqlite").code, 1);
  EXPECT_EQ(rows("a.sqlite", "SELECT count(*) FROM point WHERE status = 'done'"), (Texts{"2"}));
  EXPECT_EQ(sweep("a.sqlite", "--retry").code, 1);
  EXPECT_EQ(rows("a.sqlite", "SELECT status, count(*) FROM point GROUP BY status", 2), (Texts{"done|8", "failed|1"}));
}

TEST_F(Sweep, MemoryIsLimited) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer reserves terabytes: memory is not limited";
#endif
  write_plan("[limits]\nmemory_mb = 3\n");
  EXPECT_EQ(sweep("a.sqlite").code, 1);
  EXPECT_EQ(
      rows("a.sqlite", "SELECT count(*) FROM point WHERE status IN ('failed', 'killed') AND reason LIKE 'trace: %'"),
      (Texts{"8"}));
}

TEST_F(Sweep, AWorkerThatIsKilledLosesItsPointOnly) {
  write_plan();
  // The simulation kills the worker that waits for it, once.
  const std::string script = program("if [ $1 = sim ] && [ $# -gt 4 ] && mkdir " + folder +
                                     "/once 2>/dev/null; then kill -9 $PPID; sleep 9; fi");
  EXPECT_EQ(sweep("a.sqlite", "--jobs 1 --program " + script).code, 1);
  EXPECT_EQ(rows("a.sqlite", "SELECT status, reason, count(*) FROM point GROUP BY status, reason", 3),
            (Texts{"done||7", "killed|its process ended by SIGKILL|1"}));
}

TEST_F(Sweep, AMistypedModeIsNoFailureOfEveryPoint) {
  write_plan();
  const Outcome outcome = sweep("a.sqlite", "--mode cyle");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.output, HasSubstr("plan.toml: mode: "));
  EXPECT_THAT(outcome.output, HasSubstr("'cycle'"));
  EXPECT_FALSE(std::filesystem::exists(folder + "/a.sqlite"));
}

TEST_F(Sweep, BadInputIsOneLine) {
  write_plan("[tracer]\nsort_kye = 'peak'\n");
  Outcome outcome = sweep("a.sqlite");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.output, HasSubstr("plan.toml: line 13: tracer.sort_kye: unknown tracer option"));
  EXPECT_THAT(outcome.output, HasSubstr("'sort-key'"));
  write_plan();
  write_file(folder + "/x.sqlite", "this is no database, but it is long enough to be looked at as one............");
  outcome = sweep("x.sqlite");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
}

TEST_F(Sweep, TheFrontIsConfirmedInAnotherMode) {
  write_plan("[[point]]\nl1.bytes = 4096\n");
  // A program that knows a second mode: `screen`, which is cycle.
  const std::string script = program(
      "n=$#; while [ $n -gt 0 ]; do a=$1; shift; [ \"$a\" = screen ] && a=cycle; set -- \"$@\" \"$a\"; n=$((n - 1)); "
      "done");
  ASSERT_EQ(sweep("a.sqlite", "--mode screen --confirm cycle --program " + script).code, 0);
  EXPECT_EQ(rows("a.sqlite", "SELECT mode, status, count(*) FROM point WHERE mode = 'screen' GROUP BY status", 3),
            (Texts{"screen|done|9"}));
  const Texts confirmed = rows("a.sqlite", "SELECT coordinates FROM point WHERE mode = 'cycle' AND status = 'done'");
  EXPECT_GE(confirmed.size(), 1U);
  EXPECT_LT(confirmed.size(), 9U);
  // Exactly those that no other point beats.
  const Texts front = rows("a.sqlite", R"(
    WITH p AS (SELECT id, coordinates, t.value AS time, a.value AS area FROM point
               JOIN value t ON t.point_id = id AND t.name = 'gpu.time_us'
               JOIN value a ON a.point_id = id AND a.name = 'cost.mm2' WHERE mode = 'screen')
    SELECT coordinates FROM p WHERE NOT EXISTS (SELECT 1 FROM p AS b WHERE b.time <= p.time AND b.area <= p.area
                                                AND (b.time < p.time OR b.area < p.area)) ORDER BY id)");
  EXPECT_EQ(confirmed, front);
}

}  // namespace
}  // namespace grtx::sim
