// SPDX-License-Identifier: Apache-2.0
// Bench for the SIMT core: a mock RT unit that replays the any-hit calls of a group, a mock memory of fixed latency,
// and builders of small ray groups.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/traces/event.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {

/// One round of one ray, for handmade groups.
struct RoundScript {
  struct AnyHit {
    traces::LeafOutcome outcome;
    unsigned shifts = 0;
  };
  std::vector<AnyHit> any_hits;
  std::vector<traces::Processed> processed;
  unsigned preloaded = 0;
  unsigned eviction_dropped = 0;
};

inline traces::Processed seen(std::uint32_t gaussian, bool blended) {
  traces::Processed p{.gaussian = gaussian & 0x7FFFFFFFU, .blended = blended ? 1u : 0u};
  return p;
}

/// k_count follows from the script: preloaded entries plus insertions.
inline traces::Ray make_ray(std::uint32_t pixel, const std::vector<RoundScript>& rounds) {
  traces::Ray ray;
  ray.pixel = pixel;
  for (const RoundScript& script : rounds) {
    traces::Round round;
    round.preloaded = static_cast<std::uint16_t>(script.preloaded);
    round.k_count = round.preloaded;
    round.eviction_dropped = script.eviction_dropped;
    round.processed_count = static_cast<std::uint16_t>(script.processed.size());
    for (const RoundScript::AnyHit& hit : script.any_hits) {
      traces::Event event;
      event.kind_shifts = traces::Event::pack(traces::EventKind::visit_leaf, hit.shifts);
      event.detail = static_cast<std::uint8_t>(hit.outcome);
      ray.events.push_back(event);
      ++round.event_count;
      if (hit.outcome == traces::LeafOutcome::inserted) ++round.k_count;
    }
    ray.processed.insert(ray.processed.end(), script.processed.begin(), script.processed.end());
    ray.rounds.push_back(round);
  }
  return ray;
}

/// `lanes` rays with the same rounds, at pixels 0, 1, 2, ...
inline traces::RayGroup uniform_group(unsigned lanes, const std::vector<RoundScript>& rounds) {
  traces::RayGroup group;
  for (unsigned lane = 0; lane < lanes; ++lane) group.rays.push_back(make_ray(lane, rounds));
  return group;
}

inline traces::Header simt_header() {
  traces::Header header;
  header.k = 4;
  header.checkpoint = false;
  header.width = 64;
  header.height = 64;
  header.node_image_bytes = 1 << 16;
  header.gaussians = 1000;
  header.sh_record_bytes = 12;
  return header;
}

inline traces::Header checkpointing(traces::Header header) {
  header.checkpoint = true;
  header.checkpoint_capacity = 512;
  return header;
}

class SimtBench {
 public:
  struct Options {
    traces::Header header = simt_header();
    SimtCoreConfig config;
    unsigned response_latency = 19;  ///< a request is answered 1 + response_latency cycles after it was sent
    unsigned trace_cycles = 100;     ///< from a TraceCall or the last AnyHitDone to TraceDone
    bool split_batches = false;      ///< any-hit batches of the even and the odd lanes at the same time
    bool idle_skip = true;
    unsigned order = 0;          ///< construction order of the processes
    unsigned out_capacity = 64;  ///< of the links that the core pushes into
  };

  explicit SimtBench(const Options& o)
      : options(o),
        clock("clock", 1365.0, o.idle_skip),
        map(o.header, {o.config.sm + 1, o.config.resident_warps, 0}),
        launch("launch", 1, 64),
        ended("ended", 1, o.out_capacity),
        trace_call("trace_call", 1, o.out_capacity),
        trace_done("trace_done", 1, 64),
        any_hit_batch("any_hit_batch", 1, 64),
        any_hit_done("any_hit_done", 1, o.out_capacity),
        memory_request("memory_request", 1, 4),
        memory_response("memory_response", o.response_latency, 4096) {
    std::vector<std::function<void()>> makers = {
        [&] { core = std::make_unique<SimtCore>("core", clock, o.config, o.header, map); },
        [&] { add("memory", [this](Cycle now) { serve_memory(now); }).watch(memory_request); },
        [&] {
          TickProcess& rt_unit = add("rt_unit", [this](Cycle now) { serve_traces(now); });
          rt_unit.watch(trace_call);
          rt_unit.watch(any_hit_done);
        },
        [&] { add("distributor", [this](Cycle now) { distribute(now); }).watch(ended); }};
    for (unsigned i = 0; i < makers.size(); ++i) makers[(i + o.order) % makers.size()]();
    core->launch.bind(launch);
    core->ended.bind(ended);
    core->trace_call.bind(trace_call);
    core->trace_done.bind(trace_done);
    core->any_hit_batch.bind(any_hit_batch);
    core->any_hit_done.bind(any_hit_done);
    core->memory_request.bind(memory_request);
    core->memory_response.bind(memory_response);
  }

  /// The core sees the launch in cycle `visible` (>= 1).
  void start(unsigned slot, const traces::RayGroup& group, Cycle visible = 1) {
    launches[visible - 1].push_back({&group, static_cast<std::uint16_t>(slot)});
    clock.request(visible - 1);
    ++started;
  }
  void run(Cycle cycles = 1'000'000) {
    const sc_core::sc_time end = sc_core::sc_time::from_value(cycles * clock.period_fs());
    while (sc_core::sc_pending_activity() && sc_core::sc_time_stamp() < end && ends.size() < started) {
      sc_core::sc_start(sc_core::sc_time_to_pending_activity());
    }
  }

  /// From a request's push to the visibility of its response.
  Cycle memory_latency() const { return 1 + options.response_latency; }

