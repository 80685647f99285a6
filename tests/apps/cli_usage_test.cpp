// SPDX-License-Identifier: Apache-2.0
// The command line: help for every command with a default for every option, and one line with exit code 2 for mistakes.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <utility>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string> kCommands = {"synth",       "info",       "trace", "reference", "compare",
                                            "trace-check", "trace-dump", "ray",   "sim",       "stalls",
                                            "cost",        "run",        "sweep", "machine"};

/// "=3" (CLI11 2.3) or " [3]" (2.4, which writes ranges as "in [1 - 4]"), or words of ours.
bool states_default(const std::string& text) {
  for (std::size_t at = text.find(" ["); at != std::string::npos; at = text.find(" [", at + 1)) {
    if (at < 2 || text.compare(at - 2, 2, "in") != 0) return true;
  }
  return text.find('=') != std::string::npos || text.find("(default:") != std::string::npos ||
         text.find("(no default)") != std::string::npos;
}

TEST(CliUsage, EveryCommandHasHelpWithADefaultForEveryOption) {
  const Folder folder;
  for (const std::string& command : kCommands) {
    const Outcome help = folder.run(command + (command == "run" ? " --help-all" : " --help"));
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_EQ(help.err, "") << command;
    // Entries of the list of options; a description may continue on the next line.
    std::vector<std::string> entries;
    std::istringstream lines(help.out.substr(std::min(help.out.size(), help.out.find("Options:"))));
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("  -")) {
        entries.push_back(line);
      } else if (line.starts_with("          ") && !entries.empty()) {
        entries.back() += line;
      }
    }
    unsigned found = 0;
    for (const std::string& text : entries) {
      ++found;
      if (text.starts_with("  -h,--help")) continue;
      EXPECT_TRUE(states_default(text)) << command << ": no default in: " << text;
    }
    EXPECT_GE(found, 2U) << command;
  }
}

// 70 options stood in one row.
TEST(CliUsage, OptionsOfRunStandInGroupsAndThoseForExpertsBehindHelpAll) {
  const Folder folder;
  const Outcome help = folder.run("run --help"), all = folder.run("run --help-all");
  std::size_t at = 0;
  for (const std::string group : {"Scene", "View", "Structure", "Rounds", "Machine", "Output"}) {
    const std::size_t next = help.out.find("\n" + group + ":\n");
    ASSERT_NE(next, std::string::npos) << group;
    EXPECT_GT(next, at) << group;
    at = next;
  }
  EXPECT_LT(std::count(help.out.begin(), help.out.end(), '\n'), 90);
  EXPECT_THAT(help.out, AllOf(HasSubstr(" more for experts: --help-all\n"), Not(HasSubstr("--response-precision"))));
  EXPECT_THAT(all.out, AllOf(HasSubstr("\nExpert:\n"), HasSubstr("--response-precision"), HasSubstr("--machine")));
}

TEST(CliUsage, VersionIsPrinted) {
  const Folder folder;
  const Outcome outcome = folder.run("--version");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, ::testing::MatchesRegex("grtx [0-9]+\\.[0-9]+\\.[0-9]+(-dev)?, model version [0-9]+, "
                                                   "commit ([0-9a-f]+(-dirty)?|unknown), [A-Za-z]+ [0-9.]+\n"));
  const std::string asked = "git -C '" + paths::source_dir() + "' rev-parse HEAD >/dev/null 2>&1";
  if (std::filesystem::exists(paths::source_dir() + "/.git") && std::system(asked.c_str()) == 0) {
    EXPECT_EQ(outcome.out.find("commit unknown"), std::string::npos) << outcome.out;
  }
}

TEST(CliUsage, WithoutACommandTheStepsOfAFirstSessionGoToStderr) {
  const Folder folder;
  const Outcome outcome = folder.run("");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.out, "");
  for (const char* step :
       {"1. ", "grtx synth", "2. ", "grtx info", "3. ", "grtx trace", "4. ", "grtx run", "5. ", "grtx sim"}) {
    EXPECT_THAT(outcome.err, HasSubstr(step));
  }
  std::istringstream lines(outcome.err);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

