// SPDX-License-Identifier: Apache-2.0
// grtx regress: what is equal, what differs and where, what is recorded and why, and what is refused.
#include <gmock/gmock.h>

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Regress : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(folder_.run("synth --preset object --count 300 --seed 1 --quiet -o s.ply").code, 0);
    ASSERT_EQ(folder_
                  .run("trace --scene s.ply --cameras s.cameras.json --width 8 --height 8 --accel tlas-tri20 "
                       "--checkpoint on -o t.grtx --quiet")
                  .code,
              0);
    std::filesystem::create_directories(folder_.path("d/below"));
  }
  void write_case(const std::string& name, const std::string& more = "", const std::string& trace = "../t.grtx") {
    folder_.write("d/" + name + ".case.toml", "trace = '" + trace + "'\nset = ['gpu.sms=1'" + settings_ + "]\n" + more);
  }
  Outcome record() { return folder_.run("regress d --update --reason 'the first'"); }
  /// The line of a statistic in d/records.tsv, which has one case.
  std::string record_of(const std::string& statistic) {
    const std::string text = folder_.read("d/records.tsv");
    const std::size_t begin = text.find('\n' + statistic + '\t') + 1;
    return text.substr(begin, text.find('\n', begin) + 1 - begin);
  }
  void replace_record(const std::string& statistic, const std::string& line) {
    std::string text = folder_.read("d/records.tsv");
    const std::string old = record_of(statistic);
    folder_.write("d/records.tsv", text.replace(text.find(old), old.size(), line));
  }

  Folder folder_;
  std::string settings_;
};

TEST_F(Regress, EqualStatisticsAreNoDifferenceAndAreNotRecordedAgain) {
  write_case("cycle");
  write_case("named", "mode = 'cycle'\n");
  write_case("below/windows", "mode = 'windows'\nshare = 0.5\nmachine = 'paper'\n", "../../t.grtx");
  const Outcome recorded = record();
  EXPECT_EQ(recorded.code, 0) << recorded.err;
  EXPECT_THAT(recorded.out, HasSubstr("3 cases: 0 equal, 0 differ, 3 recorded, 0 refused"));
  const std::string file = folder_.read("d/cycle.case.toml");
  EXPECT_THAT(file, AllOf(HasSubstr("[[update]]"), HasSubstr("reason = \"the first\"")));
  EXPECT_THAT(folder_.read("d/records.tsv"), AllOf(HasSubstr("\ngpu.cycles\t"), Not(HasSubstr("host."))));
  for (const char* how : {"", "--jobs 3", "--update --reason 'nothing to do'"}) {
    const Outcome again = folder_.run(std::string("regress d ") + how);
    EXPECT_EQ(again.code, 0) << again.out << again.err;
    EXPECT_THAT(again.out, AllOf(HasSubstr("below/windows: equal, "), HasSubstr("3 cases: 3 equal")));
  }
  EXPECT_EQ(folder_.read("d/cycle.case.toml"), file);
  EXPECT_EQ(folder_.run("regress d --quiet").out, "");
  EXPECT_THAT(folder_.run("regress d --cases 'below/*'").out, HasSubstr("1 cases: 1 equal"));
}

// A trace of walk was recorded on shaders, 14 times slower, without a word.
TEST_F(Regress, ATraceOfWalkWithoutItsUnitsIsNoted) {
  ASSERT_EQ(
      folder_.run("run --scene s.ply --cameras s.cameras.json --width 8 --height 8 --designs walk -o out --quiet").code,
      0);
  folder_.write("d/walk.case.toml", "trace = '../out/walk.grtx'\nmachine = 'paper'\n");
  const Outcome without = record();
  EXPECT_EQ(without.code, 0) << without.err;
  EXPECT_THAT(without.err, HasSubstr("grtx: regress: walk: the trace is of design walk, whose units this run lacks"));
  folder_.write("d/walk.case.toml", "trace = '../out/walk.grtx'\nmachine = 'paper'\ndesign = 'walk'\n");
  const Outcome with = record();
  EXPECT_EQ(with.code, 0) << with.err;
  EXPECT_EQ(with.err, "");
  const auto cycles = nlohmann::json::parse(folder_.read("out/results.json")).at("designs").at("walk").at("gpu.cycles");
  EXPECT_THAT(record_of("gpu.cycles"), HasSubstr(cycles.at("value").dump()));
  folder_.write("d/walk.case.toml", "trace = '../out/walk.grtx'\ndesign = 'wlak'\n");
  EXPECT_THAT(folder_.run("regress d").err,
              HasSubstr("d/walk.case.toml: design: unknown 'wlak', the nearest is 'walk'"));
  folder_.write("d/walk.case.toml", "trace = '../t.grtx'\ndesign = 'walk'\n");
  const Outcome other = folder_.run("regress d");
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("t.grtx: header: is not of design walk: "));
}

