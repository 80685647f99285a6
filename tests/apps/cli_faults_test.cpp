// SPDX-License-Identifier: Apache-2.0
// What has gone wrong once.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <set>

#include "apps/program.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_rows.h"
#include "sweep_database.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

class CliFaults : public ::testing::Test {
 protected:
  void make_scene() {
    ASSERT_EQ(folder_.run("synth --preset object --count 300 --seed 1 --quiet -o s.ply").code, 0);
    ASSERT_EQ(folder_.run(trace_ + "-o t.grtx --quiet").code, 0);
  }
  void expect_refused(const std::string& arguments, const std::string& text) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.err;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << arguments << ": " << outcome.err;
    EXPECT_LT(outcome.err.size(), 1200u) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
  }
  /// Exit code of a shell's line in the folder, whose redirections are its own.
  int shell(const std::string& line) const {
    const std::string start = "cd '" + folder_.path("") + "'; grtx() { '" + grtx::paths::program() + "' \"$@\"; }; ";
    return WEXITSTATUS(std::system((start + line).c_str()));
  }

  Folder folder_;
  const std::string trace_ =
      "trace --scene s.ply --cameras s.cameras.json --width 8 --height 8 --accel tlas-tri20 --checkpoint on ";
};

TEST_F(CliFaults, NoProgressTextIsWrittenIntoTheTraceWhenStderrIsClosed) {
  make_scene();
  const std::string expected = folder_.read("t.grtx");
  for (const char* closed : {"2>&-", "1>&-", "0<&-", "0<&- 1>&- 2>&-"}) {
    std::filesystem::remove(folder_.path("c.grtx"));
    // The shell of run() redirects after the command; a shell of its own closes what the program gets.
    const std::string command =
        "cd '" + folder_.path("") + "' && '" + grtx::paths::program() + "' " + trace_ + "-o c.grtx " + closed;
    // The summary goes to stdout, and its loss is an error; the trace is whole all the same.
    const int code = std::string(closed).find("1>&-") == std::string::npos ? 0 : 2;
    EXPECT_EQ(WEXITSTATUS(std::system(("sh -c \"" + command + "\"").c_str())), code) << closed;
    EXPECT_EQ(folder_.read("c.grtx"), expected) << closed;
  }
}

TEST_F(CliFaults, ADeviceOrALinkIsNotReplacedByAFile) {
  make_scene();
  std::filesystem::create_directory(folder_.path("elsewhere"));
  std::filesystem::create_symlink("elsewhere/real.grtx", folder_.path("link.grtx"));
  EXPECT_EQ(folder_.run(trace_ + "-o link.grtx --quiet").code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(folder_.path("link.grtx")));
  EXPECT_EQ(folder_.read("elsewhere/real.grtx"), folder_.read("t.grtx"));
  EXPECT_EQ(folder_.run(trace_ + "-o /dev/null --stats /dev/null --quiet").code, 0);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  expect_refused(trace_ + "-o /dev/full --quiet", "/dev/full: ");
}

TEST_F(CliFaults, JsonThatIsNestedTooDeeplyIsRefused) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  folder_.write("s.gltf", R"({"asset": {}, "scenes": [{"nodes": )" + deep + "}]}");
  folder_.write("meta.json", R"({"means": )" + deep + "}");
  folder_.write("cameras.json", deep);
  folder_.write("stats.json", R"({"schema": "grtx.stats/1", "config": {"a": )" + deep +
                                  R"(}, "stats": {"a.stall.b": )" + deep + "}}");
  folder_.write("results.json", R"({"schema": "grtx.run/1", "violations": )" + deep + "}");
  testing_sweep::make_points(folder_.path("d.sqlite"), nlohmann::json::parse(R"([{"id": 1}])"));
  testing_sweep::execute(folder_.path("d.sqlite"), "UPDATE point SET coordinates = '" + deep + "'");
  const std::string rule = "must be nested at most 128 levels deep, as JSON";
  for (const char* arguments : {"info s.gltf", "info meta.json", "stalls stats.json", "cost --stats stats.json",
                                "report results.json -o r.html", "report stats.json -o r.html",
                                "report d.sqlite -o r.html", "trace --scene s.gltf --cameras cameras.json -o t.grtx"}) {
    expect_refused(arguments, rule);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.path("r.html")));
}

