// SPDX-License-Identifier: Apache-2.0
// A unit of a user's between the node port of each RT unit and the L1: it is in the statistics, laws, bounds and
// differences like a part of the project (docs/add-a-module.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <ostream>
#include <string>

#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/rt_unit/node_port/node_port_if.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/rtl_tlm/regress/statistics_difference.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using modules::MemoryRequest;
using modules::MemoryResponse;

/// Keeps the node sectors that its RT unit read last.
class NodeBuffer final : public modules::NodePortModule {
 public:
  NodeBuffer(const sc_core::sc_module_name& name, std::size_t entries, modules::ClockDomain& clock)
      : NodePortModule(name, clock), entries_(entries) {}

  bool idle() const override { return outstanding_ == 0; }
  std::uint64_t progress() const override { return hits_ + misses_; }
  void count(modules::OwnCounts& own) const override {
    own.add("node_buffer.hits", hits_, "sectors", "node sectors found in the node buffer", 0.9);
    own.add("node_buffer.misses", misses_, "sectors", "node sectors asked of the L1", 0.9);
  }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << outstanding_ << " outstanding\n"; }

 private:
  void end_of_elaboration() override {
    requests_ = modules::reader_of(request);
    responses_ = modules::writer_of(response);
    down_ = modules::writer_of(to_l1);
    up_ = modules::reader_of(from_l1);
    requests_.wake(&alarm_);
    up_.wake(&alarm_);
  }
  Cycle tick(Cycle now) override {
    const MemoryResponse* const fill = up_.front(now);
    const bool port_taken = fill != nullptr && responses_.can_push(now);
    if (port_taken) {
      keep(fill->address);
      responses_.push(now, *fill);
      up_.pop(now);
      --outstanding_;
    }
    if (const MemoryRequest* const head = requests_.front(now)) take(now, *head, port_taken);
    return std::max(now + 1, std::min(requests_.next_visible(), up_.next_visible()));
  }
  void take(Cycle now, const MemoryRequest& head, bool port_taken) {
    const auto found = std::find(recent_.begin(), recent_.end(), head.address);
    if (found != recent_.end()) {
      if (port_taken || !responses_.can_push(now)) return;
      MemoryResponse answer;
      answer.address = head.address;
      answer.tag = head.tag;
      answer.region = head.region;
      responses_.push(now, answer);
      ++hits_;
    } else {
      if (!down_.can_push(now)) return;
      down_.push(now, head);
      ++outstanding_;
      ++misses_;
    }
    requests_.pop(now);
  }
  void keep(std::uint64_t address) {
    std::erase(recent_, address);
    recent_.push_back(address);
    if (recent_.size() > entries_) recent_.pop_front();
  }
  void restart(modules::Caches /*caches*/) override {
    recent_.clear();
    hits_ = misses_ = 0;
  }

  std::size_t entries_;
  std::deque<std::uint64_t> recent_;  ///< addresses, the last one last
  std::uint64_t hits_ = 0, misses_ = 0, outstanding_ = 0;
  modules::LinkReader<MemoryRequest> requests_;
  modules::LinkWriter<MemoryResponse> responses_;
  modules::LinkWriter<MemoryRequest> down_;
  modules::LinkReader<MemoryResponse> up_;
};

TEST(NodePort, AUnitThatAnswersNodesItselfConservesAndBringsItsBoundAndItsName) {
  modules::add_part([](const modules::OwnKeys&) {
    modules::PartInfo part;
    part.name = "node_buffer";
    part.title = "node buffer";
    part.statistics = {"gpu.l1.node_buffer."};
    part.bounds = {{.name = "node_buffer",
                    .statistics = {"gpu.rt.node_sectors"},
                    .limit = modules::PartBound::Limit::port,
                    .description = "a sector a cycle",
                    .words = "the node buffer"}};
    part.kept_nodes = "node_buffer.hits";
    return part;
  });
  const test::ObservedRun run(true, true);
  const auto without = run.run({});
  SimulationOptions options;
  options.build.parts.sm.node_port = [](const char* name, modules::ClockDomain& clock) {
    return std::make_unique<NodeBuffer>(name, 64, clock);
  };
  const auto with = run.run(options);  // fails when a conservation law does not hold
  const std::uint64_t hits = test::statistic(with, "gpu.l1.node_buffer.hits");
  const std::uint64_t sectors = test::statistic(with, "gpu.rt.node_sectors");
  EXPECT_GT(hits, 0u);
  EXPECT_EQ(test::statistic(with, "gpu.l1.node.reads") + hits, sectors);
  EXPECT_EQ(test::statistic(with, "gpu.l1.node_buffer.misses") + hits, sectors);
  EXPECT_EQ(test::statistic(without, "gpu.l1.node.reads"), test::statistic(without, "gpu.rt.node_sectors"));
  EXPECT_GT(test::statistic(with, "gpu.bound.node_buffer"), 0u);
  EXPECT_STREQ(unit_of_statistic("gpu.l1.node_buffer.hits").name, "node buffer");
}

}  // namespace
}  // namespace grtx::sim
