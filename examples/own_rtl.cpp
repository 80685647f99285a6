// SPDX-License-Identifier: Apache-2.0
// A program that simulates a trace with a ray-box unit in SystemVerilog in place of the project's:
//   own_rtl TRACE.grtx [tlm]
// own_ray_box.sv is the block, OwnRayBox its bridge: each call of the interface becomes a transfer at the pins, each
// cycle an edge. tlm: with the project's unit of the same size, one pipeline of 13 cycles (docs/guide/own-rtl.md).
#include <Vown_ray_box.h>
#include <fmt/format.h>

#include <cstring>
#include <deque>
#include <memory>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/intersection/intersection_if.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/rtl_tlm/rtl/clocked_model.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

using grtx::Cycle;
using grtx::modules::LaneId;

class OwnRayBox final : public grtx::modules::IntersectionModule {
 public:
  explicit OwnRayBox(const sc_core::sc_module_name& name) : IntersectionModule(name), block_("own_ray_box") {
    block_.reset();
  }

  void enqueue(Cycle now, LaneId id, unsigned) override {
    waiting_.push_back({now, id});
    due_ = std::min(due_, now + 1);
  }

  // Called in each cycle from due_ on: one edge.
  void tick(Cycle now) override {
    Vown_ray_box& pins = block_.pins();
    const bool offered = !waiting_.empty() && waiting_.front().since < now;
    pins.in_valid = offered;
    if (offered) pins.in_lane = waiting_.front().lane;
    block_.settle();
    const bool started = offered && pins.in_ready;
    const bool result = pins.out_valid;
    const LaneId lane = pins.out_lane;
    block_.edge();
    if (started) {
      waiting_.pop_front();
      ++operations_;
    }
    due_ = idle() ? grtx::modules::kNever : now + 1;
    if (result) client->unit_result(now, lane);  // last: the scheduler goes on from here
  }

  bool idle() const override { return waiting_.empty() && block_->idle; }
  std::uint64_t progress() const override { return operations_; }
  grtx::modules::IntersectionCounters counters() const override {
    return {.operations = operations_, .tests = operations_, .busy_cycles = operations_};
  }
  void restart() override {
    block_.reset();
    waiting_.clear();
    due_ = grtx::modules::kNever;
    operations_ = 0;
  }
  grtx::modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << waiting_.size() << " lanes wait\n"; }

 private:
  struct Request {
    Cycle since;
    LaneId lane;
  };
  grtx::sim::ClockedModel<Vown_ray_box> block_;
  std::deque<Request> waiting_;
  std::uint64_t operations_ = 0;
};

int run(int argc, char** argv) {
  const bool tlm = argc == 3 && std::strcmp(argv[2], "tlm") == 0;
  if (argc != 2 && !tlm) throw grtx::Error("own_rtl", "arguments", "TRACE.grtx [tlm]");
  grtx::sim::SimulationOptions options;
  // The only lines that differ from a run with the project's unit.
  if (!tlm) {
    options.build.parts.sm.rt_parts.ray_box = [](const char* name, const grtx::modules::RtUnitContext&) {
      return std::make_unique<OwnRayBox>(name);
    };
  }
  const auto config = grtx::sim::load_config("", {"gpu.sms=2", "l2.slices=2", "rt.box.count=1", "rt.box.latency=13"});
  const grtx::sim::SimulationResult result = grtx::sim::simulate(argv[1], config, options);
  const double boxes = result.document.at("stats").at("gpu.rt.ray_box.operations").at("value");
  fmt::print("{} cycles, {} box operations\n", result.cycles, boxes);
  for (const std::string& violation : result.violations) fmt::print("{}\n", violation);
  return result.violations.empty() ? 0 : 1;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const grtx::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
}