TEST_F(Regress, ADifferenceSaysWhatMovedFirstAndUpdateRecordsWhy) {
  write_case("a");
  ASSERT_EQ(record().code, 0);
  const std::string before = folder_.read("d/records.tsv");
  settings_ = ", 'simt.cost.trace_call=999'";
  write_case("a");
  const Outcome differs = folder_.run("regress d --each 1 --junit out.xml");
  EXPECT_EQ(differs.code, 1);
  EXPECT_THAT(differs.out, AllOf(HasSubstr("a: differs: "), HasSubstr("  configuration simt.cost.trace_call: 6 -> 999"),
                                 HasSubstr("  moved first: SIMT core: gpu.simt."), HasSubstr("  whole machine: "),
                                 HasSubstr("    and ")));
  // Without --each: what moved most, and no page.
  const std::string brief = folder_.run("regress d").out;
  EXPECT_THAT(brief, AllOf(HasSubstr("  moved most:\n    gpu."), HasSubstr("  differ: ")));
  EXPECT_LE(std::count(brief.begin(), brief.end(), '\n'), 16) << brief;
  const std::string xml = folder_.read("out.xml");
  EXPECT_THAT(xml, AllOf(HasSubstr("tests=\"1\" failures=\"1\" errors=\"0\""),
                         HasSubstr("<testcase classname=\"d\" name=\"a\""), HasSubstr("<failure message=\""),
                         HasSubstr("moved first: SIMT core"), HasSubstr("-&gt;")));
  EXPECT_EQ(folder_.read("d/records.tsv"), before);
  EXPECT_EQ(folder_.run("regress d --update --reason 'calls are \"dear\"'").code, 0);
  EXPECT_THAT(folder_.read("d/a.case.toml"), HasSubstr(R"(reason = "calls are \"dear\"")"));
  EXPECT_NE(folder_.read("d/records.tsv"), before);
  EXPECT_EQ(folder_.run("regress d").code, 0);
}

// Cycles stood among the statistics of the whole machine, behind 200 others.
TEST_F(Regress, CyclesStandFirst) {
  write_case("a");
  ASSERT_EQ(record().code, 0);
  settings_ = ", 'simt.cost.trace_call=999'";
  write_case("a");
  for (const char* how : {"", " --each 1"}) {
    const std::string text = folder_.run("regress d" + std::string(how)).out;
    const std::size_t second = text.find('\n') + 1;
    EXPECT_EQ(text.substr(second, 13), "  gpu.cycles ") << text;
    EXPECT_NE(text.substr(second, text.find('\n', second) - second).find(" -> "), std::string::npos) << text;
  }
  settings_.clear();  // cycles as on record, and a record that is wrong elsewhere
  write_case("a");
  replace_record("gpu.l2.accesses", "gpu.l2.accesses\t1\n");
  EXPECT_THAT(folder_.run("regress d").out, HasSubstr(", as on record\n  moved first: "));
}

TEST_F(Regress, AListOfMachinesIsACaseForEach) {
  folder_.write("d/half.toml", "include = 'paper'\n[l2]\nbytes = 2097152\n");
  write_case("a", "machine = ['paper', 'half.toml']\n");
  EXPECT_THAT(record().out, AllOf(HasSubstr("a@paper: recorded"), HasSubstr("a@half: recorded"), HasSubstr("2 cases")));
  EXPECT_THAT(folder_.read("d/records.tsv"), HasSubstr("\ta@half\ta@paper\n"));
  const std::string file = folder_.read("d/a.case.toml");
  EXPECT_EQ(file.find("[[update]]"), file.rfind("[[update]]")) << file;  // one reason for both
  EXPECT_THAT(folder_.run("regress d").out, AllOf(HasSubstr("a@paper: equal"), HasSubstr("a@half: equal")));
  EXPECT_THAT(folder_.run("regress d --cases a@half").out, HasSubstr("1 cases: 1 equal"));
  for (const auto& [machines, rule] :
       {std::pair("[]", "machine: the list is empty"), std::pair("['paper', 'paper']", "two are called 'a@paper'")}) {
    write_case("a", "machine = " + std::string(machines) + "\n");
    const Outcome refused = folder_.run("regress d");
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err, HasSubstr(rule));
  }
}

