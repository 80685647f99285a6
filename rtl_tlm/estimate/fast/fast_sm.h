// What an SM holds in fast mode: calls of the RT unit, warps of the SIMT core, the L1 and its clients.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/sector_cache_tags.h"
#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/kernel/equal_keys.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/round_cursor.h"
#include "grtx/modules/rt_unit/checkpoint_layout.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/rt_unit/warp_buffer.h"
#include "grtx/modules/simt/issue_slots.h"
#include "grtx/modules/simt/shader_program.h"
#include "grtx/modules/simt/simt_counters.h"
#include "grtx/rtl_tlm/estimate/fast/bank_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/event_wheel.h"
#include "grtx/rtl_tlm/estimate/fast/near_cycle.h"
#include "grtx/rtl_tlm/estimate/fast/place_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/place_ring.h"
#include "grtx/rtl_tlm/estimate/fast/response_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/timed_share.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim::fast {

using Number = EventWheel::Number;

/// Of the L1, in the order of the cycle model's.
enum Client : unsigned { kNode, kSimt, kCheckpoint, kPrefetch, kClients };

inline constexpr Number kNobody = ~Number{0};

/// Sectors of one line, which an L1 client asks for.
struct Request {
  std::uint64_t line = 0;  ///< address
  Number owner = 0;        ///< lane, or warp; kNobody: an access that takes no time, behind those that do
  std::uint8_t sectors = 0;
  modules::Region region{};
  bool write = false;
  bool last = false;  ///< of a node fetch, or of what a lane reads of a checkpoint buffer
};
static_assert(sizeof(Request) == 16);

/// A client's port: one sector a cycle.
struct Port {
  modules::RingQueue<Request> queue;
  std::size_t timeless = 0;  ///< requests of kNobody in it
  std::size_t timed() const { return queue.size() - timeless; }
  Cycle next = 0;   ///< free from
  Cycle until = 0;  ///< refused until
};

/// The node fetches of a warp, each by the lane that asked first: until it has arrived, that lane asks for nothing
/// else.
struct Fetches {
  std::array<std::uint32_t, modules::kMaxLanes> key;
  std::array<NearCycle, modules::kMaxLanes> asked;
  std::array<NearCycle, modules::kMaxLanes> ready;      ///< the sectors that have been asked for have been seen
  std::array<std::uint32_t, modules::kMaxLanes> lanes;  ///< that wait for it to be asked for; 0: it has been

  void clear(Cycle now) {
    key.fill(~std::uint32_t{0});
    asked.fill(NearCycle(now));
    ready.fill(NearCycle(now));
    lanes.fill(0);
  }
  /// address: of the node. header: the BLAS header is read with it.
  static std::uint32_t key_of(std::uint64_t address, bool header) {
    return static_cast<std::uint32_t>(address / traces::kNodeUnit) << 1 | (header ? 1u : 0u);
  }
  /// Lanes whose fetch was or is for that node.
  std::uint32_t of_node(std::uint32_t wanted) const {
    static_assert(modules::kMaxLanes == 32);
    return modules::equal_keys(key.data(), wanted) | modules::equal_keys(key.data() + 16, wanted) << 16;
  }
};

/// Sectors of a line on their way into the L1. They take the line's place in the tags when all are there.
struct Fill {
  std::uint64_t line = 0;       ///< address
  std::uint8_t sectors = 0;     ///< mask
  std::uint8_t prefetched = 0;  ///< of these, which nobody has asked for
  std::array<NearCycle, 8> arrives;
  Cycle complete = 0;

  /// Those of `wanted` that come after cycle `now`; last: raised to the arrival of the last of them.
  std::uint8_t awaited(std::uint8_t wanted, Cycle now, Cycle& last) const {
    std::uint8_t late = 0;
    for (std::uint8_t rest = wanted; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
      const auto sector = static_cast<unsigned>(std::countr_zero(rest));
      const Cycle at = arrives[sector].at(now);
      if (at <= now) continue;
      last = std::max(last, at);
      late |= static_cast<std::uint8_t>(1u << sector);
    }
    return late;
  }
};

struct Lane {
  const traces::Event* next = nullptr;
  const traces::Event* end = nullptr;
  std::uint16_t sm = 0, entry = 0;
  std::uint16_t depth = 0;  ///< of the stack
  bool shaded = false;      ///< the any-hit shader has seen its hit
  bool settling = false;    ///< hands checkpoint entries over
  std::uint16_t owed = 0;   ///< events that take no time, before those of its next step
  bool begins = false;      ///< its first event that takes time is next
};

/// A lane's checkpoint buffers.
struct Checkpoints {
  modules::CheckpointLayout::Lane place;
  Cycle seen = 0;  ///< when the sectors asked for are there
};