TEST_F(CliFaults, ANameInLatin1IsEscapedInJson) {
  make_scene();
  const std::string name =
      "K\xfc"
      "che";
  std::filesystem::create_directory(folder_.path(name));
  std::filesystem::copy(folder_.path("s.ply"), folder_.path(name + ".ply"));
  const std::string trace = "trace --scene " + name + ".ply --cameras s.cameras.json --width 8 --height 8 ";
  const Outcome traced = folder_.run(trace + "-o a.grtx --stats a.json --quiet");
  EXPECT_EQ(traced.code, 0) << traced.err;
  EXPECT_THAT(folder_.read("a.json"), HasSubstr(R"(K\\xfcche.ply)"));
  for (const std::string& arguments :
       {"info " + name + ".ply --json", "sim a.grtx --stats " + name + "/s.json --quiet",
        std::string("trace-dump a.grtx --json"),
        "run --scene " + name + ".ply --cameras s.cameras.json --width 8 --height 8 -o " + name + "/run --quiet --json",
        "report " + name + "/run/results.json -o " + name + "/r.html --json",
        "convert " + name + ".ply " + name + ".spz --json"}) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 0) << arguments << ": " << outcome.err;
    EXPECT_EQ(outcome.out.find('\xfc'), std::string::npos) << arguments;
  }
  folder_.write("p.toml", "[[scene]]\nfile = \"s.ply\"\ncameras = \"s.cameras.json\"\nwidth = 8\nheight = 8\n");
  expect_refused("sweep p.toml -o " + name + "/d.sqlite --quiet", "must be UTF-8: it is handed on as JSON");
}

TEST_F(CliFaults, CostRefusesOptionsThatAnotherLeavesWithoutMeaning) {
  for (const std::string option : {"--items", "--depth 2", "--checkpoint-entries 9", "--eviction-entries 9"}) {
    expect_refused("cost --stats s.json " + option,
                   option.substr(0, option.find(' ')) + ": is of a machine's cost, but with --stats");
  }
  expect_refused("cost --stats s.json --layout compact", "--layout: is what the run of --stats had");
  expect_refused("cost --dram-pj-per-bit 6", "--dram-pj-per-bit: needs --stats");
  expect_refused("cost --coefficients --node 7", "--node: means nothing beside --coefficients");
}

TEST_F(CliFaults, NaNPassesNoGate) {
  make_scene();
  expect_refused(trace_ + "--no-trace --ert nan", "--ert: must be a number, not nan");
  expect_refused(trace_ + "--no-trace --fov-scale NAN", "--fov-scale: must be a number, not NAN");
  expect_refused("cost --utilisation nan", "--utilisation: must be a number, not nan");
  frontend::Image black(4, 4), undefined(4, 4);
  undefined.at(1, 1).y = std::numeric_limits<float>::quiet_NaN();
  frontend::write_image(folder_.path("black.pfm"), black);
  frontend::write_image(folder_.path("nan.pfm"), undefined);
  expect_refused("compare black.pfm black.pfm --min-psnr nan", "--min-psnr: must be a number, not nan");
  EXPECT_EQ(folder_.run("compare black.pfm nan.pfm --min-psnr 10").code, 1);
  EXPECT_EQ(folder_.run("compare nan.pfm black.pfm --min-psnr 0").code, 1);
  EXPECT_EQ(folder_.run("compare nan.pfm nan.pfm --min-psnr inf").code, 0);  // identical
}

