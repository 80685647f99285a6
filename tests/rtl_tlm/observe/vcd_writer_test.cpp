// SPDX-License-Identifier: Apache-2.0
// The waveform file, read back: hierarchy, initial values, changes only, and acceptance by GTKWave's converter.
#include "grtx/rtl_tlm/observe/vcd_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "rtl_tlm/observe/vcd_reader.h"

namespace grtx::sim {
namespace {

using Change = VcdFile::Change;

std::string test_path(const std::string& name) {
  return (std::filesystem::path(testing::TempDir()) / ("grtx_vcd_" + std::to_string(::getpid()) + "_" + name)).string();
}

TEST(VcdWriter, WritesHierarchyInitialValuesAndChangesOnly) {
  const std::string path = test_path("changes.vcd");
  VcdWriter writer(path);
  // Declared out of scope order on purpose: signals of one scope end up together.
  const auto warps = writer.declare("gpu.sm0.rt.warps", 4);
  const auto mshr = writer.declare("gpu.sm0.l1d.mshr", 9);
  const auto busy = writer.declare("gpu.sm0.rt.busy", 1);
  const auto cycle = writer.declare("gpu.cycle", 64);
  writer.set(warps, 3);
  writer.begin("trace abc", 100);
  for (std::uint64_t t = 100; t <= 400; t += 100) {
    writer.advance(t);
    writer.set(warps, t >= 300 ? 8 : 3);
    writer.set(busy, t == 200);
    writer.set(mshr, 256);
    writer.set(cycle, ~std::uint64_t{0});
  }
  writer.finish(500);

  const VcdFile file = read_vcd(read_file(path));
  EXPECT_EQ(file.comment, "trace abc");
  EXPECT_EQ(file.timescale, "1 fs");
  EXPECT_EQ(file.width,
            (std::map<std::string, unsigned>{
                {"gpu.cycle", 64}, {"gpu.sm0.l1d.mshr", 9}, {"gpu.sm0.rt.busy", 1}, {"gpu.sm0.rt.warps", 4}}));
  EXPECT_EQ(file.changes.at("gpu.sm0.rt.warps"), (std::vector<Change>{{100, 3}, {300, 8}}));
  EXPECT_EQ(file.changes.at("gpu.sm0.rt.busy"), (std::vector<Change>{{100, 0}, {200, 1}, {300, 0}}));
  EXPECT_EQ(file.changes.at("gpu.sm0.l1d.mshr"), (std::vector<Change>{{100, 0}, {100, 256}}));
  EXPECT_EQ(file.changes.at("gpu.cycle"), (std::vector<Change>{{100, 0}, {100, ~std::uint64_t{0}}}));
  EXPECT_EQ(file.end, 500U);
  std::filesystem::remove(path);
}

TEST(VcdWriter, TenThousandSignalsHaveDistinctIdentifiers) {
  const std::string path = test_path("many.vcd");
  VcdWriter writer(path);
  for (unsigned i = 0; i < 10000; ++i) writer.declare("gpu.s" + std::to_string(i), 1);
  writer.begin("", 0);
  writer.finish(1);
  EXPECT_EQ(read_vcd(read_file(path)).width.size(), 10000U);  // the reader refuses an identifier used twice
  std::filesystem::remove(path);
}

TEST(VcdWriter, AnUnfinishedFileLeavesNothingBehind) {
  const std::string path = test_path("unfinished.vcd");
  {
    VcdWriter writer(path);
    writer.declare("gpu.a", 1);
    writer.begin("", 0);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(VcdWriter, GtkwavesConverterReadsIt) {
  if (std::system("command -v vcd2fst > /dev/null") != 0) GTEST_SKIP() << "vcd2fst (package gtkwave) is not installed";
  const std::string path = test_path("gtkwave.vcd");
  VcdWriter writer(path);
  const Enumeration states{"state", {"free", "active", "any_hit"}, {}};
  const auto state = writer.declare("gpu.sm0.rt.w0.state", 2, &states);
  writer.begin("trace abc\nconfig def", 0);
  writer.advance(732601);
  writer.set(state, 2);
  writer.finish(1465202);
  EXPECT_EQ(std::system(("vcd2fst " + path + " " + path + ".fst > /dev/null 2>&1").c_str()), 0);
  EXPECT_GT(std::filesystem::file_size(path + ".fst"), 0U);
  std::filesystem::remove(path);
  std::filesystem::remove(path + ".fst");
}

}  // namespace
}  // namespace grtx::sim
