// SPDX-License-Identifier: Apache-2.0
// Everything that a configuration may get wrong: one line with the file, the line, the key and the nearest known name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "temporary_folder.h"

namespace grtx::sim {
namespace {

using ::testing::HasSubstr;

struct Case {
  const char* name;
  const char* text;
  const char* place;
  std::vector<const char*> rule;  ///< parts of the rule
  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

class ConfigError : public ::testing::TestWithParam<Case> {};

TEST_P(ConfigError, NamesFileLineAndRule) {
  const grtx::test::TemporaryFolder folder;
  folder.write("circle.toml", "include = \"bad.toml\"\n");
  const std::string path = folder.write("bad.toml", GetParam().text);
  try {
    load_config(path, {});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.place(), HasSubstr(GetParam().place));
    for (const char* part : GetParam().rule) EXPECT_THAT(error.rule(), HasSubstr(part));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    EXPECT_THAT(error.file(), ::testing::AnyOf(HasSubstr("bad.toml"), HasSubstr("circle.toml")));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, ConfigError,
    ::testing::Values(
        Case{"unknown_key", "[l1]\nbytes = 1024\nlatncy = 20\n", "line 3", {"unknown key 'l1.latncy'", "'l1.latency'"}},
        Case{"unknown_table", "[cache]\nbytes = 1024\n", "line 2", {"unknown key 'cache.bytes'"}},
        Case{"unknown_nested_key", "[rt.box]\nlatenzy = 3\n", "line 2", {"'rt.box.latency'"}},
        Case{"text_for_integer", "[l1]\nlatency = \"20\"\n", "line 2", {"l1.latency", "an integer", "the text '20'"}},
        Case{"real_for_integer", "[l1]\nlatency = 20.5\n", "line 2", {"an integer", "20.5"}},
        Case{"integer_for_bool", "[l1]\nperfect = 1\n", "line 2", {"true or false", "the integer 1"}},
        Case{"list_for_integer", "[l1]\nlatency = [20]\n", "line 2", {"a single value"}},
        Case{"table_for_integer", "[l1.latency]\n", "line 1", {"a single value"}},
        Case{"too_large", "[gpu]\nsms = 257\n", "line 2", {"1 to 256", "not 257"}},
        Case{"negative", "[gpu]\nsms = -1\n", "line 2", {"1 to 256", "not -1"}},
        Case{"zero_clock", "[gpu]\ncore_mhz = 0.0\n", "line 2", {"100 to 10000"}},
        Case{"not_a_number", "[gpu]\ncore_mhz = nan\n", "line 2", {"gpu.core_mhz"}},
        Case{"infinite", "[gpu]\ncore_mhz = inf\n", "line 2", {"gpu.core_mhz"}},
        Case{"unknown_name", "[rt.scheduler]\npolicy = \"oldest\"\n", "line 2", {"'oldest_first'"}},
        Case{"syntax", "[l1]\nlatency = \n", "line 2", {"expected value"}},
        Case{"key_twice", "[l1]\nlatency = 1\nlatency = 2\n", "line 3", {"latency"}},
        Case{"include_missing", "include = \"no_such_file.toml\"\n", "line 1", {"no file", "no_such_file.toml"}},
        Case{"include_number", "include = 3\n", "line 1", {"a path or a list of paths"}},
        Case{"include_circle", "include = \"circle.toml\"\n", "include", {"includes itself"}},
        Case{"line_not_power_of_two", "[l1]\nline_bytes = 96\n", "l1.line_bytes", {"a power of two"}},
        Case{"cache_without_set", "[l1]\nbytes = 1024\nways = 256\n", "l1.bytes", {"at least l1.ways lines"}},
        Case{"interleave_below_line",
             "[l2]\nline_bytes = 256\ninterleave_bytes = 128\n",
             "l2.interleave_bytes",
             {"l2.line_bytes"}},
        Case{"channels_divide_slices", "[l2]\nslices = 4\n[dram]\nchannels = 3\n", "dram.channels", {"divide"}},
        Case{"more_channels_than_slices", "[l2]\nslices = 2\n[dram]\nchannels = 4\n", "dram.channels", {"divide"}},
        Case{"hash_needs_power_of_two", "[l2]\nslices = 3\nxor_hash = true\n", "l2.xor_hash", {"power of two"}},
        Case{"descriptor_wait_alone",
             "[rt.memory]\ndescriptor_wait = 4\n",
             "rt.memory.descriptor_wait",
             {"rt.memory.leaf_descriptor_read"}},
        Case{"header_wait_alone",
             "[rt.memory]\nheader_wait = 8\nblas_header_read = false\n",
             "rt.memory.header_wait",
             {"rt.memory.blas_header_read"}},
        Case{"hits_of_shaders",
             "[rt.memory]\nl1_hit_latency = 0\nby_shader = true\n",
             "rt.memory.l1_hit_latency",
             {"rt.memory.by_shader"}},
        Case{"hits_of_two_units",
             "[gpu]\nrt_units = 2\n[rt.memory]\nl1_hit_latency = 0\n",
             "rt.memory.l1_hit_latency",
             {"gpu.rt_units = 1"}},
        Case{"latency_below_link", "[l1]\nlatency = 1\nlink_latency = 2\n", "l1.latency", {"l1.link_latency"}},
        Case{"leaf_bytes", "[rt.memory]\ninstance_leaf_bytes = 96\n", "rt.memory.instance_leaf_bytes", {"64 or 128"}},
        Case{"rt_port", "[rt.memory]\nsectors_per_cycle = 3\n", "rt.memory.sectors_per_cycle", {"1, 2 or 4"}},
        Case{"simt_port", "[simt]\nsectors_per_cycle = 3\n", "simt.sectors_per_cycle", {"1, 2 or 4"}},
        Case{"entry_bytes", "[rt.checkpoint]\nentry_bytes = 12\n", "rt.checkpoint.entry_bytes", {"8, 16, 20 or 28"}}),
    [](const auto& test_case) { return std::string(test_case.param.name); });

TEST(ConfigSetting, NamesTheNearestKeyAndTheRule) {
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"l1.latency", "must have the form key=value"},
      {"l1.latncy=3", "'l1.latency'"},
      {"l1.latency=abc", "an integer"},
      {"l1.latency=", "an integer"},
      {"l1.latency=3x", "an integer"},
      {"l1.latency=0", "1 to 10000"},
      {"l1.perfect=yes", "true or false"},
      {"rt.scheduler.policy=random", "one of oldest_first, round_robin, greedy_then_oldest"}};
  for (const auto& [setting, rule] : cases) {
    try {
      load_config("", {setting});
      ADD_FAILURE() << setting << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.file(), "--set");
      EXPECT_THAT(error.rule(), HasSubstr(rule)) << setting;
    }
  }
}

