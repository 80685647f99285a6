// SPDX-License-Identifier: Apache-2.0
// What a user's unit does wrong ends the run in one line that says what, where and when.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "grtx/base/error.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/run/hostile_memory.h"

namespace grtx::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

/// A memory with one unit more, which does this after 1 us.
class MemoryWith final : public MonitoredMemory {
 public:
  struct Unit final : sc_core::sc_module {
    using SC_CURRENT_USER_MODULE = Unit;
    Unit(const sc_core::sc_module_name& name, std::function<void()> what) : sc_module(name), what_(std::move(what)) {
      SC_METHOD(act);
    }
    void act() {
      if (sc_core::sc_time_stamp() == sc_core::SC_ZERO_TIME) return next_trigger(1, sc_core::SC_US);
      what_();
    }
    std::function<void()> what_;
  };

  MemoryWith(Gpu& gpu, const std::function<void()>& what) : MonitoredMemory(gpu, "own"), unit_("own_unit", what) {
    for (unsigned i = 0; i < channels(); ++i) {
      targets_.push_back(
          std::make_unique<test::HostileTarget>(("target" + std::to_string(i)).c_str(), test::HostileBehaviour{}));
      socket(i).bind(targets_.back()->socket);
    }
  }

 private:
  Unit unit_;
  std::vector<std::unique_ptr<test::HostileTarget>> targets_;
};

std::string failure_of_run_with(const std::function<void()>& what) {
  const test::ObservedRun run;
  ChildProcess child("simulation", [&]() -> std::string {
    // As the program does: a unit that only warns must not scroll by.
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_THROW);
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", {});
    SimulationOptions options;
    options.memory = [&](Gpu& gpu, const BuildOptions&) { return std::make_unique<MemoryWith>(gpu, what); };
    try {
      simulate(run.path("t.grtx"), config, options);
    } catch (const Error& error) {
      return std::string("Error ") + error.what();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  });
  return child.result();
}

TEST(UsersUnitFaults, ScStopIsNamedWithItsCycle) {
  EXPECT_THAT(failure_of_run_with([] { sc_core::sc_stop(); }),
              MatchesRegex("Error simulation: core cycle [0-9]+: a unit has called sc_stop\\(\\): .*"));
}

TEST(UsersUnitFaults, AReportOfTheirsKeepsTypeModuleAndTime) {
  EXPECT_EQ(failure_of_run_with([] { SC_REPORT_ERROR("/their/type", "this is full"); }),
            "Error simulation: own_unit.act, at 1 us: /their/type: this is full");
  EXPECT_EQ(failure_of_run_with([] { SC_REPORT_WARNING("/their/type", "this is odd"); }),
            "Error simulation: own_unit.act, at 1 us: /their/type: this is odd");
}

TEST(UsersUnitFaults, AnExceptionAndAReportOfTheKernelHaveModuleAndTime) {
  const std::string thrown = failure_of_run_with([] { throw std::runtime_error("theirs"); });
  EXPECT_THAT(thrown, HasSubstr("theirs"));
  EXPECT_THAT(thrown, HasSubstr("own_unit.act, at 1 us"));
  const std::string kernels = failure_of_run_with([] { sc_core::wait(1, sc_core::SC_NS); });
  EXPECT_THAT(kernels, HasSubstr("wait() is only allowed in SC_THREADs and SC_CTHREADs"));
  EXPECT_THAT(kernels, HasSubstr("own_unit.act, at 1 us"));
}

}  // namespace
}  // namespace grtx::sim
