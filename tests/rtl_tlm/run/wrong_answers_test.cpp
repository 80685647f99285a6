// SPDX-License-Identifier: Apache-2.0
// A unit of a user's that answers what nobody asked ends the run in one line that names the unit, not the trace.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <memory>
#include <ostream>
#include <utility>

#include "grtx/base/error.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using ::testing::MatchesRegex;

/// Answers every lane twice, or the next lane, too.
class Hasty final : public modules::IntersectionModule {
 public:
  Hasty(const char* name, modules::LaneId other) : IntersectionModule(name), other_(other) {}
  void enqueue(Cycle now, modules::LaneId id, unsigned) override {
    lanes_.push_back(id);
    due_ = now + 1;
  }
  void tick(Cycle now) override {
    const std::deque<modules::LaneId> lanes = std::exchange(lanes_, {});
    due_ = modules::kNever;
    for (const modules::LaneId id : lanes) {
      client->unit_result(now, id);
      client->unit_result(now, other_ == 0 ? id : other_);
    }
  }
  bool idle() const override { return lanes_.empty(); }
  std::uint64_t progress() const override { return 0; }
  modules::IntersectionCounters counters() const override { return {}; }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << '\n'; }

 private:
  modules::LaneId other_;
  std::deque<modules::LaneId> lanes_;
};

std::string failure_of(const std::function<void(modules::RtUnitParts&)>& parts) {
  const test::ObservedRun run;
  ChildProcess child("simulation", [&]() -> std::string {
    SimulationOptions options;
    parts(options.build.parts.sm.rt_parts);
    try {
      simulate(run.path("t.grtx"), load_config(grtx::paths::source_dir() + "/configs/small.toml", {}), options);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  });
  return child.result();
}

TEST(WrongAnswers, AreBlamedOnTheUnitThatGivesThem) {
  for (const modules::LaneId other : {modules::LaneId{0}, modules::LaneId{12345}}) {
    const auto with = [other](const char* name, const modules::RtUnitContext&) {
      return std::make_unique<Hasty>(name, other);
    };
    EXPECT_THAT(failure_of([&](modules::RtUnitParts& parts) { parts.ray_box = with; }),
                MatchesRegex("gpu\\.sm[0-9]+\\.rt\\.ray_box: .*at .*: has a result for lane [0-9]+, which asked for "
                             "none"));
    EXPECT_THAT(failure_of([&](modules::RtUnitParts& parts) { parts.ray_transform = with; }),
                MatchesRegex("gpu\\.sm[0-9]+\\.rt\\.ray_transform: .*: has a result for lane [0-9]+, which asked for "
                             "none"));
  }
}

}  // namespace
}  // namespace grtx::sim