TEST_F(Regress, ToleranceAndChoiceOfStatistics) {
  const auto with_cycles = [&](double factor) {
    const double cycles = std::stod(record_of("gpu.cycles").substr(std::string("gpu.cycles\t").size()));
    replace_record("gpu.cycles", fmt::format("gpu.cycles\t{:.0f}\n", cycles * factor));
  };
  write_case("a");
  ASSERT_EQ(record().code, 0);
  with_cycles(1.015);
  EXPECT_EQ(folder_.run("regress d").code, 1);
  write_case("a", "[tolerance]\n'gpu.*' = 0.02\n");
  EXPECT_EQ(folder_.run("regress d").code, 0);
  write_case("a", "[tolerance]\n'gpu.*' = 0.02\n'gpu.cycles' = 0.01\n");  // the last holds
  EXPECT_EQ(folder_.run("regress d").code, 1);
  write_case("a", "statistics = ['gpu.l1.*', 'gpu.l2.*']\n");
  EXPECT_EQ(folder_.run("regress d").code, 0);
  // A statistic on record that is gone differs; one that is not on record is named.
  replace_record("gpu.l1.accesses", "");
  const Outcome grown = folder_.run("regress d");
  EXPECT_EQ(grown.code, 0);
  EXPECT_THAT(grown.out, HasSubstr("1 statistics are not on record: gpu.l1.accesses"));
  folder_.write("d/records.tsv", folder_.read("d/records.tsv") + "gpu.l1.gone\t1\n");
  const Outcome gone = folder_.run("regress d");
  EXPECT_EQ(gone.code, 1);
  EXPECT_THAT(gone.out, HasSubstr("gpu.l1.gone 1 -> missing"));
}

TEST_F(Regress, BadInputIsOneLineAndSpoilsNoOtherCase) {
  const auto expect_refused = [&](const std::string& arguments, const std::string& text) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  expect_refused("regress none", "none: is no folder");
  expect_refused("regress d", "d: holds no case (NAME.case.toml)");
  write_case("a");
  expect_refused("regress d", "records.tsv: case 'a': there is no record yet, and the case was not run; to make one: ");
  expect_refused("regress d --update", "--update: needs --reason TEXT");
  expect_refused("regress d --reason x", "--reason: needs --update");
  expect_refused("regress d --cases b", "d: b: is the name of no case");
  ASSERT_EQ(record().code, 0);
  for (const char* lost : {"d/records.tsv", "d/a.case.toml", "t.grtx"}) {
    expect_refused(std::string("regress d --junit ") + lost, "is an input, too, and would be lost");
  }
  const struct {
    const char *more, *text;
  } cases[] = {{"machin = 'paper'\n", "line 3: unknown key 'machin', the nearest is 'machine'"},
               {"mode = 'fst'\n", "line 3: mode: unknown 'fst', the nearest is 'cycle'"},
               {"share = 0.5\n", "line 3: needs mode = \"windows\""},
               {"mode = 'model'\n", "line 3: mode: unknown 'model', the nearest is"},
               {"mode = 'windows'\nshare = 2.0\n", "line 4: share: must be a number, 0 to 1"},
               {"mode = 'windows'\nshare = 0\n", "line 4: share: must be above 0"},
               {"mode = 'windows'\nsample_model = 'calls'\n", "line 4: unknown key 'sample_model', the nearest is"},
               {"mode = 'sampled'\n", "line 3: mode 'sampled' is gone: use cycle; of whole frames, windows"},
               {"mode = 'fast'\n", "line 3: mode 'fast' is gone: use cycle; of whole frames, windows"},
               {"statistics = []\n", "line 3: statistics: the list is empty"},
               {"[tolerance]\ngpu.cycles = 0.1\n", "tolerance: a pattern is a text"},
               {"[tolerance]\n'gpu.cycles' = -1\n", "line 4: tolerance: gpu.cycles: must be a number"},
               {"x = = 1\n", "line 3: "},
               {"machine = 'papr'\n", "papr: is none of"},
               {"config = 'none.toml'\n", "none.toml: "},
               {"statistics = ['gpu.nothing']\n", "statistics: name none that this simulation has"},
               {"set = ['l2.latenzy=1']\n", "b.case.toml: line 3: set: l2.latenzy: unknown key"},
               {"set = [\n'l2.latency=200',\n'l2.latency=-1']\n", "b.case.toml: line 5: set: l2.latency: must be"}};
  for (const auto& c : cases) {
    const std::string more = c.more;
    if (more.starts_with("set")) {
      folder_.write("d/b.case.toml", "trace = '../t.grtx'\n\n" + more);
    } else {
      write_case("b", more);
    }
    expect_refused("regress d --update --reason x", c.text);
  }
  // What only shows when a case is run leaves the others alone.
  write_case("b", "", "../none.grtx");
  const Outcome outcome = folder_.run("regress d --update --reason x --junit out.xml");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.out, HasSubstr("2 cases: 1 equal, 0 differ, 0 recorded, 1 refused"));
  EXPECT_THAT(folder_.read("out.xml"), HasSubstr("<error message=\"none.grtx: cannot be read"));
  for (const char* table : {"", "gpu.cycles\t1\n", "statistic\ta\ngpu.cycles\t1", "statistic\ta\ngpu.cycles\n",
                            "statistic\ta\ngpu.cycles\tone\n", "statistic\ta\tb\n"}) {
    folder_.write("d/records.tsv", table);
    expect_refused("regress d --cases a", "records.tsv: ");
  }
}

