// SPDX-License-Identifier: Apache-2.0
// The save file names signals that the dump has, in groups that nest as the hierarchy does, and filters that exist.
#include "grtx/rtl_tlm/observe/gtkwave_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "grtx/base/atomic_file.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/observe/vcd_reader.h"

namespace grtx::sim {
namespace {

TEST(GtkwaveFiles, FollowTheHierarchyOfTheDump) {
  const test::ObservedRun run;
  SimulationOptions options;
  options.waveform.path = run.path("w.vcd");
  options.waveform.window = {1000, 1400};
  run.run(options);
  const VcdFile dump = read_vcd(read_file(run.path("w.vcd")));
  std::ifstream save(run.path("w.gtkw"));
  std::vector<std::string> groups;
  std::set<std::string> shown, filters;
  bool filtered = false, analog_row = false;
  unsigned flags = 0;
  for (std::string line; std::getline(save, line);) {
    if (line.empty() || line[0] == '[' || line[0] == '*') continue;
    if (line[0] == '@') {
      flags = static_cast<unsigned>(std::stoul(line.substr(1), nullptr, 16));
      analog_row = flags == 0x20000;
    } else if (line[0] == '^') {
      filters.insert(line.substr(3));
      filtered = true;
    } else if (line[0] == '-') {
      if (analog_row) continue;
      const std::string group = line.substr(1);
      if ((flags & 0x800000) != 0) {
        if (!groups.empty()) {
          EXPECT_TRUE(group.starts_with(groups.back() + ".")) << group << " in " << groups.back();
        }
        groups.push_back(group);
      } else {
        ASSERT_NE(flags & 0x1000000, 0U) << line;
        ASSERT_FALSE(groups.empty());
        EXPECT_EQ(groups.back(), group);
        groups.pop_back();
      }
    } else {
      const std::string name = line.substr(0, line.find('['));
      ASSERT_TRUE(dump.width.contains(name)) << name;
      EXPECT_EQ(line, dump.width.at(name) == 1 ? name : name + "[" + std::to_string(dump.width.at(name) - 1) + ":0]");
      EXPECT_EQ(name.substr(0, name.rfind('.')), groups.back());
      EXPECT_TRUE(shown.insert(name).second) << name << " twice";
      EXPECT_EQ(filtered, (flags & 0x2000) != 0) << name;
      filtered = false;
    }
  }
  EXPECT_TRUE(groups.empty());
  EXPECT_EQ(shown.size(), dump.width.size());
  EXPECT_EQ(filters.size(), 5U);  // warp_state, stall_reason, unit_state, node_kind, activity
  for (const std::string& filter : filters) EXPECT_TRUE(std::filesystem::exists(filter)) << filter;
}

// Of walk the scheduler's group was closed, and the first screen showed a free warp alone.
TEST(GtkwaveFiles, TheSchedulerOfWarpsThatWalkTogetherBeginsOpen) {
  const test::ObservedRun run;
  const std::string unit = "gpu.sm0.rt.warp_walk_scheduler";
  write_gtkwave_files(run.path("a.vcd"), run.path("a.gtkw"), {{unit + ".under_way", 5, nullptr}}, {0, 1000, 10});
  EXPECT_NE(read_file(run.path("a.gtkw")).find("@800200\n-" + unit + "\n"), std::string::npos);
}

TEST(GtkwaveFiles, AFilterTurnsValuesIntoWords) {
  const test::ObservedRun run;
  const Enumeration states{"state", {"idle", "busy"}, {"gray25"}};
  write_gtkwave_files(run.path("a.vcd"), run.path("a.gtkw"), {{"gpu.x.state", 5, &states}}, {0, 1000, 10});
  EXPECT_EQ(filter_file_of(run.path("a.gtkw"), states), run.path("a.state.filter"));
  EXPECT_EQ(read_file(run.path("a.state.filter")), "00 ?gray25?idle\n01 busy\n");
}

}  // namespace
}  // namespace grtx::sim