TEST(ConfigSetting, AppliesAfterTheFileInOrder) {
  const grtx::test::TemporaryFolder folder;
  const std::string path = folder.write("a.toml", "[l1]\nlatency = 30\n[rt.scheduler]\npolicy = \"round_robin\"\n");
  const GpuConfig config =
      load_config(path, {"l1.latency=31", "l1.latency=32", "gpu.core_mhz=1000", "l1.perfect=true"});
  EXPECT_EQ(config.l1.latency, 32U);
  EXPECT_EQ(config.core_mhz, 1000.0);
  EXPECT_TRUE(config.l1.perfect);
  EXPECT_EQ(config.rt.scheduler.policy, "round_robin");
}

TEST(ConfigFile, AnIncludingFileSaysOnlyWhatDiffers) {
  const grtx::test::TemporaryFolder folder;
  folder.write("base.toml", "[l1]\nlatency = 30\nways = 64\n");
  folder.write("more.toml", "[l1]\nways = 32\n");
  const std::string path = folder.write("top.toml", "include = [\"base.toml\", \"more.toml\"]\n[gpu]\nsms = 3\n");
  const GpuConfig config = load_config(path, {});
  EXPECT_EQ(config.l1.latency, 30U);
  EXPECT_EQ(config.l1.geometry.ways, 32U);
  EXPECT_EQ(config.sms, 3U);
}

}  // namespace
}  // namespace grtx::sim
