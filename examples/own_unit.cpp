// SPDX-License-Identifier: Apache-2.0
// `grtx` with a ray-box unit of its own, which tests one node at a time and rests after each (docs/add-a-module.md).
//   own_unit sim TRACE.grtx --set rt.resting_box.rest=3 --stats S.json --vcd W.vcd
#include <deque>
#include <memory>
#include <ostream>

#include "grtx/apps/grtx/program.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

using namespace grtx;
using namespace grtx::modules;

namespace {

class RestingBox final : public IntersectionModule, public Probed {
 public:
  struct Config {
    unsigned latency = 13;
    unsigned rest = 1;
    void parameters(ParameterList& list) {
      list.add("latency", latency, {1, kMaxLatency}, "cycles", "of a test", kOurs);
      list.add("rest", rest, {0, kMaxLatency}, "cycles", "between two tests", kOurs);
    }
  };
  RestingBox(const sc_core::sc_module_name& name, const Config& config) : IntersectionModule(name), config_(config) {}

  void enqueue(Cycle now, LaneId id, unsigned tests) override {
    waiting_.emplace_back(id, tests);
    due_ = std::min(due_, now + 1);
  }
  void tick(Cycle now) override {
    while (!flights_.empty() && flights_.front().first <= now) {
      client->unit_result(now, flights_.front().second);
      flights_.pop_front();
    }
    if (!waiting_.empty() && free_from_ <= now) {
      const auto [id, tests] = waiting_.front();
      waiting_.pop_front();
      tests_ += tests;
      rested_ += config_.rest;
      free_from_ = now + tests + config_.rest;
      flights_.emplace_back(now + tests - 1 + config_.latency, id);
    }
    due_ = flights_.empty() ? kNever : flights_.front().first;
    if (!waiting_.empty()) due_ = std::min(due_, std::max(now + 1, free_from_));
  }
  bool idle() const override { return waiting_.empty() && flights_.empty(); }
  std::uint64_t progress() const override { return tests_; }
  IntersectionCounters counters() const override { return {}; }  // its counts have names of their own:
  void count(OwnCounts& own) const override {
    own.add("resting_box.tests", tests_, "tests", "node tests", 21.0);  // picojoules each
    own.add("resting_box.rested", rested_, "cycles", "cycles of rest after a test");
  }
  void restart() override { waiting_ = {}, flights_ = {}, tests_ = rested_ = free_from_ = 0, due_ = kNever; }
  Inventory inventory() const override { return {name(), {}, {{"fp_mul", 32, 6}, {"fp_add", 32, 6}}}; }
  std::vector<UnitProbe> probes() const override {
    return {{"waiting", 16, [this] { return waiting_.size(); }}, {"rested", 48, [this] { return rested_; }}};
  }
  void dump_state(std::ostream& out) const override { out << name() << ": " << waiting_.size() << " lanes wait\n"; }

 private:
  Config config_;
  std::deque<std::pair<LaneId, unsigned>> waiting_;
  std::deque<std::pair<Cycle, LaneId>> flights_;  ///< ascending
  Cycle free_from_ = 0;
  std::uint64_t tests_ = 0, rested_ = 0;
};

}  // namespace

int sc_main(int argc, char** argv) {
  OwnKeys::add<RestingBox::Config>("rt.resting_box");
  grtx::sim::register_parts([](const grtx::sim::GpuConfig& config, grtx::sim::GpuParts& parts) {
    parts.sm.rt_parts.ray_box = [own = config.own.get<RestingBox::Config>()](const char* name, const RtUnitContext&) {
      return std::make_unique<RestingBox>(name, own);
    };
  });
  return grtx::program(argc, argv, grtx::kMachinesFolder);
}
