// SPDX-License-Identifier: Apache-2.0
// What a machine that stands still prints: each unit lists what it holds, and the lists of different units agree.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "rtl_tlm/silent_dram.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

/// The lines, each with the numbers in it, below the last line without indentation, which names the unit.
struct DumpLine {
  std::string unit, text;
  std::vector<std::uint64_t> numbers;
};

std::vector<std::uint64_t> numbers_of(const std::string& text) {
  static const std::regex number("[0-9]+");
  std::vector<std::uint64_t> all;
  for (std::sregex_iterator it(text.begin(), text.end(), number), end; it != end; ++it) {
    all.push_back(std::stoull(it->str()));
  }
  return all;
}

std::vector<DumpLine> lines_of(const std::string& dump) {
  std::vector<DumpLine> lines;
  std::istringstream in(dump);
  std::string unit;
  for (std::string text; std::getline(in, text);) {
    const bool heads = !text.starts_with(' ');
    if (heads) unit = text.substr(0, text.find(':'));
    // The name's numbers are not the line's.
    lines.push_back({unit, text, numbers_of(heads && text.size() > unit.size() ? text.substr(unit.size()) : text)});
  }
  return lines;
}

class StalledMachine : public ::testing::Test {
 protected:
  static constexpr unsigned kGroups = 14, kSms = 2, kResident = 5, kEntries = 3;

  StalledMachine() {
    test::write_tiny_trace(file_.path(), {kGroups, 32});
    ChildProcess child("simulation", [&] {
      ::testing::internal::CaptureStderr();
      SimulationOptions options;
      options.watchdog_cycles = 2000;
      test::make_a_silent_dram();
      try {
        test::simulate_priced(
            file_.path(),
            load_config("", {"gpu.sms=" + std::to_string(kSms), "gpu.resident_warps=" + std::to_string(kResident),
                             "rt.warp_buffer.entries=" + std::to_string(kEntries), "dram.scheduling=silent"}),
            options);
      } catch (const std::runtime_error&) {
      }
      return ::testing::internal::GetCapturedStderr();
    });
    dump_ = child.result();
    lines_ = lines_of(dump_);
  }

  /// The lines of a unit that begin so (after the indentation).
  std::vector<DumpLine> of(const std::string& unit, const std::string& begin) const {
    std::vector<DumpLine> found;
    for (const DumpLine& line : lines_) {
      const std::size_t first = line.text.find_first_not_of(' ');
      if (line.unit == unit && line.text.compare(first, begin.size(), begin) == 0) found.push_back(line);
    }
    return found;
  }
  std::uint64_t headline(const std::string& unit, std::size_t number) const {
    const auto lines = of(unit, unit + ":");
    return lines.size() == 1 ? lines[0].numbers.at(number) : ~std::uint64_t{0};
  }
  static std::string sm(unsigned i) { return "gpu.sm" + std::to_string(i); }

  const traces::testing::TemporaryFile file_{"stalled"};
  std::string dump_;
  std::vector<DumpLine> lines_;
};

TEST_F(StalledMachine, DistributorAndSimtCoresNameTheSameWarps) {
  std::set<std::pair<std::uint64_t, std::uint64_t>> given, held;  // SM, slot
  for (const DumpLine& line : of("gpu.distributor", "sm ")) given.insert({line.numbers.at(0), line.numbers.at(1)});
  EXPECT_EQ(headline("gpu.distributor", 0), kSms * kResident);  // launched
  EXPECT_EQ(headline("gpu.distributor", 2), kSms * kResident);  // running
  for (unsigned i = 0; i < kSms; ++i) {
    for (const DumpLine& line : of(sm(i) + ".simt", "slot ")) {
      held.insert({i, line.numbers.at(0)});
      EXPECT_NE(line.text.find(" tracing since"), std::string::npos) << line.text;
    }
    EXPECT_EQ(headline(sm(i) + ".simt", 1), kResident);
  }
  EXPECT_EQ(given.size(), kSms * kResident) << dump_;
  EXPECT_EQ(given, held);
}

TEST_F(StalledMachine, LanesThatWaitForMemoryAreThoseOfTheFetchesUnderWay) {
  for (unsigned i = 0; i < kSms; ++i) {
    EXPECT_EQ(headline(sm(i) + ".rt.warp_buffer", 0), kEntries);
    std::map<std::uint64_t, std::uint64_t> waiting, fetched;  // by entry: lanes
    for (const DumpLine& line : of(sm(i) + ".rt.warp_buffer", "entry ")) {
      EXPECT_TRUE(std::regex_search(line.text, std::regex(" accepted [0-9]+ waiting_memory=32$"))) << line.text;
      waiting[line.numbers.at(0)] = line.numbers.back();
    }
    std::uint64_t missing = 0;
    for (const DumpLine& line : of(sm(i) + ".rt.memory_scheduler", "entry ")) {
      fetched[line.numbers.at(0)] += line.numbers.at(3);
      missing += line.numbers.at(4);
    }
    EXPECT_EQ(waiting.size(), kEntries) << dump_;
    EXPECT_EQ(waiting, fetched);
    EXPECT_EQ(headline(sm(i) + ".rt.memory_scheduler", 1), missing);
  }
}

TEST_F(StalledMachine, CachesListWhatTheyWaitForAndTheCrossbarAllItsPorts) {
  std::uint64_t waiting = 0, entries = 0, slices = 0;
  for (unsigned i = 0; i < kSms; ++i) {
    const auto lines = of(sm(i) + ".l1d", "mshr ");
    EXPECT_GT(lines.size(), 0U);
    EXPECT_EQ(headline(sm(i) + ".l1d", 0), lines.size());
    for (const DumpLine& line : lines) waiting += line.numbers.back();
    entries += lines.size();
  }
  EXPECT_EQ(waiting, entries * kEntries);  // each warp reads the same node
  for (const DumpLine& line : lines_) {
    if (line.text.starts_with("gpu.l2_slice")) ++slices;
  }
  const auto ports = of("gpu.crossbar", "gpu.crossbar: ");
  ASSERT_EQ(ports.size(), 2U);
  for (const DumpLine& line : ports) {
    const bool requests = line.text.find(": requests ") != std::string::npos;
    for (std::uint64_t in = 0; in < (requests ? kSms : slices); ++in) {
      EXPECT_NE(line.text.find(" in" + std::to_string(in) + " "), std::string::npos) << line.text;
    }
    for (std::uint64_t out = 0; out < (requests ? slices : kSms); ++out) {
      EXPECT_NE(line.text.find(" out" + std::to_string(out) + " "), std::string::npos) << line.text;
    }
  }
}

}  // namespace
}  // namespace grtx::sim
