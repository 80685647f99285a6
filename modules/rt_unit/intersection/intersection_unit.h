// SPDX-License-Identifier: Apache-2.0
// Intersection unit of the RT unit: `count` identical pipelines (ray-box, ray-triangle, ray-sphere, ray-Gaussian or
// ray-transform) shared by all warps, behind one in-order queue. Paper: Section IV-B, "three types of fixed-function
// units". Cost: the operators of one test per pipeline, and the queue.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/rt_unit/intersection/decide/intersection_config.h"
#include "grtx/modules/rt_unit/intersection/intersection_if.h"

namespace grtx::modules {

/// State of the project's intersection units (SystemC and RTL) after a cycle, for observers.
class IntersectionState : public Probed {
 public:
  virtual std::size_t lanes() const = 0;  ///< of the warp buffer
  virtual bool idle() const = 0;
  virtual std::size_t queued() const = 0;     ///< lanes waiting for a pipeline
  virtual std::size_t in_flight() const = 0;  ///< lanes whose result is not due yet
  /// Pipelines that cannot start a test in cycle `now`, or have started one in it.
  virtual unsigned busy_pipelines(Cycle now) const = 0;
  std::vector<UnitProbe> probes() const final;

 protected:
  ~IntersectionState() = default;
};

class IntersectionUnit final : public IntersectionModule, public IntersectionState {
 public:
  using Config = IntersectionConfig;
  using Counters = IntersectionCounters;

  /// entries: warps of the warp buffer. path: hardware of one pipeline. input: how tests come here.
  IntersectionUnit(const sc_core::sc_module_name& name, const Config& config, unsigned entries, DataPath path,
                   const TestInput& input = {});

  /// The tests of a request run one after another in one pipeline.
  void enqueue(Cycle now, LaneId id, unsigned tests) override {
    if (queue_.empty()) due_ = std::min(due_, std::max(now + 1, next_free_));
    queue_.push({now, id, static_cast<std::uint16_t>(tests), node_});
    if (queue_.size() > counters_.queue_max) counters_.queue_max = queue_.size();
  }
  void begin_node() override { ++node_; }
  void tick(Cycle now) override;

  bool idle() const override { return queue_.empty() && flights_.empty(); }
  std::size_t lanes() const override { return lanes_; }
  std::size_t queued() const override { return queue_.size(); }
  std::size_t in_flight() const override { return flights_.size(); }
  unsigned busy_pipelines(Cycle now) const override {
    return static_cast<unsigned>(
        std::count_if(free_from_.begin(), free_from_.end(), [now](Cycle free_from) { return free_from > now; }));
  }
  Counters counters() const override { return counters_; }
  std::uint64_t progress() const override { return counters_.operations; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct Request {
    Cycle queued = 0;
    LaneId lane = 0;
    std::uint16_t tests = 1;
    std::uint32_t node = 0;
  };
  /// What is read in a cycle.
  struct Reads {
    LaneMask banks = 0;
    unsigned nodes = 0;
    std::uint32_t node = 0;
  };
  struct Flight {
    Cycle due = 0;
    LaneId lane = 0;
  };
  void end_of_elaboration() override { client_ = client.operator->(); }
  void start_queued(Cycle now);
  /// Whether ray and node of the request can be read in this cycle, too.
  bool read(const Request& request, Reads& reads) const;

  Config config_;
  DataPath path_;
  TestInput input_;
  bool limited_;  ///< input_ lets not all tests in that find a pipeline
  intersection_client_if* client_ = nullptr;
  RingQueue<Request> queue_;      ///< at most one per lane of the warp buffer
  RingQueue<Flight> flights_;     ///< in order of due cycles
  std::vector<Cycle> free_from_;  ///< [pipeline]
  Cycle next_free_ = 0;           ///< lower bound of free_from_
  std::uint32_t node_ = 0;        ///< of the requests that come
  std::size_t lanes_;             ///< lanes of the warp buffer
  Counters counters_;
};

/// Storage and operators of a unit. lanes: number of lanes in the warp buffer.
Inventory intersection_inventory(const char* name, const IntersectionConfig& config, const DataPath& path,
                                 std::uint64_t lanes, const TestInput& input = {});

}  // namespace grtx::modules
