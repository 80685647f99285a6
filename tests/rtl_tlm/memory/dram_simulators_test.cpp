// SPDX-License-Identifier: Apache-2.0
// The DRAM simulators of others that this build was linked with, behind the sockets of the L2 slices at 1365 MHz: GDDR6
// of 14 Gb/s, 16 bits per channel, and HBM2 of 2 Gb/s, from configs/dram. Without any of them it is not compiled.
#include "grtx/rtl_tlm/memory/dram_simulators.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "grtx/base/error.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"
#include "paths.h"
#include "temporary_folder.h"

namespace grtx::sim {
namespace {

// Clocks of 570 ps, from the timing of configs/dram/*gddr6*.
constexpr Cycle kRcd = 27;
constexpr Cycle kRead = 24;
constexpr Cycle kBurst = 2;
constexpr double kPeak = 32.0 / (2 * 0.570);  // GB/s of a channel
constexpr double kRefresh = 211.0 / 3333.0;   // share of the time
constexpr double kHbm2Peak = 2 * 32.0 / 2.0;  // GB/s of a channel
constexpr double kHbm2Most = 1.0 - 220.0 / 3900.0;

std::string configuration(const std::string& simulator, const std::string& memory = "gddr6") {
  return simulator == "dramsys" ? paths::source_dir() + "/configs/dram/dramsys_" + memory + ".json"
                                : GRTX_RAMULATOR_FOLDER "/ramulator_" + memory + ".yaml";
}

class DramSimulator : public modules::SystemCTest, public ::testing::WithParamInterface<std::string> {
 protected:
  struct Bench {
    Bench(const std::string& simulator, unsigned slices, bool per_slice, double core_mhz = 1365.0,
          const std::string& file = "")
        : core("core", core_mhz) {
      config.file = file.empty() ? configuration(simulator) : file;
      config.interleave.slices = slices;
      config.per_slice = per_slice;
      config.bytes = std::uint64_t{64} << 20;
      dram = build_dram_simulator(simulator, "dram", config);
      for (unsigned i = 0; i < slices; ++i) {
        const std::string n = std::to_string(i);
        drivers.push_back(std::make_unique<modules::AtDriver>(("driver" + n).c_str(), core));
        checkers.push_back(std::make_unique<modules::AtProtocolChecker>(
            ("checker" + n).c_str(), modules::AtProtocolChecker::Config{.period_fs = core.period_fs()}));
        drivers[i]->initiator.socket.bind(checkers[i]->target);
        checkers[i]->initiator.bind(dram->port(i).socket);
      }
    }
    /// The simulators refresh for ever, so that the kernel never goes quiet.
    void run_to_end(Cycle cycles) {
      const auto done = [this] {
        return dram->idle() && std::all_of(drivers.begin(), drivers.end(), [](const auto& d) { return d->complete(); });
      };
      for (Cycle end = 0; end < cycles && !(end > 0 && done()); end += 1000) run(core, 1000);
      EXPECT_TRUE(done());
      for (const auto& checker : checkers) {
        EXPECT_EQ(checker->violations(), 0u) << checker->messages().front();
        EXPECT_EQ(checker->outstanding(), 0u);
      }
    }
    PortedDramConfig config;
    modules::ClockDomain core;
    std::unique_ptr<PortedDram> dram;
    std::vector<std::unique_ptr<modules::AtDriver>> drivers;
    std::vector<std::unique_ptr<modules::AtProtocolChecker>> checkers;
  };

  /// GB/s of one slice that reads consecutive addresses.
  double streamed(const std::string& memory, unsigned bytes) {
    constexpr unsigned kRequests = 20'000;
    Bench bench(GetParam(), 1, true, 3500.0, configuration(GetParam(), memory));
    for (unsigned i = 0; i < kRequests; ++i) bench.drivers[0]->at(1, std::uint64_t{i} * bytes, false, bytes);
    bench.run_to_end(1'000'000);
    return kRequests * bytes /
           (static_cast<double>(bench.drivers[0]->answers().back().cycle * bench.core.period_fs()) * 1e-6);
  }

