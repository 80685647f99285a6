// SPDX-License-Identifier: Apache-2.0
// A sweep through the program: results, resuming after SIGKILL at any moment, points that fail, are killed or take too
// long, and the confirmation of the front.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "explore/sweep/sweep_bench.h"
#include "grtx/rtl_tlm/run/model_version.h"
#include "paths.h"

namespace grtx::explore {
namespace {

using test::Outcome;
using testing::ElementsAre;
using testing::HasSubstr;
using Texts = std::vector<std::string>;

class Sweep : public test::SweepBench {};

TEST_F(Sweep, FillsItsDatabaseOnce) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  EXPECT_THAT(rows("a.sqlite", "SELECT value FROM meta WHERE key = 'schema'"), ElementsAre("grtx.sweep/3"));
  EXPECT_THAT(rows("a.sqlite", "SELECT status, count(*) FROM point GROUP BY status", 2), ElementsAre("done|8"));
  EXPECT_THAT(rows("a.sqlite", "SELECT status, count(*) FROM trace GROUP BY status", 2), ElementsAre("done|2"));
  EXPECT_THAT(rows("a.sqlite", "SELECT coordinates FROM point WHERE id = 2"),
              ElementsAre(R"({"tracer.k":4,"rt.warp_buffer.entries":2,"rt.checkpoint.lanes":4})"));
  // The document is that of `grtx sim` on the same trace and configuration.
  auto document = nlohmann::json::parse(rows("a.sqlite", "SELECT document FROM point WHERE id = 5").at(0));
  EXPECT_GT(document.at("cost").at("cost.mm2").get<double>(), 0.0);
  document.erase("cost");
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

// It ended with the number of its points.
TEST_F(Sweep, ItEndsWithTheFrontAndTheNextCommand) {
  write_plan("machine = ['paper', 'paper-charged']\n");
  const Outcome outcome = sweep("a.sqlite", "2>/dev/null");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(rows("a.sqlite", "SELECT machine || count(*) FROM point GROUP BY machine"),
            (Texts{"paper8", "paper-charged8"}));
  EXPECT_EQ(rows("a.sqlite", "SELECT count(*) FROM trace"), (Texts{"2"}));  // which both machines share
  const std::size_t front = outcome.output.find("\nfront of time against the area of the chip\n");
  ASSERT_NE(front, std::string::npos) << outcome.output;
  const std::string end = outcome.output.substr(front);
  EXPECT_THAT(
      end, testing::AllOf(HasSubstr(" RT unit, mm2 "), HasSubstr("rt.warp_buffer.entries = "),
                          HasSubstr("each is the fastest of its area or less; least time #"),
                          testing::EndsWith("next: grtx report " + folder + "/a.sqlite -o " + folder + "/a.html\n")));
  write_file(folder + "/plan.toml", "area = 'cost.rt_unit_mm2'\n" + read_file(folder + "/plan.toml"));
  EXPECT_THAT(sweep("a.sqlite", "2>/dev/null").output, HasSubstr("\nfront of time against the area of an RT unit\n"));
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

TEST_F(Sweep, CtrlCLeavesNoHalfTraceAndSaysHowToResume) {
  write_file(folder + "/plan.toml", "base = '" + grtx::paths::source_dir() +
                                        "/configs/small.toml'\n[[scene]]\npreset = 'object'\ncount = 300\n"
                                        "width = 4096\nheight = 4096\n");
  const auto half_a_trace = [&] {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.path().filename().string().find(".grtx.partial") != std::string::npos) return true;
    }
    return false;
  };
  // To all processes of the terminal's job, as a terminal does.
  write_file(folder + "/script", "cd " + folder + "; set -m; " + grtx::paths::program() + " " +
                                     arguments("a.sqlite", "--quiet") +
                                     " & for i in $(seq 3000); do ls a.sqlite.work/scratch/*/trace.grtx.partial "
                                     ">/dev/null 2>&1 && break; sleep 0.01; done; kill -INT -$!; wait $!");
  const Outcome stopped = test::shell("bash " + folder + "/script");
  EXPECT_EQ(stopped.code, 130);
  EXPECT_NE(stopped.output.find("grtx: ended by SIGINT: what was being written is removed; start again to resume\n"),
            std::string::npos)
      << stopped.output;
  for (int i = 0; i < 500 && half_a_trace(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(half_a_trace());
  EXPECT_EQ(rows("a.sqlite", "SELECT status FROM trace"), std::vector<std::string>{"running"}) << "it runs again";
}

TEST_F(Sweep, ADifferenceIsFound) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  std::filesystem::copy_file(folder + "/a.sqlite", folder + "/b.sqlite");
  {
    Sqlite b(folder + "/b.sqlite", Sqlite::Open::create);
    b.execute("UPDATE quantity SET unit = 'ticks' WHERE name = 'gpu.cycles'");
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
  // One simulation of each of these kinds fails; `sim TRACE --config FILE ...`
  const std::string script = program(
      "lanes=$(sed -n 's/^\"rt.checkpoint.lanes\" = //p' \"${4%.toml}.below.toml\" 2>/dev/null)\n"
      "warps=$(sed -n 's/^\"rt.warp_buffer.entries\" = //p' \"${4%.toml}.below.toml\" 2>/dev/null)\n"
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

/// The list is printed point by point: as a document it took more memory than the points.
TEST_F(Sweep, ListsItsPointsAsOneDocument) {
  write_plan("[[point]]\nl1.bytes = 64\n");
  const auto list = [&](const std::string& database) {
    const Outcome outcome = test::shell(grtx::paths::program() + " sweep " + folder + "/plan.toml --list --json -o " +
                                        folder + "/" + database);
    EXPECT_EQ(outcome.code, 0);
    const auto document = nlohmann::ordered_json::parse(outcome.output);
    EXPECT_EQ(outcome.output, document.dump(1) + "\n");
    EXPECT_EQ(document.at("schema"), "grtx.sweep/1");
    EXPECT_EQ(document.at("points").size(), 9U);
    EXPECT_EQ(document.at("traces"), 3);  // a point that names no design has the machine's k
    return document;
  };
  const auto before = list("a.sqlite");
  EXPECT_EQ(before.at("points").at(8).at("status"), "new");
  EXPECT_EQ(before.at("points").at(8).at("coordinates").dump(), R"({"l1.bytes":64})");
  EXPECT_EQ(sweep("a.sqlite").code, 1);
  const auto after = list("a.sqlite");
  EXPECT_EQ(after.at("points").at(0).at("status"), "done");
  EXPECT_EQ(after.at("points").at(8).at("status"), "failed");
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

// What has gone wrong once.

TEST_F(Sweep, AFolderOfSomebodyElsesIsNotDeleted) {
  write_plan();
  const std::string work = folder + "/a.sqlite.work", other = folder + "/other";
  const auto expect_refused = [&](const std::string& text) {
    const Outcome outcome = sweep("a.sqlite");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(text));
  };
  std::filesystem::create_directories(work + "/results");
  write_file(work + "/results/mine", "precious");
  expect_refused("a.sqlite.work: is no work folder that may be deleted");
  EXPECT_EQ(read_file(work + "/results/mine"), "precious");
  std::filesystem::rename(work, other);
  std::filesystem::create_directory_symlink(other, work);
  expect_refused("a.sqlite.work: is no work folder that may be deleted");
  EXPECT_EQ(read_file(other + "/results/mine"), "precious");
  std::filesystem::remove(work);
  write_file(folder + "/a.sqlite.lock", "mine, too");
  expect_refused("a.sqlite.lock: is no lock");
  EXPECT_EQ(read_file(folder + "/a.sqlite.lock"), "mine, too");
  std::filesystem::remove(folder + "/a.sqlite.lock");
  write_file(folder + "/a.sqlite.mode", "mine as well");
  std::filesystem::create_directories(work);  // empty: killed while it was made
  EXPECT_EQ(sweep("a.sqlite").code, 0);
  EXPECT_EQ(read_file(folder + "/a.sqlite.mode"), "mine as well");
  // A worker that somebody starts by hand deletes no other folder, either.
  write_file(folder + "/task.json", R"({"key": "k", "kind": "point"})");
  test::shell(grtx::paths::program() + " sweep --task " + folder + "/task.json --result " + folder +
              "/k.json --scratch " + other);
  EXPECT_EQ(read_file(other + "/results/mine"), "precious");
  EXPECT_THAT(read_file(folder + "/k.json"), HasSubstr("is no work folder that may be deleted"));
}

TEST_F(Sweep, ADamagedTraceIsMadeAgain) {
  write_plan();
  ASSERT_EQ(sweep("undamaged.sqlite").code, 0);
  ASSERT_EQ(sweep("a.sqlite", "--program " + program("[ $1 = sim ] && [ $# -gt 4 ] && kill -9 $$")).code, 1);
  const Texts traces = rows("a.sqlite", "SELECT path FROM trace ORDER BY key");
  ASSERT_EQ(traces.size(), 2U);
  const std::string first = folder + "/" + traces[0], second = folder + "/" + traces[1];
  const std::string sound = read_file(first);
  write_file(first, std::string(sound.size(), '\0'));  // as after a power loss
  std::string flipped = read_file(second);
  flipped[flipped.size() / 2] ^= 1;
  write_file(second, flipped);
  EXPECT_EQ(sweep("a.sqlite", "--retry").code, 0);
  EXPECT_EQ(read_file(first), sound);
  const auto same = [&](const std::string& database) {
    return test::shell(grtx::paths::program() + " sweep --compare " + folder + "/undamaged.sqlite " + folder + "/" +
                       database);
  };
  EXPECT_EQ(same("a.sqlite").output, "the same results\n");
  // While a sweep runs: the point waits for the next one, which makes the trace again.
  const std::string damages =
      "if [ $1 = sim ] && [ $# -gt 4 ] && mkdir " + folder + "/once 2>/dev/null; then : > \"$2\"; fi";
  const Outcome damaged = sweep("b.sqlite", "--jobs 1 --program " + program(damages));
  EXPECT_EQ(damaged.code, 1) << damaged.output;
  EXPECT_THAT(rows("b.sqlite", "SELECT status, count(*) FROM point GROUP BY status", 2),
              ElementsAre("done|4", "pending|4"));
  EXPECT_EQ(sweep("b.sqlite").code, 0);
  EXPECT_EQ(same("b.sqlite").output, "the same results\n");
}

TEST_F(Sweep, ATruncatedResultBlocksNoResume) {
  write_plan();
  ASSERT_EQ(sweep("undisturbed.sqlite").code, 0);
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const Texts keys = rows("a.sqlite", "SELECT key FROM point ORDER BY id");
  {
    Sqlite database(folder + "/a.sqlite", Sqlite::Open::create);  // as a killed sweep leaves it
    database.execute("UPDATE point SET status = 'running', document = NULL; DELETE FROM value");
  }
  const std::string results = folder + "/a.sqlite.work/results/";
  std::filesystem::create_directories(results);
  write_file(folder + "/a.sqlite.work/.grtx-work", "");
  const auto result = [&](std::size_t point, const std::string& text) {
    write_file(results + keys[point] + ".json", text);
  };
  result(0, "");
  result(1, "{\"key\": \"");
  result(2, R"({"key": ")" + keys[2] + R"(", "kind": "point", "status": "done"})");
  result(3, R"({"key": ")" + keys[3] + R"(", "kind": "point", "status": "done", "document": {"stats": {"a": 1}}})");
  result(4, R"({"key": ")" + keys[5] + R"(", "kind": "point", "status": "failed", "reason": "another's"})");
  result(5, R"({"key": 7})");
  std::filesystem::create_directory(results + "folder.json");
  const Outcome resumed = sweep("a.sqlite");
  EXPECT_EQ(resumed.code, 0) << resumed.output;
  const Outcome same = test::shell(grtx::paths::program() + " sweep --compare " + folder + "/undisturbed.sqlite " +
                                   folder + "/a.sqlite");
  EXPECT_EQ(same.output, "the same results\n");
}

TEST_F(Sweep, ATriggerOrTableThatNoSweepMadeIsRefused) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  struct Case {
    const char *sql, *refused, *text;
  };
  for (const Case& c :
       {Case{"CREATE TRIGGER t AFTER INSERT ON value BEGIN UPDATE value SET value = 1; END", "sweep",
             "trigger t: was not made by a sweep"},
        Case{"ALTER TABLE value RENAME TO z; CREATE VIEW value AS SELECT * FROM z", "sweep report",
             "view value: is not the table that a sweep makes"},
        Case{"DROP TABLE quantity; CREATE TABLE quantity(name TEXT CHECK(name = ''), unit, description)",
             "sweep report", "table quantity: is not the table that a sweep makes"},
        Case{"CREATE VIEW mine AS SELECT * FROM value", "sweep", "view mine: was not made by a sweep"},
        Case{"CREATE INDEX i ON value(value)", "sweep", "index i: was not made by a sweep"}}) {
    std::filesystem::copy_file(folder + "/a.sqlite", folder + "/b.sqlite",
                               std::filesystem::copy_options::overwrite_existing);
    Sqlite(folder + "/b.sqlite", Sqlite::Open::create).execute(c.sql);
    const Outcome filled = sweep("b.sqlite");
    EXPECT_EQ(filled.code, 2) << c.sql;
    EXPECT_THAT(filled.output, HasSubstr(c.text)) << c.sql;
    EXPECT_EQ(std::count(filled.output.begin(), filled.output.end(), '\n'), 1) << filled.output;
    const Outcome report =
        test::shell(grtx::paths::program() + " report " + folder + "/b.sqlite -o " + folder + "/r.html");
    EXPECT_EQ(report.code, std::string(c.refused) == "sweep" ? 0 : 2) << c.sql << report.output;
  }
}

TEST_F(Sweep, AForgedValueIsRefused) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const std::string key = rows("a.sqlite", "SELECT key FROM point WHERE id = 3").at(0);
  const auto copy = [&](const std::string& sql) {
    std::filesystem::copy_file(folder + "/a.sqlite", folder + "/b.sqlite",
                               std::filesystem::copy_options::overwrite_existing);
    Sqlite(folder + "/b.sqlite", Sqlite::Open::create).execute(sql);
  };
  // A text would read as 0: the table does not take it.
  EXPECT_THROW(copy("UPDATE value SET value = 'many' WHERE point_id = 3"), Error);
  struct Case {
    const char *sql, *text;
  };
  for (const Case& c :
       {Case{"UPDATE value SET value = 1 WHERE point_id = 3 AND name = 'gpu.cycles'", "gpu.cycles is 1 in"},
        Case{"UPDATE value SET value = 1 WHERE point_id = 3 AND name = 'cost.mm2'", "cost.mm2 is 1 in"},
        Case{"DELETE FROM value WHERE point_id = 3 AND name = 'gpu.cycles'", "gpu.cycles is missing in"},
        Case{"INSERT INTO value VALUES(3, 'gpu.mine', 7)", "gpu.mine is 7 in the table `value` and missing"},
        Case{"UPDATE value SET value = NULL WHERE point_id = 3 AND name = 'gpu.cycles'", "must be a number"},
        Case{"UPDATE point SET document = substr(document, 1, 99) WHERE id = 3", "is no JSON"},
        Case{"UPDATE point SET document = NULL WHERE id = 3", "is no JSON"}}) {
    copy(c.sql);
    const std::string b = folder + "/b.sqlite";
    for (const std::string& arguments :
         {"report " + b + " -o " + folder + "/r.html", "sweep --compare " + folder + "/a.sqlite " + b,
          "sweep " + folder + "/plan.toml --list -o " + b, "sweep " + folder + "/plan.toml -o " + b}) {
      const Outcome refused = test::shell(grtx::paths::program() + " " + arguments);
      EXPECT_EQ(refused.code, 2) << c.sql << ": " << arguments;
      EXPECT_EQ(std::count(refused.output.begin(), refused.output.end(), '\n'), 1) << refused.output;
      EXPECT_THAT(refused.output, AllOf(HasSubstr("point 3 (" + key + ")"), HasSubstr(c.text))) << c.sql;
    }
  }
}

TEST_F(Sweep, ADatabaseOfAnotherSchemaIsNeitherReadNorFilled) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  Sqlite(folder + "/a.sqlite", Sqlite::Open::create)
      .execute("UPDATE meta SET value = 'grtx.sweep/2' WHERE key = 'schema'");
  for (const std::string& arguments : {"report " + folder + "/a.sqlite -o " + folder + "/r.html",
                                       "sweep --compare " + folder + "/a.sqlite " + folder + "/a.sqlite"}) {
    EXPECT_THAT(test::shell(grtx::paths::program() + " " + arguments).output,
                HasSubstr("meta.schema: must be grtx.sweep/3"));
  }
  EXPECT_EQ(sweep("a.sqlite").code, 2);
}

TEST_F(Sweep, PointsOfTwoModelsAreNotMixedInOneDatabase) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  Sqlite(folder + "/a.sqlite", Sqlite::Open::create).execute("UPDATE meta SET value = '1' WHERE key = 'model_version'");
  const Outcome filled = sweep("a.sqlite");
  EXPECT_EQ(filled.code, 2);
  EXPECT_THAT(filled.output, HasSubstr("meta.model_version: 1: this program's model has version " +
                                       std::to_string(sim::kModelVersion) + ": begin another database"));
}

TEST_F(Sweep, ADatabaseCalledMemoryIsAFile) {
  write_plan();
  const auto here = [&](const std::string& arguments) {
    return test::shell("cd " + folder + " && " + grtx::paths::program() + " " + arguments);
  };
  ASSERT_EQ(here("sweep plan.toml -o :memory: --quiet").code, 0);
  EXPECT_EQ(rows(":memory:", "SELECT count(*) FROM point WHERE status = 'done'"), (Texts{"8"}));
  const Outcome report = here("report :memory: -o r.html");
  EXPECT_EQ(report.code, 0) << report.output;
  EXPECT_THAT(here("sweep --compare :memory: " + folder + "/:memory:").output, HasSubstr("the same results"));
}

/// A sweep of an object list, and what happens to it when a file changes that the list names.
class SweepOfObjects : public Sweep {
 protected:
  SweepOfObjects() {
    make_object("a.ply", 1);
    make_object("b.ply", 2);
    write_file(folder + "/objects.json", R"([{"file": "a.ply"}, {"file": "b.ply", "translate": [3, 0, 0]}])");
    write_file(folder + "/plan.toml", "base = '" + grtx::paths::source_dir() +
                                          "/configs/small.toml'\n[[scene]]\nfile = 'objects.json'\n"
                                          "cameras = 'a.cameras.json'\nwidth = 8\nheight = 8\n");
  }
  void make_object(const std::string& name, int seed) const {
    EXPECT_EQ(test::shell(grtx::paths::program() + " synth --preset object --count 200 --quiet --seed " +
                          std::to_string(seed) + " -o " + folder + "/" + name)
                  .code,
              0);
  }
  std::string point(const std::string& what) const {
    return rows("a.sqlite", "SELECT " + what + " FROM point ORDER BY id DESC LIMIT 1").at(0);
  }
};

TEST_F(SweepOfObjects, AChangedMemberIsAnotherScene) {
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const std::string key = point("key"), inputs = point("json_extract(document, '$.inputs')");
  EXPECT_THAT(inputs, AllOf(HasSubstr("objects.json "), HasSubstr("a.ply "), HasSubstr("b.ply "),
                            HasSubstr("a.cameras.json ")));
  make_object("b.ply", 3);
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  EXPECT_NE(point("key"), key);
  EXPECT_EQ(rows("a.sqlite", "SELECT count(*) FROM point"), (Texts{"2"}));
  EXPECT_NE(
      point("json_extract(document, '$.inputs.\"trace.files_hash\"')"),
      rows("a.sqlite", "SELECT json_extract(document, '$.inputs.\"trace.files_hash\"') FROM point WHERE id = 1").at(0));
}

TEST_F(SweepOfObjects, ATraceOfAnotherSceneIsMadeAgain) {
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const std::string trace = folder + "/" + rows("a.sqlite", "SELECT path FROM trace").at(0), made = read_file(trace);
  // Sound, of the same options, and of other Gaussians.
  const std::string b = read_file(folder + "/b.ply");
  make_object("b.ply", 3);
  ASSERT_EQ(test::shell(grtx::paths::program() + " trace --quiet --scene " + folder + "/objects.json --cameras " +
                        folder + "/a.cameras.json --width 8 --height 8 --accel tlas-tri20 --checkpoint on -o " + trace)
                .code,
            0);
  ASSERT_NE(read_file(trace), made);
  write_file(folder + "/b.ply", b);
  ASSERT_EQ(sweep("b.sqlite").code, 0);
  EXPECT_EQ(read_file(trace), made);
  EXPECT_EQ(
      test::shell(grtx::paths::program() + " sweep --compare " + folder + "/a.sqlite " + folder + "/b.sqlite").output,
      "the same results\n");
}

TEST_F(SweepOfObjects, ASceneThatChangesWhileASweepRunsFailsItsPoint) {
  const std::string script = program("if [ $1 = trace ]; then cp " + folder + "/a.ply " + folder + "/b.ply; fi");
  EXPECT_EQ(sweep("a.sqlite", "--program " + script).code, 1);
  EXPECT_THAT(point("reason"), HasSubstr("trace: was made from other files"));
}

TEST_F(Sweep, AnEditedGeneratedSceneIsMadeAgain) {
  write_plan();
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  for (const auto& file : std::filesystem::directory_iterator(folder + "/traces")) {
    if (file.path().extension() == ".grtx") std::filesystem::remove(file.path());
    if (file.path().extension() != ".ply") continue;
    test::shell(grtx::paths::program() + " synth --preset object --count 300 --seed 8 --quiet -o " + folder +
                "/other.ply");
    std::filesystem::copy_file(folder + "/other.ply", file.path(), std::filesystem::copy_options::overwrite_existing);
  }
  ASSERT_EQ(sweep("b.sqlite").code, 0);
  EXPECT_EQ(
      test::shell(grtx::paths::program() + " sweep --compare " + folder + "/a.sqlite " + folder + "/b.sqlite").output,
      "the same results\n");
}

}  // namespace
}  // namespace grtx::explore
