// SPDX-License-Identifier: Apache-2.0
// The bridge from a unit's interface to the pins of a clocked block; the block has the shape of Verilator's classes.
//   own_block TRACE.grtx
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <memory>
#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/intersection/intersection_if.h"
#include "grtx/rtl_tlm/rtl/clocked_model.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

using grtx::Cycle;
using grtx::modules::LaneId;

/// A pipeline of four stages that takes a lane a cycle.
struct Block {
  explicit Block(const char*) {}
  void eval() {
    if (clk == 1 && before_ == 0) {
      for (int i = 3; i > 0; --i) stage_[i] = rst != 0 ? 0 : stage_[i - 1];
      stage_[0] = rst == 0 && in_valid != 0 ? (std::uint64_t{1} << 32 | in_lane) : 0;
    }
    before_ = clk;
    out_valid = stage_[3] != 0;
    out_lane = static_cast<std::uint32_t>(stage_[3]);
    idle = (stage_[0] | stage_[1] | stage_[2] | stage_[3]) == 0;
  }
  void final() {}
  std::uint8_t clk = 0, rst = 0, in_valid = 0, out_valid = 0, idle = 1;
  std::uint32_t in_lane = 0, out_lane = 0;

 private:
  std::uint8_t before_ = 0;
  std::uint64_t stage_[4] = {};
};

class OwnBox final : public grtx::modules::IntersectionModule {
 public:
  explicit OwnBox(const sc_core::sc_module_name& name) : IntersectionModule(name), block_("block") { block_.reset(); }
  void enqueue(Cycle now, LaneId id, unsigned) override {
    waiting_.push_back(id);
    due_ = std::min(due_, now + 1);
  }
  void tick(Cycle now) override {
    Block& pins = block_.pins();
    pins.in_valid = waiting_.empty() ? 0 : 1;
    if (!waiting_.empty()) pins.in_lane = waiting_.front();
    block_.settle();
    const bool result = pins.out_valid != 0;
    const LaneId lane = static_cast<LaneId>(pins.out_lane);
    if (!waiting_.empty()) {
      waiting_.pop_front();
      ++operations_;
    }
    block_.edge();
    due_ = idle() ? grtx::modules::kNever : now + 1;
    if (result) client->unit_result(now, lane);
  }
  bool idle() const override { return waiting_.empty() && block_->idle != 0; }
  std::uint64_t progress() const override { return operations_; }
  grtx::modules::IntersectionCounters counters() const override { return {}; }
  void count(grtx::modules::OwnCounts& own) const override {
    own.add("own_box.operations", operations_, "operations", "of the block");
  }
  void restart() override {
    block_.reset();
    waiting_.clear();
    operations_ = 0;
    due_ = grtx::modules::kNever;
  }
  grtx::modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << waiting_.size() << " lanes wait\n"; }

 private:
  grtx::sim::ClockedModel<Block> block_;
  std::deque<LaneId> waiting_;
  std::uint64_t operations_ = 0;
};

int run(int argc, char** argv) {
  if (argc != 2) throw grtx::Error("own_block", "arguments", "TRACE.grtx");
  grtx::sim::SimulationOptions options;
  options.build.parts.sm.rt_parts.ray_box = [](const char* name, const grtx::modules::RtUnitContext&) {
    return std::make_unique<OwnBox>(name);
  };
  const auto result = grtx::sim::simulate(argv[1], grtx::sim::load_config("", {"gpu.sms=2"}), options);
  for (const std::string& violation : result.violations) std::printf("%s\n", violation.c_str());
  const double operations = result.document.at("stats").at("gpu.rt.own_box.operations").at("value").get<double>();
  std::printf("%llu cycles, %.0f operations\n", static_cast<unsigned long long>(result.cycles), operations);
  return result.violations.empty() && operations > 0 ? 0 : 1;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
