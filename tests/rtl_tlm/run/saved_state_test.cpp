// SPDX-License-Identifier: Apache-2.0
// A state that one process saves and another begins from: its statistics are those of `--warm`, both traces in one
// process, whatever the machine.
#include "grtx/rtl_tlm/run/saved_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <sstream>

#include "frontend/tracer/random_scene.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "paths.h"
#include "rtl_tlm/first_difference.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/tiny_trace.h"
#include "rtl_tlm/traced_view.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using traces::testing::random_trace;
using traces::testing::RandomOptions;
using traces::testing::TemporaryFile;

/// Inputs and statistics of a run but those of the host; the message of what it throws.
std::string run(const std::string& trace, const GpuConfig& config,
                const std::function<void(SimulationOptions&)>& with) {
  ChildProcess child("simulation", [&]() -> std::string {
    SimulationOptions options;
    with(options);
    try {
      const SimulationResult result = simulate(trace, config, options);
      if (!result.violations.empty()) return result.violations.front();
      return nlohmann::json(result.inputs).dump(1) + statistics_object(result.statistics).dump(1);
    } catch (const Error& error) {
      return error.what();
    }
  });
  return child.result();
}

/// `first`, then `second`: in one process, and with a file between two.
void expect_the_same(const std::string& first, const std::string& second, const GpuConfig& config,
                     const std::string& what) {
  const TemporaryFile state("state"), next("state");
  const std::string one_piece = run(second, config, [&](auto& options) { options.warm_trace = first; });
  EXPECT_NE(run(first, config, [&](auto& options) { options.save_state = state.path(); }).find("gpu.cycles"),
            std::string::npos);
  const std::string two_processes = run(second, config, [&](auto& options) {
    options.warm_state = state.path();
    options.save_state = next.path();
  });
  EXPECT_NE(one_piece.find("gpu.cycles"), std::string::npos) << one_piece;
  EXPECT_EQ(test::first_difference(two_processes, one_piece), "") << what;
  // What the second leaves is what it leaves in one piece.
  const TemporaryFile of_one_piece("state");
  run(second, config, [&](auto& options) {
    options.warm_trace = first;
    options.save_state = of_one_piece.path();
  });
  EXPECT_EQ(hex(xxh3(read_file(next.path()))), hex(xxh3(read_file(of_one_piece.path())))) << what;
}

class SavedStates : public ::testing::TestWithParam<unsigned> {};
constexpr unsigned kStateShares = 4;

TEST_P(SavedStates, GiveTheStatisticsOfOnePieceOnRandomMachines) {
  const char* const wanted = std::getenv("GRTX_STATE_MACHINES");
  const unsigned machines = wanted != nullptr ? static_cast<unsigned>(std::stoul(wanted)) : 16;
  for (unsigned seed = GetParam(); seed < machines; seed += kStateShares) {
    const test::RandomPair traces(seed, 9000);
    GpuConfig config = traces.config;
    if (seed % 4 == 3) config.l1.geometry.ways = 32;  // sets of another kind
    if (seed % 4 == 3) config.l1.geometry.bytes = std::uint64_t{config.l1.geometry.line_bytes} * 64;
    const std::string what = std::to_string(seed) + config_json(config).dump();
    expect_the_same(traces.first.path(), traces.second.path(), config, what);
  }
}
INSTANTIATE_TEST_SUITE_P(Shares, SavedStates, ::testing::Range(0U, kStateShares));

struct Tiny {
  Tiny() { test::write_tiny_trace(trace.path(), {12, 32}); }
  void save(const GpuConfig& config) {
    run(trace.path(), config, [&](auto& options) { options.save_state = state.path(); });
  }
  std::string begin(const GpuConfig& config) {
    return run(trace.path(), config, [&](auto& options) { options.warm_state = state.path(); });
  }
  TemporaryFile trace{"tiny"}, state{"state"};
};

TEST(SavedState, WarmsWhatRunsFromIt) {
  Tiny tiny;
  tiny.save({});
  const std::string cold = run(tiny.trace.path(), {}, [](auto&) {});
  EXPECT_NE(tiny.begin({}), cold);
  EXPECT_NE(tiny.begin({}).find("gpu.cycles"), std::string::npos);
}

TEST(SavedState, IsRefusedByWhatItIsNotFor) {
  Tiny tiny;
  tiny.save({});
  const std::string path = tiny.state.path();
  GpuConfig other;
  other.sms = 2;
  EXPECT_TRUE(tiny.begin(other).starts_with(path + ": machine: is another")) << tiny.begin(other);
  const TemporaryFile trace("tiny");
  test::write_random(trace.path(), {}, false);
  const std::string line = run(trace.path(), {}, [&](auto& o) { o.warm_state = path; });
  EXPECT_TRUE(line.starts_with(path + ": hardware: is for accel ")) << line;
  EXPECT_TRUE(run(tiny.trace.path(), {}, [&](auto& options) {
                options.warm_state = path;
                options.warm_trace = tiny.trace.path();
              }).starts_with("sim: --warm-state: "));
  GpuConfig foreign;
  foreign.l1.geometry.replacement = "fifo";
  EXPECT_TRUE(tiny.begin(foreign).starts_with(path + ": machine: is another"));
}

TEST(SavedState, IsRefusedWhenABitOfItIsWrong) {
  Tiny tiny;
  GpuConfig small;
  small.sms = 1;
  small.l2_bytes = 64 * 1024;
  tiny.save(small);
  const std::string path = tiny.state.path(), whole = read_file(path);
  read_state(path);
  for (std::size_t at = 0; at < whole.size(); at += at < 300 ? 7 : 9973) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write_file(path, damaged);
    EXPECT_THROW(read_state(path), Error) << at;
    write_file(path, whole.substr(0, at));
    EXPECT_THROW(read_state(path), Error) << at;
  }
  write_file(path, whole + "x");
  EXPECT_THROW(read_state(path), Error);
}

TEST(SavedState, IsRefusedWhenItIsNoStateOfTheUnits) {
  Tiny tiny;
  tiny.save({});
  const SavedState whole = read_state(tiny.state.path());
  SavedState shorter = whole, longer = whole;
  shorter.units.pop_back();
  write_state(tiny.state.path(), shorter);
  EXPECT_NE(tiny.begin({}).find("ends too early"), std::string::npos);
  longer.units += 'x';
  write_state(tiny.state.path(), longer);
  EXPECT_NE(tiny.begin({}).find("is longer than its state"), std::string::npos);
}

TEST(SavedState, GivesTheStatisticsOfOnePieceInAllDesigns) {
  const frontend::Scene scene = grtx::test::random_scene(65, {.count = 100, .sh_degree = 2});
  const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/table1.toml", {});
  for (const auto kind : {frontend::AccelKind::tri20, frontend::AccelKind::tlas_tri20}) {
    for (const bool checkpoint : {false, true}) {
      const TemporaryFile first("first"), second("second");
      test::write_view(first.path(), scene, grtx::test::front_camera(16, 8, 2.0), 16, 8, kind, checkpoint);
      test::write_view(second.path(), scene, grtx::test::front_camera(16, 8, 1.7), 16, 8, kind, checkpoint);
      const std::string what = std::string(frontend::accel_name(kind)) + (checkpoint ? " with checkpoints" : "");
      expect_the_same(first.path(), second.path(), config, what);
    }
  }
}

}  // namespace
}  // namespace grtx::sim