TEST_F(CliFaults, NoInputIsOverwrittenByAnOutput) {
  make_scene();
  const std::string trace = folder_.read("t.grtx");
  expect_refused("sim t.grtx --stats t.grtx", "is an input, too, and would be lost: TRACE");
  expect_refused("sim t.grtx --stats ./../$(basename $PWD)/t.grtx", "is an input, too");
  std::filesystem::create_symlink("t.grtx", folder_.path("l.grtx"));
  expect_refused("sim t.grtx --vcd l.grtx", "is an input, too");
  expect_refused("sim t.grtx --stats a.json --timeline a.json", "two outputs have one name");
  expect_refused(trace_ + "-o s.ply", "is an input, too");
  expect_refused(trace_ + "--no-trace --image i.png --heatmap visits=i.png", "two outputs have one name");
  EXPECT_EQ(folder_.read("t.grtx"), trace);
}

TEST_F(CliFaults, MemoryContentsBelongToOneTraceOfOneView) {
  make_scene();
  const std::string rule = "--contents: is of one view of one scene, and of the trace that -o writes";
  expect_refused(trace_ + "--no-trace --contents c.grtxmem", rule);
  expect_refused(trace_ + "--views 0,1 -o v.grtx --contents c.grtxmem", rule);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("c.grtxmem")));
  ASSERT_EQ(folder_.run(trace_ + "-o v.grtx --contents c.grtxmem --quiet").code, 0);
  EXPECT_GT(std::filesystem::file_size(folder_.path("c.grtxmem")), 8u * 8 * 16);
}

TEST_F(CliFaults, NothingIsOverwrittenByAnOutputThatFollowsFromAnother) {
  make_scene();
  const std::string trace = folder_.read("t.grtx"), no_trace = trace_ + "--no-trace ";
  const std::string other = "trace --cameras s.cameras.json --width 8 --height 8 --accel tlas-tri20 ";
  const std::string two = "two outputs have one name", lost = "is an input, too, and would be lost";
  folder_.write("w.gtkw", trace);
  folder_.write("w.warp_state.filter", trace);
  folder_.write("x.grtx.partial", folder_.read("s.ply"));
  folder_.write("objects.json", R"([{"file": "s.ply"}])");
  std::filesystem::create_hard_link(folder_.path("t.grtx"), folder_.path("hard.grtx"));
  std::filesystem::create_directory(folder_.path("out"));
  folder_.write("out/results.json", R"([{"file": "../s.ply"}])");
  struct Case {
    std::string arguments, one, other, rule;
  };
  const std::string run = "run --scene s.ply --cameras s.cameras.json --width 8 --height 8 -o out ";
  for (const Case& c :
       {Case{no_trace + "--image d.exr --heatmap visits=d.png", "--image", "--heatmap (writes ", two},
        Case{no_trace + "--image visits.exr --heatmap visits", "--image", "--heatmap (writes ", two},
        Case{no_trace + "--views 0:1 --image i.png --stats i_1.png", "--image (writes ", "--stats", two},
        Case{other + "--no-trace --stats s.ply --scene objects.json", "--stats", "s.ply", lost},
        Case{other + "-o x.grtx --scene x.grtx.partial", "--output", "--scene", lost},
        Case{"sim w.gtkw --vcd w.vcd", "--vcd (writes ", "TRACE", lost},
        Case{"sim w.warp_state.filter --vcd w.vcd", "--vcd (writes ", "TRACE", lost},
        Case{"sim t.grtx --vcd w.vcd --stats w.gtkw", "--stats", "--vcd (writes ", two},
        Case{"sim t.grtx --stats hard.grtx", "--stats", "TRACE", lost},
        Case{run + "--config out/grtx.grtx", "--output (writes ", "--config", lost},
        Case{"run --scene out/results.json --cameras s.cameras.json --width 8 --height 8 -o out", "--output (writes ",
             "--scene", lost}}) {
    SCOPED_TRACE(c.arguments);
    expect_refused(c.arguments, c.one);
    expect_refused(c.arguments, c.other);
    expect_refused(c.arguments, c.rule);
  }
  for (const char* name : {"t.grtx", "w.gtkw", "w.warp_state.filter", "hard.grtx"})
    EXPECT_EQ(folder_.read(name), trace);
  for (const char* name : {"d.exr", "d.png", "i_0.png", "x.grtx", "out/grtx.grtx"})
    EXPECT_FALSE(folder_.has(name)) << name;
}