  Options options;
  ClockDomain clock;
  MemoryMap map;
  Link<LaunchWarp> launch;
  Link<WarpEnded> ended;
  Link<TraceCall> trace_call;
  Link<TraceDone> trace_done;
  Link<AnyHitBatch> any_hit_batch;
  Link<AnyHitDone> any_hit_done;
  Link<MemoryRequest> memory_request;
  Link<MemoryResponse> memory_response;
  std::unique_ptr<SimtCore> core;

  template <typename T>
  using Log = std::vector<std::pair<Cycle, T>>;  ///< with the cycle in which the receiver sees it
  Log<TraceCall> calls;
  Log<AnyHitDone> any_hits_done;
  Log<WarpEnded> ends;
  Log<MemoryRequest> requests;
  Log<AnyHitBatch> batches;  ///< with the cycle in which the core sees it

 private:
  struct Warp {
    TraceCall call;
    std::array<std::size_t, kMaxLanes> next_event{};  ///< in Ray::events, carried over rounds
    std::array<std::size_t, kMaxLanes> end_event{};
    LaneMask waiting = 0;
    bool active = false;
  };

  TickProcess& add(const char* name, std::function<void(Cycle)> body) {
    processes.push_back(std::make_unique<TickProcess>(name, clock, std::move(body)));
    return *processes.back();
  }
  template <typename T>
  void push(Link<T>& link, Cycle now, const T& item) {
    link.push(now, item);
    clock.request(now + link.latency());
  }

  void serve_memory(Cycle now) {
    for (const MemoryRequest* request; (request = memory_request.front(now)) != nullptr; memory_request.pop(now)) {
      requests.push_back({now, *request});
      MemoryResponse response{
          .address = request->address, .tag = request->tag, .region = request->region, .write = request->write};
      push(memory_response, now, response);
    }
  }

  void distribute(Cycle now) {
    for (const WarpEnded* end; (end = ended.front(now)) != nullptr; ended.pop(now)) ends.push_back({now, *end});
    if (const auto due = launches.find(now); due != launches.end()) {
      for (const LaunchWarp& warp : due->second) {
        push(launch, now, warp);
        rt_warps[warp.slot] = {};
      }
      launches.erase(due);
    }
  }

  void serve_traces(Cycle now) {
    for (const AnyHitDone* done; (done = any_hit_done.front(now)) != nullptr; any_hit_done.pop(now)) {
      any_hits_done.push_back({now, *done});
      Warp& warp = rt_warps[done->slot];
      EXPECT_EQ(warp.waiting & done->lanes, done->lanes);
      warp.waiting &= ~done->lanes;
      if (warp.waiting == 0) advance(warp, now);
    }
    for (const TraceCall* call; (call = trace_call.front(now)) != nullptr; trace_call.pop(now)) {
      calls.push_back({now, *call});
      Warp& warp = rt_warps[call->slot];
      EXPECT_FALSE(warp.active);
      warp.call = *call;
      warp.active = true;
      for_each_bit(call->lanes, [&](unsigned lane) {
        const traces::Ray& ray = call->group->rays[lane];
        EXPECT_EQ(warp.next_event[lane], warp.end_event[lane]);
        warp.end_event[lane] += ray.rounds[call->round].event_count;
      });
      advance(warp, now);
    }
    if (const auto due = finishing.find(now); due != finishing.end()) {
      for (const std::uint16_t slot : due->second) {
        push(trace_done, now, TraceDone{slot, rt_warps[slot].call.round});
        rt_warps[slot].active = false;
      }
      finishing.erase(due);
    }
  }

  static bool is_any_hit(const traces::Event& event) {
    return event.kind() == traces::EventKind::visit_leaf && traces::calls_any_hit(event.outcome());
  }

  /// Sends the next any-hit call of every lane that has one, or finishes the round.
  void advance(Warp& warp, Cycle now) {
    LaneMask lanes = 0;
    for_each_bit(warp.call.lanes, [&](unsigned lane) {
      const std::vector<traces::Event>& events = warp.call.group->rays[lane].events;
      std::size_t& next = warp.next_event[lane];
      while (next < warp.end_event[lane] && !is_any_hit(events[next])) ++next;
      if (warp.next_event[lane] < warp.end_event[lane]) lanes |= bit(lane);
    });
    if (lanes == 0) {
      finishing[now + options.trace_cycles].push_back(warp.call.slot);
      clock.request(now + options.trace_cycles);
      return;
    }
    warp.waiting = lanes;
    constexpr LaneMask kEven = 0x5555'5555'5555'5555U;
    const LaneMask parts[2] = {options.split_batches ? lanes & kEven : lanes,
                               options.split_batches ? lanes & ~kEven : 0};
    for (const LaneMask part : parts) {
      if (part == 0) continue;
      AnyHitBatch batch;
      batch.slot = warp.call.slot;
      batch.round = warp.call.round;
      batch.lanes = part;
      for_each_bit(part, [&](unsigned lane) {
        const traces::Event& event = warp.call.group->rays[lane].events[warp.next_event[lane]++];
        batch.outcome[lane] = event.outcome();
        batch.shifts[lane] = static_cast<std::uint16_t>(event.shifts());
      });
      batches.push_back({now + any_hit_batch.latency(), batch});
      push(any_hit_batch, now, batch);
    }
  }

  std::vector<std::unique_ptr<TickProcess>> processes;
  std::map<Cycle, std::vector<LaunchWarp>> launches;
  std::map<Cycle, std::vector<std::uint16_t>> finishing;
  std::map<unsigned, Warp> rt_warps;
  std::size_t started = 0;
};

}  // namespace grtx::modules