/// A traceRay call of a warp, in an entry of the warp buffer.
struct Call {
  std::uint16_t slot = 0;
  modules::WarpWait wait = modules::WarpWait::ready;
  bool timing = false;  ///< the any-hit timer is in the wheel
  LaneMask active = 0;  ///< not finished
  LaneMask ready = 0, waiting_any_hit = 0, in_any_hit = 0,
           checkpointing = 0;  ///< of these; the others' nodes are on the way
  Cycle accepted = 0;
  Cycle selected = 0;       ///< last
  Cycle since = 0;          ///< first cycle whose wait has not been counted
  Cycle any_hit_since = 0;  ///< of the first lane that waits
  Fetches fetches;
};

enum class Step : std::uint8_t { launched, prologue, evict_move, trace_call, tracing, sort, blend, epilogue, draining };

/// A warp in a slot of the SIMT core.
struct Warp {
  const traces::RayGroup* group = nullptr;
  modules::RoundCursor cursor;
  std::uint64_t position = 0;  ///< of the group in the source
  Step step = Step::prologue;
  bool loading = false;     ///< the present phase's loads are on the way
  bool in_service = false;  ///< runs the any-hit shader
  LaneMask service_lanes = 0;
  unsigned entry = 0;
  modules::PhaseKind kind{};
  modules::WarpActivity activity{};
  Cycle since = 0;  ///< of the activity
  std::uint64_t instructions = 0;
  std::vector<modules::SectorAccess> stores;
  std::uint32_t loads_pending = 0, stores_pending = 0;  ///< requests
  Cycle loads_seen = 0, stores_seen = 0;
  // Of a phase in which one in so many requests takes time, and everything as much less of it.
  bool shortened = false;
  Cycle loads_from = 0;
  std::uint32_t loads_timed = 0;  ///< requests
};

/// Pipelines of one kind of intersection unit.
struct Unit {
  explicit Unit(const modules::IntersectionUnit::Config& c) : config(c), places(c.count, c.interval) {}
  /// When the result of tests is known on data that is there from cycle `ready` on.
  Cycle test(Cycle ready, unsigned tests) {
    Cycle start = places.reserve(ready + 1);
    counters.queue_cycles += start - (ready + 1);
    ++counters.operations;
    counters.tests += tests;
    counters.busy_cycles += Cycle{tests} * config.interval;
    for (unsigned i = 1; i < tests; ++i) start = places.reserve(start + config.interval);
    return start + config.latency;
  }
  modules::IntersectionUnit::Config config;
  SlotCalendar places;
  modules::IntersectionUnit::Counters counters;
};

struct Sm {
  Sm(const GpuConfig& config, const traces::Header& header, const modules::MemoryMap& map, unsigned index,
     traces::NodeKind leaf);
  static std::size_t fills_of(const GpuConfig& config);  ///< lines that may be on their way into the L1

  // ---- SIMT core
  modules::ShaderProgram program;
  modules::IssueSlots issue;
  std::vector<Warp> warps;
  LaneMask free_slots = 0;
  std::uint64_t launched = 0;
  modules::SimtCounters simt;
  AnyHitWork timed_any_hits, warming_any_hits;
  // ---- RT unit
  std::vector<Call> calls;
  std::vector<std::uint64_t> ages;  ///< by entry
  modules::RingQueue<std::uint16_t> waiting_calls;
  LaneMask free_entries = 0;
  LaneMask occupied = 0;
  unsigned oldest = 0;  ///< of the occupied entries
  LaneMask ready = 0;   ///< entries with lanes to be handled
  bool select_timed = false;
  std::size_t fetches = 0;            ///< nodes that have not been asked for
  modules::RingQueue<Cycle> leaving;  ///< when those that have been, ahead of time, leave the memory scheduler's queue
  PlaceRing link;                     ///< to the L1, for node requests
  Cycle link_pushed = 0;              ///< when the newest entered it
  Unit box, leaf, transform;
  SlotCalendar hand_over;  ///< of checkpoint entries
  Cycle accounted = 0;     ///< cycles before it are counted as selections or stalls
  modules::Stall last_stall{};
  modules::RtUnitCounters rt;
  // ---- L1
  modules::SectorCacheTags tags;
  unsigned sectors;  ///< of a line
  unsigned largest;  ///< sectors of a request
  std::vector<Fill> fills;
  std::vector<std::uint32_t> free_fills;
  modules::AddressIndex filling;  ///< fills by line
  PlaceRing crossed;              ///< miss queue and the link behind it
  PlaceCalendar mshrs;
  PlaceRing hits;  ///< pipeline
  BankCalendar banks;
  bool between = false;        ///< the next bank conflict is the node request's
  ResponseCalendar responses;  ///< to node requests
  std::array<Port, kClients> ports;
  unsigned waiting = 0;     ///< bits of the ports with requests
  unsigned first = 0;       ///< whose turn it is
  bool port_timed = false;  ///< the L1 is in the wheel
  modules::L1Counters l1;
};

}  // namespace grtx::sim::fast