// run printed its table all the same.
TEST(CliUsage, AQuietCommandWhoseResultIsAFilePrintsNothing) {
  const Folder folder;
  folder.write("m.csv", "scene,design,over,value\ns,grtx,baseline,2\n");
  folder.write("p.toml",
               "designs = [\"baseline\", \"grtx\"]\n[[scene]]\nname = \"s\"\nfile = \"s.ply\"\n"
               "cameras = \"s.cameras.json\"\nview = 0\nwidth = 8\nheight = 4\n[set]\ngpu.sms = 1\n"
               "[grid]\nrt.warp_buffer.entries = [4]\n");
  const std::string view = " --scene s.ply --cameras s.cameras.json --view 0 --width 8 --height 4 ";
  for (const std::string& command :
       {std::string("synth --preset object --count 200 --seed 1 -o s.ply"), std::string("convert s.ply c.ply"),
        "trace" + view + "-o t.grtx --image i.png", "reference" + view + "-o r.pfm", std::string("trace-check t.grtx"),
        std::string("ray t.grtx --pixel 1,1 -o ray.html"), std::string("sim t.grtx --set gpu.sms=1 --stats s.json"),
        "run" + view + "--set gpu.sms=1 -o out", std::string("report out/results.json -o report.html"),
        std::string("sweep p.toml -o s.sqlite"), std::string("correlate m.csv s.sqlite -o c.html")}) {
    const Outcome quiet = folder.run(command + " --quiet");
    EXPECT_EQ(quiet.code, 0) << command << ": " << quiet.err;
    EXPECT_EQ(quiet.out, "") << command;
  }
  EXPECT_NE(folder.run("info s.ply --quiet").out, "");  // what it prints is the result
}

