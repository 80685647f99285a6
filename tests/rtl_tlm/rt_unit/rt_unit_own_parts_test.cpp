// SPDX-License-Identifier: Apache-2.0
// Parts of a user's own in the RT unit: made by factories, no file of the project edited.
#include <gtest/gtest.h>

#include <memory>
#include <ostream>
#include <utility>

#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "rtl_tlm/rt_unit/rt_bench.h"
#include "traces/random_group.h"

namespace grtx::sim {
namespace {

using namespace test;
using modules::IntersectionModule;
using modules::RtUnitContext;

class RtUnitOwnParts : public modules::SystemCTest {};

/// Answers every request after a fixed time, however many there are: a ray-box unit without contention.
class IdealUnit final : public IntersectionModule {
 public:
  IdealUnit(const sc_core::sc_module_name& name, Cycle latency) : IntersectionModule(name), latency_(latency) {}

  void enqueue(Cycle now, modules::LaneId id, unsigned /*tests*/) override {
    flights_.emplace_back(now + 1 + latency_, id);
    due_ = flights_.front().first;
  }
  void tick(Cycle now) override {
    while (!flights_.empty() && flights_.front().first <= now) {
      const modules::LaneId id = flights_.front().second;
      flights_.pop_front();
      ++answered;
      client->unit_result(now, id);
    }
    due_ = flights_.empty() ? modules::kNever : flights_.front().first;
  }
  bool idle() const override { return flights_.empty(); }
  std::uint64_t progress() const override { return answered; }
  modules::IntersectionCounters counters() const override { return {.operations = answered}; }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << flights_.size() << " in flight\n"; }

  std::uint64_t answered = 0;

 private:
  Cycle latency_;
  std::deque<std::pair<Cycle, modules::LaneId>> flights_;
};

std::vector<traces::RayGroup> some_groups(traces::Header& header) {
  traces::testing::RandomOptions random{.seed = 5, .groups = 6, .warp_size = 32};
  auto trace = traces::testing::random_trace(random);
  header = trace.header;
  return std::move(trace.groups);
}

struct Outcome {
  Cycle cycles = 0;
  modules::RtUnitCounters counters;
};

Outcome traced(const BenchOptions& options) {
  traces::Header header;
  const auto groups = some_groups(header);
  RtBench bench(header, options);
  for (std::uint16_t slot = 0; slot < groups.size(); ++slot) bench.launch(groups[slot], slot);
  bench.run();
  Outcome outcome{bench.dones.back().cycle, bench.counters()};
  return outcome;
}

TEST_F(RtUnitOwnParts, ABoxUnitOfTheUsersTakesThePlaceOfOurs) {
  const Outcome ours = traced({});
  BenchOptions options;
  options.parts.ray_box = [](const char* name, const RtUnitContext& rt) {
    return std::make_unique<IdealUnit>(name, rt.config.ray_box.latency);
  };
  const Outcome ideal = traced(options);
  EXPECT_EQ(ideal.counters.ray_box.operations, ours.counters.ray_box.operations) << "every visit is answered once";
  EXPECT_GT(ideal.counters.ray_box.operations, 0u);
  EXPECT_EQ(ideal.counters.scheduler.events(), ours.counters.scheduler.events());
  EXPECT_LE(ideal.cycles, ours.cycles) << "a unit without contention is not slower";

  options.parts.ray_box = [](const char* name, const RtUnitContext&) { return std::make_unique<IdealUnit>(name, 500); };
  EXPECT_GT(traced(options).cycles, ours.cycles) << "a slow one is";
}

/// The project's own unit, made by the user: exactly the same run.
TEST_F(RtUnitOwnParts, OurOwnUnitFromAFactoryIsTheSameRun) {
  const Outcome ours = traced({});
  BenchOptions options;
  options.parts.ray_box = [](const char* name, const RtUnitContext& rt) {
    return std::make_unique<modules::IntersectionUnit>(name, rt.config.ray_box, rt.config.warp_buffer.entries,
                                                       modules::ray_box_path(rt.header.bvh_width));
  };
  const Outcome same = traced(options);
  EXPECT_EQ(same.cycles, ours.cycles);
  EXPECT_EQ(same.counters.ray_box.busy_cycles, ours.counters.ray_box.busy_cycles);
}

TEST_F(RtUnitOwnParts, AFactoryThatMakesNothingIsRefused) {
  traces::Header header;
  some_groups(header);
  BenchOptions options;
  options.parts.ray_box = [](const char*, const RtUnitContext&) { return std::unique_ptr<IntersectionModule>(); };
  EXPECT_THROW(RtBench(header, options), Error);
}

}  // namespace
}  // namespace grtx::sim