TEST_F(CliFaults, EveryFileThatACommandWritesIsKnownBefore) {
  make_scene();
  // Whatever appears is asked for again, as the name of another output.
  struct Case {
    std::string arguments, other;
  };
  for (const Case& c : {Case{trace_ + "--no-trace --image a.png --heatmap visits=h.png", "--stats "},
                        Case{trace_ + "--no-trace --image f.png --views 0:1", "--stats "},
                        Case{"sim t.grtx --vcd w.vcd --timeline l.json", "--stats "}}) {
    const auto names = [&] {
      std::set<std::string> all;
      for (const auto& entry : std::filesystem::directory_iterator(folder_.path(""))) {
        all.insert(entry.path().filename().string());
      }
      return all;
    };
    const std::set<std::string> before = names();
    const Outcome outcome = folder_.run(c.arguments + " --quiet");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    unsigned appeared = 0;
    for (const std::string& name : names()) {
      if (before.contains(name)) continue;
      expect_refused(c.arguments + " " + c.other + name, "two outputs have one name");
      ++appeared;
    }
    EXPECT_GE(appeared, 1U) << c.arguments;
  }
}

TEST_F(CliFaults, InputThatIsWrongIsNoInternalError) {
  const std::string head = R"({"schema": "grtx.stats/1", "config": {}, "inputs": {}, "stats": {"gpu.rt.stall.a": )";
  folder_.write("huge.json", head + R"({"value": 1e999}}})");
  folder_.write("text.json", head + R"({"value": "many"}}})");
  folder_.write("unit.json", head + R"({"value": 1, "unit": 7}}})");
  folder_.write("list.json", R"({"schema": "grtx.stats/1", "config": {}, "inputs": {}, "stats": []})");
  folder_.write("number.json", R"({"schema": 5, "config": {}, "inputs": {}, "stats": {}})");
  for (const char* file : {"huge.json", "text.json", "unit.json", "list.json", "number.json"}) {
    expect_refused(std::string("stalls ") + file, file);
    expect_refused(std::string("report -o r.html ") + file, file);
    expect_refused(std::string("cost --stats ") + file, file);
  }
  EXPECT_FALSE(folder_.has("r.html"));
  for (const std::string inputs : {R"("accel": {}, "checkpoint": "on")", R"("accel": "tri20", "checkpoint": 1)",
                                   R"("accel": "tri20", "checkpoint": "on", "levels": 3)"}) {
    folder_.write("inputs.json",
                  R"({"schema": "grtx.stats/1", "config": {}, "inputs": {)" + inputs + R"(}, "stats": {}})");
    expect_refused("cost --stats inputs.json", "must be a text");
  }
  for (const std::string series : {R"({"values": -1})", R"({"unit": "cycles"})", R"({"values": [], "unit": 1})", "7"}) {
    folder_.write("series.json", R"({"schema": "grtx.stats/1", "config": {}, "inputs": {}, "stats": {}, "over_time": )"
                                 R"({"end_of_interval": {"values": []}, "dram": )" +
                                     series + "}}");
    expect_refused("report series.json -o r.html", "over_time.dram");
  }
  EXPECT_FALSE(folder_.has("r.html"));
  const std::string path(5000, 'p');
  expect_refused("stalls " + path, "ppp ... ppp");
  expect_refused("run --scene s.ply --cameras s.cameras.json -o " + path, "ppp ... ppp");
  expect_refused("info " + path + ".ply", "ppp ... ppp");
}

TEST_F(CliFaults, AnEmptySceneHasNoTraceAndIsRefused) {
  ASSERT_EQ(folder_.run("synth --preset stress-empty --quiet -o s.ply").code, 0);
  expect_refused(trace_ + "-o t.grtx", "has no Gaussians, so there is nothing to trace");
  EXPECT_FALSE(folder_.has("t.grtx"));
  EXPECT_EQ(folder_.run(trace_ + "--no-trace --image i.png --quiet").code, 0);
}

