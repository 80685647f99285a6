// The surroundings of RtBench for the plain RT unit: a SIMT core that answers any-hit batches after a fixed time, and
// memories of fixed latency.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <utility>
#include <vector>

#include "rtl_tlm/plain/rt_unit.h"

namespace grtx::sim::plain {

class RtBench {
 public:
  struct Done {
    unsigned slot, round;
    Cycle cycle;  ///< in which the RT unit retired the warp
    friend bool operator==(const Done&, const Done&) = default;
  };
  struct Batch {
    unsigned slot, round;
    std::uint64_t lanes;
    Cycle cycle;  ///< in which the RT unit sent it
    friend bool operator==(const Batch&, const Batch&) = default;
  };
  struct Request {
    std::uint64_t address;
    bool write;
    Cycle cycle;  ///< in which the RT unit sent it
    friend bool operator==(const Request&, const Request&) = default;
  };
  std::vector<Done> dones;
  std::vector<Batch> batches;
  std::vector<Request> requests[4];  ///< node, checkpoint, prefetch, stack

  /// memory_latency: from a request's issue until its answer is visible, at least 2.
  RtBench(const modules::RtUnitConfig& config, const traces::Header& header, unsigned slots, unsigned memory_latency,
          unsigned any_hit_cycles)
      : header_(header),
        map_(header_, 1, slots, 0, config.warp_buffer.spill),
        any_hit_cycles_(any_hit_cycles),
        ports_(4, {Channel<Access>(1, 4), Channel<Access>(memory_latency - 1, 4096)}),
        rt_(config, header_, map_, 0, messages_, {&ports_[0], &ports_[1], &ports_[2], &ports_[3]}) {}

  void launch(const traces::RayGroup& group, unsigned slot) { to_call_.push_back({&group, slot, 0}); }
  void run(Cycle limit) {
    for (Cycle now = 0; now < limit; ++now) {
      shaders(now);
      memories(now);
      rt_.tick(now);
      if (to_call_.empty() && running_ == 0 && rt_.idle()) return;
    }
    throw std::runtime_error("the plain RT unit does not come to an end");
  }

 private:
  void shaders(Cycle now) {
    while (messages_.dones.front(now) != nullptr) {
      const TraceDone done = messages_.dones.pop(now);
      dones.push_back({done.slot, done.round, now - 1});
      --running_;
      const auto called =
          std::find_if(called_.begin(), called_.end(), [&](const TraceCall& c) { return c.slot == done.slot; });
      const TraceCall next{called->group, done.slot, done.round + 1};
      called_.erase(called);
      const bool more = std::any_of(next.group->rays.begin(), next.group->rays.end(),
                                    [&](const traces::Ray& ray) { return ray.rounds.size() > next.round; });
      if (more) to_call_.push_back(next);
    }
    while (messages_.batches.front(now) != nullptr) {
      const AnyHitBatch batch = messages_.batches.pop(now);
      batches.push_back({batch.slot, batch.round, 0, now - 1});
      for (const auto& call : batch.calls) batches.back().lanes |= std::uint64_t{1} << call.lane;
      shading_.push_back({now + any_hit_cycles_, {batch.slot, batch.calls}});
    }
    if (!shading_.empty() && shading_.front().first <= now && messages_.shaded.has_room(now)) {
      messages_.shaded.push(now, shading_.front().second);
      shading_.pop_front();
    }
    if (!to_call_.empty() && messages_.calls.has_room(now)) {
      messages_.calls.push(now, to_call_.front());
      called_.push_back(to_call_.front());
      to_call_.pop_front();
      ++running_;
    }
  }
  void memories(Cycle now) {
    for (std::size_t c = 0; c < ports_.size(); ++c) {
      while (ports_[c].request.front(now) != nullptr) {
        const Access access = ports_[c].request.pop(now);
        requests[c].push_back({access.address, access.write, now - 1});
        ports_[c].response.push(now, access);
      }
    }
  }

  traces::Header header_;
  AddressMap map_;
  unsigned any_hit_cycles_;
  RtMessages messages_{1, 2};
  std::vector<MemoryPort> ports_;
  RtUnit rt_;
  std::deque<TraceCall> to_call_;
  std::vector<TraceCall> called_;
  std::deque<std::pair<Cycle, AnyHitDone>> shading_;
  std::size_t running_ = 0;
};

}  // namespace grtx::sim::plain