  void random_requests(bool per_slice) {
    Bench bench(GetParam(), 4, per_slice);
    std::uint64_t state = 1;
    std::uint64_t writes = 0;
    for (unsigned slice = 0; slice < 4; ++slice) {
      for (unsigned i = 0; i < 400; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const bool write = state >> 62 == 0;
        writes += write ? 1 : 0;
        const unsigned bytes = 32u << (state >> 60 & 1);
        const std::uint64_t local = (state >> 20) % (std::uint64_t{16} << 20) / bytes * bytes;
        bench.drivers[slice]->at(1 + 2 * i, bench.config.interleave.global(local, slice), write, bytes);
      }
    }
    bench.run_to_end(1'000'000);
    DramPortCounters sum;
    for (unsigned slice = 0; slice < 4; ++slice) {
      EXPECT_EQ(bench.dram->port(slice).counters().responses, 400u);
      sum += bench.dram->port(slice).counters();
    }
    EXPECT_EQ(sum.writes, writes);
    EXPECT_EQ(sum.reads, 1600 - writes);
    EXPECT_EQ(sum.refused, 0u);
  }
};

TEST_P(DramSimulator, EachRequestHasOneAnswerInMemoriesOfTheirOwn) { random_requests(true); }
TEST_P(DramSimulator, EachRequestHasOneAnswerInOneMemory) { random_requests(false); }

TEST_P(DramSimulator, UnloadedReadTakesActivateAndColumnAndBurst) {
  Bench bench(GetParam(), 1, true);
  bench.drivers[0]->at(100, 4096);
  bench.run_to_end(10'000);
  // DRAMSys adds a clock of command time, and the adapter sees the answer in the clock after. Ramulator decides in the
  // clock after the request's arrival.
  const Cycle extra = GetParam() == "dramsys" ? 2 : 1;
  EXPECT_EQ(bench.dram->port(0).counters().inside_clocks, kRcd + kRead + kBurst + extra);
}

TEST_P(DramSimulator, StreamingReachesThePeakButForRefresh) {
  const double share = streamed("gddr6", 32) / kPeak;
  EXPECT_LE(share, 1.0 - kRefresh);
  EXPECT_GE(share, 1.0 - kRefresh - 0.06);  // closing and opening rows around each refresh
}

// Two pseudo-channels with 32 B in 2 clocks of 1 ns each. DRAMSys takes one request in two clocks, whatever its size.
TEST_P(DramSimulator, Hbm2StreamsSectorsAtItsPeakOrOneInTwoClocks) {
  const double most = GetParam() == "dramsys" ? 0.5 : kHbm2Most;
  const double share = streamed("hbm2", 32) / kHbm2Peak;
  EXPECT_LE(share, most);
  EXPECT_GE(share, most - 0.06);
}

TEST_P(DramSimulator, Hbm2StreamsPairsOfSectorsAtItsPeak) {
  const double share = streamed("hbm2", 64) / kHbm2Peak;
  EXPECT_LE(share, kHbm2Most);
  EXPECT_GE(share, kHbm2Most - 0.06);
}

/// The working directory, while it lives a folder of its own.
class WorkingFolder {
 public:
  WorkingFolder() : before_(std::filesystem::current_path()) { std::filesystem::current_path(folder_.path()); }
  ~WorkingFolder() { std::filesystem::current_path(before_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  test::TemporaryFolder folder_;
  std::filesystem::path before_;
};

// DRAMSys writes each 8,192 requests into its database in a thread that nobody waited for: the program ended with
// "terminate called without an active exception" and without results.
TEST_P(DramSimulator, ProgramEndsWellWhenDramsysHasRecordedDatabases) {
  if (GetParam() != "dramsys") GTEST_SKIP() << "DRAMSys records databases";
  const WorkingFolder folder;
  std::ifstream from(configuration("dramsys"));
  std::string text{std::istreambuf_iterator<char>(from), {}};
  const std::string_view off = "\"DatabaseRecording\": false";
  ASSERT_NE(text.find(off), std::string::npos);
  std::ofstream("recording.json") << text.replace(text.find(off), off.size(), "\"DatabaseRecording\": true");
  constexpr unsigned kRequests = 10'000;
  {
    Bench bench("dramsys", 1, true, 3500.0, "recording.json");
    for (unsigned i = 0; i < kRequests; ++i) bench.drivers[0]->at(1, std::uint64_t{i} * 32);
    bench.run_to_end(1'000'000);
  }
  std::uintmax_t recorded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(".")) {
    if (entry.path().extension() == ".tdb") recorded += entry.file_size();
  }
  EXPECT_GE(recorded, kRequests * 64) << "bytes of the databases";
}

TEST_P(DramSimulator, FileThatIsMissingIsNamed) {
  PortedDramConfig config;
  config.file = "/nowhere/dram.config";
  try {
    build_dram_simulator(GetParam(), "dram", config);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("/nowhere/dram.config"));
  }
}

INSTANTIATE_TEST_SUITE_P(Linked, DramSimulator, ::testing::ValuesIn(dram_simulators()),
                         [](const auto& simulator) { return simulator.param; });

}  // namespace
}  // namespace grtx::sim