TEST_F(CliFaults, AnEmptySceneInRunAdvisesNoOptionThatRunHasNot) {
  ASSERT_EQ(folder_.run("synth --preset stress-empty --quiet -o s.ply").code, 0);
  const std::string run = "run --scene s.ply --cameras s.cameras.json --width 8 --height 8 -o out";
  expect_refused(run, "has no Gaussians");
  EXPECT_EQ(folder_.run(run).err.find("--no-trace"), std::string::npos);
}

TEST_F(CliFaults, ObjectsBeyondFloatRangeAreRefused) {
  make_scene();
  for (const char* place : {"[1e300, 0, 0]", "[0, -1e39, 0]", "[0, 1e19, 0]"}) {
    folder_.write("o.json", std::string(R"([{"file": "s.ply"}, {"file": "s.ply", "translate": )") + place + "}]");
    expect_refused("trace --scene o.json --cameras s.cameras.json --width 8 --height 8 --accel tlas-tri20 --no-trace",
                   "1e18");
  }
  folder_.write("o.json", R"([{"file": "s.ply", "scale": 1e30}])");
  expect_refused("trace --scene o.json --cameras s.cameras.json --width 8 --height 8 --accel tlas-tri20 --no-trace",
                 "1e18");
}

TEST_F(CliFaults, AFifoAsInputIsRefused) {
  make_scene();
  std::filesystem::create_directory(folder_.path("colmap"));
  for (const char* name : {"f.grtx", "f.ply", "f.json", "f.toml", "f.sqlite", "f.pfm", "f.png", "colmap/cameras.bin",
                           "colmap/images.bin"}) {
    ASSERT_EQ(::mkfifo(folder_.path(name).c_str(), 0600), 0);
  }
  for (const char* arguments :
       {"trace-check f.grtx", "trace-dump f.grtx", "sim f.grtx", "sim t.grtx --config f.toml", "info f.ply",
        "stalls f.json", "cost --stats f.json", "report f.json -o r.html", "report f.sqlite -o r.html",
        "compare f.pfm f.pfm", "compare f.png f.png", "sweep f.toml --list", "sweep --compare f.sqlite f.sqlite",
        "search f.toml -o a.sqlite", "trace --scene f.ply --cameras s.cameras.json --no-trace",
        "trace --scene s.ply --cameras f.json --no-trace", "trace --scene s.ply --cameras colmap --no-trace"}) {
    expect_refused(arguments, "is not a regular file");
  }
  // A frame's image, which is looked into for its size only.
  folder_.write("transforms.json", R"({"camera_angle_x": 0.8, "frames": [{"file_path": "f", "transform_matrix": )"
                                   R"([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]})");
  expect_refused("trace --scene s.ply --cameras transforms.json --no-trace", "or its image as PNG");
  EXPECT_EQ(folder_.run("sim /dev/stdin --quiet < t.grtx").code, 0);  // this is a regular file
}

TEST_F(CliFaults, AnErrorLineRepeatsNoMoreThan200CharactersOfInput) {
  make_scene();
  const std::string word(5000, 'w');
  folder_.write("k.toml", word + " = 1\n");
  folder_.write("v.toml", "l1.replacement = '" + word + "'\n");
  for (const std::string& arguments :
       {word, "sim --" + word, "sim t.grtx " + word, "sim " + word, "sim t.grtx --mode " + word,
        "sim t.grtx --set " + word + "=1", "sim t.grtx --set l1.bytes=" + word,
        std::string("sim t.grtx --config k.toml"), std::string("sim t.grtx --config v.toml"), "info " + word,
        trace_ + "--no-trace --k " + word}) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
    EXPECT_EQ(outcome.err.find(std::string(201, 'w')), std::string::npos) << outcome.err;
    EXPECT_LT(outcome.err.size(), 450u) << outcome.err;
  }
}

