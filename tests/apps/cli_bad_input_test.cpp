// SPDX-License-Identifier: Apache-2.0
// Files that are missing, cut, foreign or garbage: exit code 2, one line that names the file, and no output left
// behind.
#include <gmock/gmock.h>

#include "apps/program.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

std::string garbage(std::size_t bytes) {
  std::string text;
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < bytes; ++i) {
    state = state * 1664525U + 1013904223U;
    text += static_cast<char>(state >> 24);
  }
  return text;
}

class CliBadInput : public ::testing::Test {
 protected:
  CliBadInput() {
    folder_.write("garbage.ply", garbage(3000));
    folder_.write("text.ply", "not a scene\n");
    folder_.write("empty.ply", "");
    folder_.write("header_only.ply",
                  "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nend_header\n");
    folder_.write("garbage.grtx", garbage(3000));
    folder_.write("empty.grtx", "");
    folder_.write("garbage.toml", garbage(300));
    folder_.write("bad.toml", "[l1\n");
    folder_.write("garbage.json", garbage(300));
    folder_.write("empty.json", "");
    folder_.write("wrong.json", "{\"a\": 1}");
    folder_.write("garbage.pfm", garbage(300));
    folder_.write("garbage.png", garbage(300));
    folder_.write("garbage.exr", garbage(300));
    sim::test::write_tiny_trace(folder_.path("good.grtx"));
    const std::string good = folder_.read("good.grtx");
    folder_.write("half.grtx", good.substr(0, good.size() / 2));
    folder_.write("no_end.grtx", good.substr(0, good.size() - 1));
    folder_.write("longer.grtx", good + "x");
    std::string magic = good;
    magic[0] = static_cast<char>(magic[0] ^ 1);
    folder_.write("wrong_magic.grtx", magic);
    std::string bit = good;
    bit[good.size() / 2] = static_cast<char>(bit[good.size() / 2] ^ 1);
    folder_.write("one_bit.grtx", bit);
    folder_.write("a_scene.grtx", "ply\nformat ascii 1.0\nend_header\n");
  }

  void expect_bad(const std::string& arguments, const std::string& file) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.err;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << arguments << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(file)) << arguments;
    for (const char* output : {"out.json", "out.vcd", "out.pfm", "out.grtx"}) {
      EXPECT_FALSE(folder_.has(output)) << arguments << " left " << output;
    }
  }

  Folder folder_;
};

TEST_F(CliBadInput, Traces) {
  for (const char* file : {"garbage.grtx", "empty.grtx", "half.grtx", "no_end.grtx", "longer.grtx", "wrong_magic.grtx",
                           "one_bit.grtx", "a_scene.grtx", "missing.grtx", "."}) {
    expect_bad(std::string("sim ") + file + " --stats out.json --vcd out.vcd --quiet", file);
    expect_bad(std::string("trace-check ") + file, file);
  }
  for (const char* file : {"garbage.grtx", "half.grtx", "wrong_magic.grtx", "missing.grtx"}) {
    expect_bad(std::string("trace-dump ") + file, file);
  }
}

TEST_F(CliBadInput, Configurations) {
  for (const char* file : {"garbage.toml", "bad.toml", "missing.toml", "."}) {
    expect_bad(std::string("sim good.grtx --stats out.json --config ") + file, file);
  }
}

TEST_F(CliBadInput, Scenes) {
  for (const char* file : {"garbage.ply", "text.ply", "empty.ply", "header_only.ply", "missing.ply"}) {
    expect_bad(std::string("info ") + file, file);
  }
}

TEST_F(CliBadInput, Cameras) {
  for (const char* file : {"garbage.json", "empty.json", "wrong.json", "missing.json"}) {
    expect_bad(std::string("reference --scene text.ply -o out.pfm --cameras ") + file, file);
    expect_bad(std::string("trace --scene text.ply -o out.grtx --cameras ") + file, file);
  }
}

TEST_F(CliBadInput, Images) {
  for (const char* file : {"garbage.pfm", "garbage.png", "garbage.exr", "missing.png"}) {
    expect_bad(std::string("compare ") + file + " " + file, file);
  }
}

TEST_F(CliBadInput, OutputsThatCannotBeWritten) {
  expect_bad("sim good.grtx --quiet --stats no_such_folder/out.json", "no_such_folder/out.json");
  expect_bad("sim good.grtx --quiet --vcd no_such_folder/out.vcd", "no_such_folder/out.vcd");
}

TEST_F(CliBadInput, NumbersOutOfRange) {
  expect_bad("trace-dump good.grtx --warp 4", "--warp 4");
  expect_bad("trace-dump good.grtx --lane 32", "--lane 32");
  expect_bad("trace-dump good.grtx --nodes --json", "--nodes");
  expect_bad("sim good.grtx --set gpu.sms=0", "gpu.sms");
}

}  // namespace
}  // namespace grtx::e2e
