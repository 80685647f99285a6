// SPDX-License-Identifier: Apache-2.0
// Hints that help: what people type in place of a machine, a plan's key or a number, answered in the program's words.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

class CliHints : public ::testing::Test {
 protected:
  std::string refused(const std::string& arguments) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << arguments << ": " << outcome.err;
    return outcome.err;
  }
  Folder folder_;
};

TEST_F(CliHints, AProductIsTheMachineThatIsLikeIt) {
  EXPECT_THAT(refused("machine rtx4090"), EndsWith("did you mean ada, which is like an RTX 4090?\n"));
  EXPECT_THAT(refused("machine 'RTX 5090'"), EndsWith("did you mean blackwell, which is like an RTX 5090?\n"));
  EXPECT_THAT(refused("cost --machine turing"), HasSubstr("did you mean rtx2060, which is like an RTX 2060?"));
  EXPECT_THAT(refused("machine papr"), HasSubstr("the nearest is paper"));
}

TEST_F(CliHints, AMachinesFileWithoutItsEnding) {
  folder_.write("mine.toml", "[l1]\nbytes = 65536\n");
  folder_.write("plain", "[l1]\nbytes = 65536\n");
  EXPECT_THAT(refused("machine mine"), EndsWith("did you mean the file mine.toml?\n"));
  EXPECT_THAT(refused("machine ./mine"), EndsWith("did you mean the file ./mine.toml?\n"));
  EXPECT_THAT(refused("machine plain"), EndsWith("it is a file, but a machine's file ends in .toml\n"));
  EXPECT_EQ(folder_.run("machine mine.toml").code, 0);
}

// Any machine in a plan was refused.
TEST_F(CliHints, AMachineInAPlanStandsAtItsTopOrIsVaried) {
  const std::string scene = "[[scene]]\npreset = \"object\"\ncount = 50\nwidth = 8\nheight = 8\n";
  const std::string line = "machine = \"ada\"\n";
  for (const std::string& plan : {scene + line, scene + "[set]\n" + line, scene + "[tracer]\n" + line}) {
    folder_.write("plan.toml", plan);
    EXPECT_THAT(refused("sweep plan.toml -o s.sqlite"), HasSubstr("machine: stands at the top of a plan")) << plan;
  }
  const auto listed = [&](const std::string& plan, const std::string& more = "") {
    folder_.write("plan.toml", plan);
    const Outcome outcome = folder_.run("sweep plan.toml --list " + more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_THAT(listed(line + scene), HasSubstr(" new      ada cycle "));
  EXPECT_THAT(listed(line + scene, "--machine rdna4"), HasSubstr(" new      rdna4 cycle "));
  folder_.write("half.toml", "[l2]\nbytes = 2097152\n");
  EXPECT_THAT(listed(scene + "[grid]\nmachine = [\"paper\", \"paper-charged\", \"rdna4\", \"half.toml\"]\n"),
              AllOf(HasSubstr(" paper cycle "), HasSubstr(" paper-charged cycle "), HasSubstr(" rdna4 cycle "),
                    HasSubstr(" half cycle "), HasSubstr("4 points, 2 traces")));  // two orders of children
  for (const auto& [machines, rule] :
       {std::pair("[\"adda\"]", "plan.toml: line 7: machine: --machine"),
        std::pair("[\"half.toml\", \"./half.toml\"]", "plan.toml: line 7: machine: two are called 'half'"),
        std::pair("[8]", "plan.toml: line 7: machine: must be a name, or a file .toml")}) {
    folder_.write("plan.toml", scene + "[grid]\nmachine = " + machines + "\n");
    EXPECT_THAT(refused("sweep plan.toml -o s.sqlite"), HasSubstr(rule));
  }
  folder_.write("own.toml", line);
  EXPECT_THAT(refused("machine own.toml"), HasSubstr("--machine names it, or the file's include = \"FILE.toml\""));
}

TEST_F(CliHints, AFileThatIsThereButClosedSaysSo) {
  folder_.write("closed.ply", "ply");
  std::filesystem::permissions(folder_.path("closed.ply"), std::filesystem::perms::none);
  // root reads what it likes, unless it gives that up.
  const std::string as_user = ::getuid() == 0 ? "setpriv --bounding-set=-dac_override,-dac_read_search" : "";
  const Outcome outcome = folder_.run("info closed.ply", as_user);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err, "grtx: closed.ply: cannot be read: Permission denied\n");
  EXPECT_EQ(refused("info missing.ply"), "grtx: missing.ply: No such file or directory\n");
}

TEST_F(CliHints, NumbersAreAnsweredWithTheOptionAndItsRule) {
  const std::string view = "trace --scene s.ply --cameras c.json -o t.grtx ";
  const std::pair<std::string, std::string> cases[] = {
      {view + "--view -1", "grtx: trace: --view: must be a whole number from 0 on, not -1\n"},
      {"ray t.grtx -o p.html --pixel 5", "grtx: ray: --pixel: must be X,Y: 2 values, not 1\n"},
      {"ray t.grtx -o p.html --pixel a,b", "grtx: ray: --pixel: must be X,Y, not a,b\n"},
      {"synth -o x.ply --count 1e6", "grtx: synth: --count: must be a whole number from 0 on, as 1000000, not 1e6\n"},
      {"synth -o x.ply --count 12.5", "grtx: synth: --count: must be a whole number from 0 on, not 12.5\n"},
      {"synth -o x.ply --seed -5", "grtx: synth: --seed: must be a whole number from 0 on, not -5\n"},
      {"cost --node 1x", "grtx: cost: --node: must be a whole number from 0 on, not 1x\n"},
      {"sim t.grtx --watchdog 0", "grtx: sim: --watchdog: must be above 0, not 0\n"},
      {view + "--k 4 --k 5", "grtx: trace: --k: is given 2 times: give it once\n"},
      {"synth -o", "grtx: synth: --output: needs a value: OUTPUT\n"},
  };
  for (const auto& [arguments, line] : cases) EXPECT_EQ(refused(arguments), line) << arguments;
  EXPECT_THAT(refused("run --scene s.ply --cameras c.json -o out --designs grtxx"), HasSubstr("the nearest is 'grtx'"));
}

}  // namespace
}  // namespace grtx::e2e