TEST_F(CliFaults, TextIntoAFullDeviceIsAnError) {
  make_scene();
  for (const char* what : {"--help", "sim --help", "--version", "--list-json", "sim --list-config", "trace-dump t.grtx",
                           "trace-dump t.grtx --json", "info s.ply", "info s.ply --json"}) {
    EXPECT_EQ(shell(std::string("grtx ") + what + " >/dev/full 2>err"), 2) << what;
    EXPECT_EQ(folder_.read("err"), "grtx: standard output: cannot be written\n") << what;
  }
}

TEST_F(CliFaults, ResultsForAClosedOutputAreAnError) {
  make_scene();
  ASSERT_EQ(folder_.run("sim t.grtx --quiet --stats st.json").code, 0);
  const std::string reference = "reference --scene s.ply --cameras s.cameras.json --width 2 --height 2 -o i.pfm";
  for (const std::string& what :
       {std::string("sim t.grtx"), std::string("sim t.grtx --json"), std::string("sim --list-config"),
        trace_ + "-o u.grtx --json", std::string("info s.ply"), std::string("info s.ply --json"),
        std::string("trace-check t.grtx --json"), std::string("trace-dump t.grtx"),
        std::string("ray t.grtx --pixel 4,4 -o r.html --json"), std::string("machine paper"), std::string("cost"),
        std::string("stalls st.json"), std::string("report st.json -o p.html --json"),
        std::string("convert s.ply v.ply --json"), reference + " --json",
        std::string("compare s.cameras.json s.cameras.json --help"),
        std::string("synth --preset object --count 9 -o w.ply --json"), std::string("--version"),
        std::string("--help")}) {
    for (const char* lost : {">&-", ">/dev/full"}) {
      EXPECT_EQ(shell("grtx " + what + " 2>err " + lost), 2) << what << lost;
      EXPECT_THAT(folder_.read("err"), HasSubstr("grtx: standard output: cannot be written\n")) << what << lost;
    }
  }
  EXPECT_EQ(shell("grtx " + trace_ + "--quiet -o /dev/stdout 2>err >&-"), 2);
  // What prints no result needs no output.
  EXPECT_EQ(shell("grtx sim t.grtx --quiet --stats st2.json >&-"), 0);
  EXPECT_EQ(folder_.read("st2.json").substr(0, 20), folder_.read("st.json").substr(0, 20));
}

TEST_F(CliFaults, AnOptionDoesNotTakeTheNextOneAsItsValue) {
  make_scene();
  expect_refused("sim t.grtx --seed --quiet", "sim: --seed: needs a value: a whole number from 0 on, not --quiet");
  expect_refused("sim t.grtx --seed= --quiet", "sim: --seed: needs a value: a whole number from 0 on");
  expect_refused("sim t.grtx --seed ''", "sim: --seed: needs a value: a whole number from 0 on");
  expect_refused("sim t.grtx --stats --quiet", "sim: --stats: needs a value: OUTPUT, not --quiet");
  expect_refused("sim t.grtx --stats --qiet", "sim: --stats: needs a value: OUTPUT, not --qiet");
  EXPECT_FALSE(folder_.has("--quiet"));
  EXPECT_FALSE(folder_.has("--qiet"));
  expect_refused("sim t.grtx --mode --quiet", "sim: --mode: needs a value: TEXT:{");
  expect_refused("sim t.grtx --share -h", "sim: --share: needs a value: a number, not -h");
  expect_refused("sim t.grtx --quiet=foo", "sim: --quiet: takes no value, so not foo");
  expect_refused("sim t.grtx --share=--quiet", "sim: --share: must be a number, not --quiet");
  expect_refused("synth --count --seed 3 -o x.ply",
                 "synth: --count: needs a value: a whole number from 0 on, not --seed");
  expect_refused(trace_ + "--views= -o z.grtx", "trace: --views: needs a value: TEXT");
  expect_refused("info ''", "info: an argument is empty");
  // Explicit values are taken as they are, and what follows -- is no option.
  EXPECT_EQ(folder_.run("sim t.grtx --quiet --stats=--odd").code, 0);
  EXPECT_TRUE(folder_.has("--odd"));
  folder_.write("--s.ply", folder_.read("s.ply"));
  EXPECT_EQ(folder_.run("info --quiet -- --s.ply").code, 0);
}