// It simulated each case before it said that there was nothing to compare with, and named two options of no command.
TEST_F(Regress, TheFirstCallOfAFolderRunsNoCase) {
  write_case("a", "", "../none.grtx");  // that would fail, if it were run
  const Outcome first = folder_.run("regress d --cases 'a*'");
  EXPECT_EQ(first.code, 2);
  EXPECT_EQ(first.err,
            "grtx: regress: a: d/records.tsv: case 'a': there is no record yet, and the case was not run; to make one: "
            "grtx regress d --cases 'a*' --update --reason TEXT\n");
  write_case("a");
  EXPECT_EQ(folder_.run("regress d --cases 'a*' --update --reason TEXT").code, 0);
  EXPECT_EQ(folder_.run("regress d --cases 'a*'").code, 0);
}

TEST_F(Regress, ANameWithATabOrALineBreakIsRefused) {
  for (const char* name : {"a\tb", "a\nb"}) {
    write_case(name);
    const Outcome outcome = record();
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("a case's name must have no tab or line break"));
    EXPECT_FALSE(folder_.has("d/records.tsv"));
    std::filesystem::remove(folder_.path(std::string("d/") + name + ".case.toml"));
  }
}

TEST_F(Regress, AnEmptyRecordIsRefused) {
  write_case("a");
  ASSERT_EQ(record().code, 0);
  std::string table;
  std::istringstream lines(folder_.read("d/records.tsv"));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("gpu.")) table += line + '\n';
  }
  folder_.write("d/records.tsv", table);
  const Outcome refused = folder_.run("regress d");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("records.tsv: a: holds none of the case's statistics"));
  EXPECT_EQ(record().code, 0);
  EXPECT_EQ(folder_.run("regress d").code, 0);
}

TEST_F(Regress, AMistypedToleranceIsRefused) {
  write_case("a");
  ASSERT_EQ(record().code, 0);
  write_case("a", "statistics = ['gpu.l1.*']\n[tolerance]\n'gpu.l1.*' = 0.1\n'gpu.l3.*' = 0.1\n");
  EXPECT_THAT(folder_.run("regress d").err,
              HasSubstr("a.case.toml: line 6: tolerance: 'gpu.l3.*' fits none that is compared"));
  write_case("a", "statistics = ['gpu.l1.*']\n[tolerance]\n'gpu.l2.*' = 0.1\n");  // there, and not compared
  EXPECT_EQ(folder_.run("regress d").code, 2);
  write_case("a", "statistics = ['gpu.l1.*', 'gpu.l3.*']\n");
  EXPECT_THAT(folder_.run("regress d").err, HasSubstr("statistics: 'gpu.l3.*' is the name of none"));
}

TEST_F(Regress, UnitsFromOutsideTheTreeAreRunByTheLibrary) {
  write_case("a");
  ASSERT_EQ(record().code, 0);
  const auto own = [&](const std::string& more) {
    const std::string command =
        "cd '" + folder_.path("") + "' && '" + grtx::paths::own_regression() + "' d " + more + " >.own 2>&1";
    const int status = std::system(command.c_str());
    return Outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder_.read(".own"), ""};
  };
  const Outcome differs = own("");
  EXPECT_EQ(differs.code, 1);
  EXPECT_THAT(differs.out, AllOf(HasSubstr("a: differs"), HasSubstr("moved first: "), HasSubstr(", L2 ")));
  EXPECT_THAT(differs.out, Not(HasSubstr("configuration ")));  // the unit itself is another
  EXPECT_EQ(own("--update 'L2 slices of mine'").code, 0);
  EXPECT_EQ(own("").code, 0);
  EXPECT_EQ(folder_.run("regress d").code, 1);
  write_case("b", "mode = 'windows'\n");
  const Outcome windows = own("--update 'b, too'");
  EXPECT_EQ(windows.code, 2);
  EXPECT_THAT(windows.out, HasSubstr("own units run in cycle mode only"));
}

}  // namespace
}  // namespace grtx::e2e
