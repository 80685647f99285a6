// The DRAM simulators of others that this build was linked with, behind the sockets of the L2 slices at 1365 MHz: GDDR6
// of 14 Gb/s, 16 bits a channel, from configs/dram. Without any of them this file is not compiled.
#include "grtx/rtl_tlm/memory/dram_simulators.h"

#include "grtx/base/error.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"
#include "paths.h"

namespace grtx::sim {
namespace {

// Clocks of 570 ps, from the timing of configs/dram/*gddr6*.
constexpr Cycle kRcd = 27;
constexpr Cycle kRead = 24;
constexpr Cycle kBurst = 2;
constexpr double kPeak = 32.0 / (2 * 0.570);  // GB/s of a channel
constexpr double kRefresh = 211.0 / 3333.0;   // share of the time

std::string configuration(const std::string& simulator) {
  return simulator == "dramsys" ? paths::source_dir() + "/configs/dram/dramsys_gddr6.json" : GRTX_RAMULATOR_CONFIG;
}

class DramSimulator : public modules::SystemCTest, public ::testing::WithParamInterface<std::string> {
 protected:
  struct Bench {
    Bench(const std::string& simulator, unsigned slices, bool per_slice, double core_mhz = 1365.0)
        : core("core", core_mhz) {
      config.file = configuration(simulator);
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
  constexpr unsigned kRequests = 20'000;
  Bench bench(GetParam(), 1, true, 3500.0);
  for (unsigned i = 0; i < kRequests; ++i) bench.drivers[0]->at(1, i * 32);
  bench.run_to_end(1'000'000);
  const double ns = static_cast<double>(bench.drivers[0]->answers().back().cycle * bench.core.period_fs()) * 1e-6;
  const double share = kRequests * 32 / ns / kPeak;
  EXPECT_LE(share, 1.0 - kRefresh);
  EXPECT_GE(share, 1.0 - kRefresh - 0.06);  // closing and opening rows around each refresh
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