TEST_F(CliFaults, DevStdoutAndFifosAsOutputs) {
  make_scene();
  ASSERT_EQ(shell("grtx " + trace_ + "--quiet -o /dev/stdout | cat >piped.grtx"), 0);
  EXPECT_EQ(folder_.read("piped.grtx"), folder_.read("t.grtx"));
  ASSERT_EQ(shell("grtx " + trace_ + "--quiet -o /dev/stdout >redirected.grtx"), 0);
  EXPECT_EQ(folder_.read("redirected.grtx"), folder_.read("t.grtx"));
  ASSERT_EQ(::mkfifo(folder_.path("f").c_str(), 0600), 0);
  ASSERT_EQ(shell("grtx " + trace_ + "--quiet -o f & cat f >read.grtx; wait $!"), 0);
  EXPECT_EQ(folder_.read("read.grtx"), folder_.read("t.grtx"));
  EXPECT_TRUE(std::filesystem::is_fifo(folder_.path("f")));
}

TEST_F(CliFaults, AnOutputWithoutANameIsRefused) {
  make_scene();
  expect_refused("sim t.grtx --stats ''", "--stats: must name a file");
  expect_refused("sim t.grtx --vcd ''", "--vcd: must name a file");
  expect_refused(trace_ + "-o ''", "must name a file");
}

TEST_F(CliFaults, ANameOf250BytesIsTaken) {
  make_scene();
  const std::string name = std::string(245, 'n') + ".grtx";
  EXPECT_EQ(folder_.run(trace_ + "--quiet -o " + name).code, 0);
  EXPECT_EQ(folder_.read(name), folder_.read("t.grtx"));
}

TEST_F(CliFaults, AFilesNameSteersNoTerminal) {
  expect_refused("info \"$(printf 's\\033[31m\\nx.ply')\"", "s\\x1b[31m\\nx.ply: No such file");
}

TEST_F(CliFaults, AProgramAwayFromItsSourcesSaysWhereItLooksForMachines) {
  make_scene();
  std::filesystem::create_directories(folder_.path("bin"));
  std::filesystem::create_directories(folder_.path("share/grtx_tlm/configs/machines"));
  std::filesystem::copy_file(grtx::paths::program(), folder_.path("bin/grtx"));
  EXPECT_EQ(shell("bin/grtx sim t.grtx --machine paper 2>err"), 2);
  EXPECT_THAT(folder_.read("err"), HasSubstr("share/grtx_tlm/configs/machines or "));
}

TEST_F(CliFaults, CtrlCLeavesNoHalfTrace) {
  make_scene();
  // -e: the file exists while options are parsed, too; -s: it is being written.
  for (const auto& [signal, name, code, when] : {std::tuple("INT", "SIGINT", 130, "-e"),
                                                 {"INT", "SIGINT", 130, "-s"},
                                                 {"TERM", "SIGTERM", 143, "-e"},
                                                 {"TERM", "SIGTERM", 143, "-s"},
                                                 {"HUP", "SIGHUP", 129, "-e"},
                                                 {"HUP", "SIGHUP", 129, "-s"}}) {
    const std::string large =
        "trace --scene s.ply --cameras s.cameras.json --width 4096 --height 4096 --accel tlas-tri20 -o l.grtx --quiet";
    // bash, whose background jobs do not ignore SIGINT with job control.
    const std::string script = "set -m; '" + grtx::paths::program() + "' " + large +
                               " & while kill -0 $! 2>/dev/null; do test " + when +
                               " l.grtx.partial && break; done; kill -" + signal + " $!; wait $!";
    folder_.write("script", script);
    EXPECT_EQ(shell("bash script >out 2>err"), code);
    EXPECT_THAT(folder_.read("err"),
                HasSubstr(std::string("grtx: ended by ") + name + ": what was being written is removed\n"));
    EXPECT_FALSE(folder_.has("l.grtx.partial") || folder_.has("l.grtx"));
  }
}

}  // namespace
}  // namespace grtx::e2e