TEST(CliUsage, MistakesNameTheNearestKnownName) {
  struct Case {
    const char* arguments;
    std::vector<const char*> parts;
  };
  const std::vector<Case> cases = {
      {"simm x.grtx", {"unknown command simm", "sim"}},
      {"traces", {"unknown command traces", "trace"}},
      {"--quiet sim x.grtx", {"sim", "options come after the command", "--quiet"}},
      {"sim x.grtx --confg a.toml", {"sim", "unknown option --confg", "--config"}},
      {"sim x.grtx --stat=a.json", {"unknown option --stat", "--stats"}},
      {"sim x.grtx --mode cycles", {"--mode", "unknown value 'cycles'", "'cycle'"}},
      {"trace --accel tri2 --scene a --cameras b", {"--accel", "unknown value 'tri2'", "'tri20'"}},
      {"reference --proxy cube --scene a --cameras b -o c.pfm", {"--proxy", "unknown value 'cube'"}},
      {"synth --preset hal -o a.ply", {"--preset", "unknown value 'hal'", "'hall'"}},
      {"synth --count many -o a.ply", {"--count"}},
      {"synth --count -5 -o a.ply", {"--count"}},
      {"compare a.pfm", {"B", "required"}},
      {"compare a.pfm b.pfm c.pfm", {"compare", "unexpected argument c.pfm"}},
      {"sim", {"sim", "trace file"}},
      {"sim x.grtx --set l1.latncy=3", {"--set", "l1.latncy", "'l1.latency'"}},
      {"sim x.grtx --vcd a.vcd --vcd-window 9:3", {"--vcd-window", "9:3"}},
      {"sim x.grtx --config", {"--config"}},
      {"trace --tracing singl --scene a --cameras b", {"--tracing", "unknown value 'singl'", "'single'"}},
      {"trace --tracing single --checkpoint on --no-trace --scene a --cameras b", {"--tracing", "single", "multi"}},
      {"trace --tracing closest --checkpoint on --no-trace --scene a --cameras b", {"--tracing", "closest", "multi"}},
      {"trace --tracing tiles --no-trace --scene a --cameras b",
       {"--tracing", "'tiles' is gone: --tracing single makes the same image"}},
      {"trace --any-hit late --no-trace --scene a --cameras b", {"--any-hit", "unknown value 'late'"}},
      {"trace --any-hit delayed --checkpoint on --no-trace --scene a --cameras b",
       {"--any-hit", "delayed", "checkpointing off"}},
      {"trace --any-hit delayed --tracing single --no-trace --scene a --cameras b",
       {"--any-hit", "delayed", "--tracing multi"}},
      {"run --any-hit delayed --designs hw --scene a --cameras b -o c", {"--any-hit", "delayed", "checkpointing off"}},
      {"run --ert-check round --sort-key peak --scene a --cameras b -o c", {"--ert-check", "round", "needs --k"}},
      {"trace --ahead 0 --no-trace --scene a --cameras b", {"--ahead", "0"}},
      {"trace --ahead 4 --checkpoint on --accel tri20 --no-trace --scene a --cameras b",
       {"--ahead", "4", "checkpointing off"}},
      {"trace --ahead 4 --accel tlas-sphere --no-trace --scene a --cameras b", {"--ahead", "4", "one level"}},
      {"trace --ahead 4 --accel tri20 --any-hit delayed --no-trace --scene a --cameras b",
       {"--ahead", "4", "--any-hit immediate"}},
      {"trace --ahead 4 --accel tri20 --tracing single --no-trace --scene a --cameras b",
       {"--ahead", "4", "--tracing multi"}},
      {"trace --colour ray --no-trace --scene a --cameras b", {"--colour", "unknown value 'ray'"}},
      {"trace --colour frame --no-trace --scene a --cameras b", {"--colour", "frame", "--sh-dir centre"}},
      {"trace --colour frame --sh-dir centre --secondary glass --no-trace --scene a --cameras b",
       {"--colour", "frame", "--secondary none"}},
      {"trace --opacity-bound yes --no-trace --scene a --cameras b", {"--opacity-bound", "unknown value 'yes'"}},
      {"trace --opacity-bound on --ert-check round --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "--ert-check hit"}},
      {"trace --opacity-bound on --any-hit delayed --accel tri20 --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "--any-hit immediate"}},
      {"trace --opacity-bound on --tracing list --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "--tracing multi"}},
      {"trace --opacity-bound on --tracing single --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "--tracing multi"}},
      {"trace --opacity-bound on --tracing closest --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "closest", "multi"}},
      {"trace --opacity-bound on --ert 0 --no-trace --scene a --cameras b", {"--opacity-bound", "on", "--ert"}},
      {"trace --opacity-bound on --resume strict --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "--resume exact"}},
      {"trace --opacity-bound on --triangle-test world --accel tri20 --no-trace --scene a --cameras b",
       {"--opacity-bound", "on", "--triangle-test canonical"}},
      {"run --opacity-bound on --ert 0 --scene a --cameras b -o c", {"--opacity-bound", "on", "--ert"}},
      {"trace --ert-check never --no-trace --scene a --cameras b", {"--ert-check", "unknown value 'never'"}},
      {"trace --ert-check round --tracing list --no-trace --scene a --cameras b",
       {"--ert-check", "round", "--tracing list"}},
      {"trace --triangle-test world --accel ellipsoid --no-trace --scene a --cameras b",
       {"--triangle-test", "triangles"}},
      {"trace --triangle-test world --sort-key peak --no-trace --scene a --cameras b",
       {"--triangle-test", "--sort-key entry"}},
      {"run --tracing single --designs grtx --scene a --cameras b -o c", {"--tracing", "single", "multi"}},
      {"run --triangle-test world --scene a --cameras b -o c", {"--triangle-test", "identical"}},
      {"reference --inside count --scene a --cameras b -o c.pfm", {"--inside count", "sphere"}}};
  for (const Case& c : cases) {
    const Folder folder;
    const Outcome outcome = folder.run(c.arguments);
    EXPECT_EQ(outcome.code, 2) << c.arguments;
    EXPECT_EQ(outcome.out, "") << c.arguments;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << c.arguments << ": " << outcome.err;
    for (const char* part : c.parts) EXPECT_THAT(outcome.err, HasSubstr(part)) << c.arguments;
  }
}

}  // namespace
}  // namespace grtx::e2e
