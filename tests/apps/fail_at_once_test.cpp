// SPDX-License-Identifier: Apache-2.0
// What cannot work is refused before a scene is read or a structure built: outputs, modes, options. A refused run
// leaves no folder. The scene of these commands is garbage: an error that is not about it came first.
#include <gmock/gmock.h>

#include "apps/program.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::e2e {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

class FailAtOnce : public ::testing::Test {
 protected:
  FailAtOnce() {
    folder_.write("s.ply", "not a scene\n");
    folder_.write("c.json", "not cameras\n");
    sim::test::write_tiny_trace(folder_.path("t.grtx"));
  }
  void refused(const std::string& arguments, const std::string& said) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << arguments << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(said)) << arguments;
    EXPECT_THAT(outcome.err, Not(HasSubstr("s.ply"))) << arguments;
  }
  Folder folder_;
  const std::string view_ = " --scene s.ply --cameras c.json ";
};

TEST_F(FailAtOnce, AnOutputInAFolderThatIsNotThere) {
  for (const std::string& arguments :
       {"trace" + view_ + "-o no_such_folder/x", "trace" + view_ + "-o t2.grtx --image no_such_folder/x.png",
        "trace" + view_ + "-o t2.grtx --stats no_such_folder/x", "reference" + view_ + "-o no_such_folder/x.png",
        "trace" + view_ + "-o t2.grtx --heatmap visits=no_such_folder/x.png",
        std::string("synth -o no_such_folder/x.ply"), std::string("convert s.ply no_such_folder/x.ply"),
        std::string("sim t.grtx --stats no_such_folder/x"), std::string("sim t.grtx --vcd no_such_folder/x"),
        std::string("sim t.grtx --timeline no_such_folder/x"), std::string("sim t.grtx --save-state no_such_folder/x"),
        std::string("cost --csv no_such_folder/x"), std::string("report t.grtx -o no_such_folder/x"),
        std::string("ray t.grtx --pixel 0,0 -o no_such_folder/x"), std::string("regress . --junit no_such_folder/x"),
        std::string("sweep c.json -o no_such_folder/x"), std::string("search c.json -o no_such_folder/x")}) {
    refused(arguments, "no_such_folder");
  }
  refused("run" + view_ + "-o c.json/out", "cannot be");
}

TEST_F(FailAtOnce, AnImageWhoseNameNobodyCanWrite) {
  refused("trace" + view_ + "--no-trace --image x.gif", "image files end in .png, .exr or .pfm");
  refused("reference" + view_ + "-o x.gif", "image files end in .png, .exr or .pfm");
}

TEST_F(FailAtOnce, OptionsThatDoNotGoTogether) {
  refused("trace" + view_ + "-o x.grtx --glass 0,0,0,1", "needs --secondary glass or both");
  refused("run" + view_ + "-o out --glass 0,0,0,1", "needs --secondary glass or both");
  refused("run" + view_ + "-o out --mode windows --views 0:1", "--views: needs --mode cycle");
  EXPECT_FALSE(folder_.has("out"));
  EXPECT_FALSE(folder_.has("x.grtx"));
}

TEST_F(FailAtOnce, ARunThatIsRefusedLeavesNoFolder) {
  const Outcome outcome = folder_.run("run" + view_ + "-o deep/er/out");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_FALSE(folder_.has("deep"));
  std::filesystem::create_directory(folder_.path("mine"));
  folder_.write("mine/note.txt", "kept");
  EXPECT_EQ(folder_.run("run" + view_ + "-o mine").code, 2);
  EXPECT_TRUE(folder_.has("mine/note.txt"));
}

TEST_F(FailAtOnce, ASweepWithoutResultsSaysWhyInItsLastLine) {
  ASSERT_EQ(folder_.run("synth --preset object --count 50 -o g.ply --quiet").code, 0);
  folder_.write("plan.toml",
                "[[scene]]\nfile = \"g.ply\"\ncameras = \"g.cameras.json\"\nwidth = 8\nheight = 8\n"
                "[grid]\n\"l1.bytes\" = [1024]\n");
  const Outcome outcome = folder_.run("sweep plan.toml -o s.sqlite --jobs 1");
  EXPECT_EQ(outcome.code, 1);
  const std::string last = outcome.err.substr(outcome.err.rfind("grtx: sweep:"));
  EXPECT_THAT(last, HasSubstr("1 of 1 points have no result: configuration: l1.bytes"));
  EXPECT_THAT(last, EndsWith("\n"));
  EXPECT_FALSE(folder_.has("traces")) << "nothing was traced";
}

}  // namespace
}  // namespace grtx::e2e
