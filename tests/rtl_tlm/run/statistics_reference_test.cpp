// SPDX-License-Identifier: Apache-2.0
// The reference of all statistics: no run reports what the program does not list.
#include "grtx/rtl_tlm/run/statistics_reference.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "grtx/base/child_process.h"
#include "paths.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

std::string printed_reference() {
  FILE* pipe = ::popen(("'" + grtx::paths::program() + "' sim --list-statistics").c_str(), "r");
  std::string text;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
  EXPECT_EQ(::pclose(pipe), 0);
  return text;
}

/// name -> unit of the rows "| `name` | unit | meaning |".
std::map<std::string, std::string> listed(const std::string& reference) {
  std::map<std::string, std::string> rows;
  for (std::size_t at = 0; (at = reference.find("| `", at)) != std::string::npos;) {
    const std::size_t name = at + 3;
    const std::size_t end = reference.find("` | ", name);
    const std::size_t unit = end + 4;
    at = reference.find(" | ", unit);
    rows[reference.substr(name, end - name)] = reference.substr(unit, at - unit);
  }
  return rows;
}

TEST(StatisticsReference, ListsWhatRunsReport) {
  const std::map<std::string, std::string> known = listed(printed_reference());
  EXPECT_GT(known.size(), 200U);
  traces::testing::RandomOptions random;
  random.seed = 5;
  random.groups = 6;
  random.warp_size = 32;
  random.two_level = true;
  const auto trace = traces::testing::random_trace(random);
  const traces::testing::TemporaryFile file("reference");
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  ChildProcess child("simulation", [&] {
    const GpuConfig config = load_config("", {"gpu.sms=2", "gpu.rt_units=2"});
    return test::simulate_priced(file.path(), config).document.at("stats").dump();
  });
  const nlohmann::json stats = nlohmann::json::parse(child.result());
  for (const auto& [name, entry] : stats.items()) {
    if (name.starts_with("host.")) continue;
    const auto row = known.find(reference_name(name));
    if (row == known.end()) {
      ADD_FAILURE() << name << " is not listed";
    } else {
      EXPECT_EQ(entry.at("unit").get<std::string>(), row->second) << name;
    }
  }
}

TEST(ReferenceName, ReplacesNumbersAndRegions) {
  EXPECT_EQ(reference_name("gpu.sm12.rt.selections"), "gpu.sm<i>.rt<j>.selections");
  EXPECT_EQ(reference_name("gpu.sm3.rt1.selections"), "gpu.sm<i>.rt<j>.selections");
  EXPECT_EQ(reference_name("gpu.sm3.warps"), "gpu.sm<i>.warps");
  EXPECT_EQ(reference_name("gpu.dram.channel10.bytes"), "gpu.dram.channel<i>.bytes");
  EXPECT_EQ(reference_name("gpu.l1.k_buffer.reads"), "gpu.l1.<region>.reads");
  EXPECT_EQ(reference_name("gpu.l1.stall.bank_conflict"), "gpu.l1.stall.bank_conflict");
  EXPECT_EQ(reference_name("gpu.l2.miss_latency.histogram.from_64"), "gpu.l2.miss_latency.histogram.from_<n>");
}

}  // namespace
}  // namespace grtx::sim
