// SPDX-License-Identifier: Apache-2.0
// The plain RT unit in the surroundings of RtBench: a SIMT core that answers after a fixed time, memories of fixed
// latency, and a record of what the unit sent and when.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <utility>
#include <vector>

#include "grtx/modules/rt_unit/rt_unit.h"
#include "rtl_tlm/plain/rt_unit.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim::test {

class PlainRtBench {
 public:
  struct Done {
    unsigned slot, round;
    Cycle cycle;
    friend bool operator==(const Done&, const Done&) = default;
  };
  struct Batch {
    unsigned slot, round;
    std::uint64_t lanes;
    Cycle cycle;
    friend bool operator==(const Batch&, const Batch&) = default;
  };
  struct Request {
    std::uint64_t address;
    bool write;
    Cycle cycle;
    friend bool operator==(const Request&, const Request&) = default;
  };
  std::vector<Done> dones;
  std::vector<Batch> batches;
  std::vector<Request> requests[4];  ///< by client: node, checkpoint, prefetch, stack

  PlainRtBench(const traces::Header& header, const BenchOptions& options)
      : header_(header),
        map_(header_, 1, static_cast<unsigned>(options.resident_warps), 0, options.rt.warp_buffer.spill ? 128 : 0,
             options.rt.checkpoint.entry_bytes, false, false),
        any_hit_cycles_(options.any_hit_cycles),
        ports_(4,
               {plain::Channel<plain::Access>(1, 4), plain::Channel<plain::Access>(options.memory_latency - 1, 4096)}),
        unit_(options.rt, header_, map_, 0, messages_, {&ports_[0], &ports_[1], &ports_[2], &ports_[3]}) {}

  void launch(const traces::RayGroup& group, unsigned slot) {
    to_call_.push_back({&group, slot, 0});
    groups_.resize(std::max<std::size_t>(groups_.size(), slot + std::size_t{1}));
    groups_[slot] = &group;
  }
  void run(Cycle limit) {
    for (Cycle now = 0; now < limit; ++now) {
      simt(now);
      memory(now);
      unit_.tick(now);
      if (to_call_.empty() && pending_ == 0 && unit_.idle()) return;
    }
    throw std::runtime_error("the plain RT unit does not come to an end");
  }

 private:
  // What is seen here was sent in the cycle before.
  void simt(Cycle now) {
    while (messages_.dones.front(now) != nullptr) {
      const plain::TraceDone done = messages_.dones.pop(now);
      dones.push_back({done.slot, done.round, now - 1});
      --pending_;
      const auto& rays = groups_[done.slot]->rays;
      const auto goes_on = [&](const traces::Ray& ray) { return ray.rounds.size() > done.round + 1; };
      if (std::any_of(rays.begin(), rays.end(), goes_on)) {
        to_call_.push_back({groups_[done.slot], done.slot, done.round + 1});
      }
    }
    while (messages_.batches.front(now) != nullptr) {
      const plain::AnyHitBatch batch = messages_.batches.pop(now);
      std::uint64_t lanes = 0;
      for (const auto& call : batch.calls) lanes |= std::uint64_t{1} << call.lane;
      batches.push_back({batch.slot, batch.round, lanes, now - 1});
      shaders_.push_back({now + any_hit_cycles_, {batch.slot, batch.calls}});
    }
    if (!shaders_.empty() && shaders_.front().first <= now && messages_.shaded.has_room(now)) {
      messages_.shaded.push(now, shaders_.front().second);
      shaders_.pop_front();
    }
    if (!to_call_.empty() && messages_.calls.has_room(now)) {
      messages_.calls.push(now, to_call_.front());
      to_call_.pop_front();
      ++pending_;
    }
  }
  void memory(Cycle now) {
    for (unsigned c = 0; c < 4; ++c) {
      while (ports_[c].request.front(now) != nullptr) {
        const plain::Access access = ports_[c].request.pop(now);
        requests[c].push_back({access.address, access.write, now - 1});
        ports_[c].response.push(now, access);
      }
    }
  }

  traces::Header header_;
  plain::AddressMap map_;
  unsigned any_hit_cycles_;
  plain::RtMessages messages_{1, 2};
  std::vector<plain::MemoryPort> ports_;
  plain::RtUnit unit_;
  std::vector<const traces::RayGroup*> groups_;
  std::deque<plain::TraceCall> to_call_;
  std::deque<std::pair<Cycle, plain::AnyHitDone>> shaders_;
  std::size_t pending_ = 0;
};

}  // namespace grtx::sim::test
