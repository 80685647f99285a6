#include "rtl_tlm/sampled/outline_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>

#include "modules/checkpoint_unit.h"
#include "modules/lane_loop.h"
#include "modules/memory_map.h"
#include "modules/node_traffic.h"
#include "modules/ring_queue.h"
#include "modules/round_cursor.h"
#include "modules/shader_program.h"
#include "modules/warp_selection.h"
#include "rtl_tlm/gpu.h"
#include "rtl_tlm/sampled/event_wheel.h"
#include "rtl_tlm/sampled/outline_memory.h"
#include "rtl_tlm/trace_source.h"

namespace grtx::tlm {
namespace {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeKind;
using Number = EventWheel::Number;

// Requests are served so many cycles ahead of time: many in one event.
constexpr Cycle kAhead = 24;
constexpr std::uint8_t kNoPlace = 255;

enum Client : unsigned { kNode, kSimt, kCheckpoint, kPrefetch, kClients };

/// Sectors of one line.
struct Request {
  std::uint64_t line = 0;
  Number owner = 0;  ///< lane, or warp
  std::uint8_t sectors = 0;
  std::uint8_t place = kNoPlace;
  bool write = false;
  bool last = false;
};

struct Port {
  RingQueue<Request> queue;
  Cycle next = 0;   ///< free from
  Cycle until = 0;  ///< refused until
};

/// A node on its way to a warp.
struct Fetch {
  std::uint64_t key = ~std::uint64_t{0};
  Cycle ready = 0;
  LaneMask lanes = 0;
};
constexpr std::size_t kPlaces = 64;
constexpr unsigned kProbes = 4;

enum class Taken : std::uint8_t { refused, hit, miss };

struct Lane {
  const Event* next = nullptr;
  const Event* end = nullptr;
  Cycle seen = 0;
  std::uint16_t sm = 0, entry = 0;
};

/// An internal visit whose hit children may be prefetched.
struct Record {
  std::uint32_t begin = 0, end = 0, definition = 0;
  std::uint8_t hit = 0;
  bool armed = false;
};

struct Checkpoints {
  std::uint64_t source = 0, destination = 0, held = ~std::uint64_t{0};
  std::uint32_t source_entries = 0, read = 0, written = 0;
};

struct Call {
  std::uint16_t slot = 0;
  LaneMask active = 0, ready = 0, waiting = 0, in_shader = 0;
  Cycle since = 0;
  bool timing = false;  ///< its timer is in the wheel
  std::array<Fetch, kPlaces> fetches{};
};

enum class Step : std::uint8_t { prologue, evict_move, trace_call, tracing, sort, blend, epilogue, draining };

struct Warp {
  traces::RayGroup group;
  RoundCursor cursor;
  std::size_t position = 0;
  Step step = Step::prologue;
  bool in_service = false;
  LaneMask service_lanes = 0;
  unsigned entry = 0;
  std::uint64_t instructions = 0;
  std::vector<SectorAccess> stores;
  std::uint32_t loads_pending = 0, stores_pending = 0;
  Cycle loads_seen = 0, stores_seen = 0;
};

struct Sm {
  Sm(const GpuConfig& config, const traces::Header& header, const MemoryMap& map, unsigned index)
      : program(header, map, config.simt.costs, index, config.resident_warps),
        tags(config.l1.geometry),
        arrives(tags.geometry().bytes / config.l1.geometry.sector_bytes),
        line_arrives(tags.geometry().bytes / config.l1.geometry.line_bytes),
        sectors(config.l1.geometry.sectors()),
        crossed(config.l1.miss_queue + config.links.capacity),
        mshrs(config.l1.mshr_entries),
        hits(config.l1.latency) {}
  ShaderProgram program;
  SectorCacheTags tags;
  std::vector<Cycle> arrives;       ///< by line and sector
  std::vector<Cycle> line_arrives;  ///< the last of its sectors
  unsigned sectors;                 ///< of a line
  PlaceRing crossed, mshrs, hits;
  SlotCalendar responses;  ///< to node requests, one a cycle
  unsigned conflicts = 0;
  std::array<Port, kClients> ports;
  unsigned first = 0;
  bool port_timed = false;
  std::vector<Call> calls;
  std::vector<Warp> warps;
  RingQueue<std::uint16_t> waiting_calls;
  LaneMask free_slots = 0, free_entries = 0;
  LaneMask ready = 0;               ///< entries with lanes to be handled
  std::vector<std::uint64_t> ages;  ///< by entry
  std::size_t fetches = 0;          ///< nodes that wait for the L1
  bool select_timed = false;
};

class Machine {
 public:
  Machine(const traces::Reader& reader, const std::vector<std::uint64_t>& groups, const std::vector<Launch>& known,
          const GpuConfig& config, const std::function<void(const traces::RayGroup&)>& decoded)
      : reader_(reader),
        header_(reader.header()),
        groups_(groups),
        known_(known),
        config_(config),
        decoded_(decoded),
        traffic_(header_, config.rt.memory.traffic),
        map_(header_, memory_map_config(config, header_, reader.totals().max_evictions_per_ray)),
        entries_(config.rt.warp_buffer.entries * config.rt_units),
        lanes_(std::size_t{config.sms} * entries_ * kMaxLanes),
        warps_from_(static_cast<Number>(lanes_.size())),
        timers_from_(warps_from_ + config.sms * config.resident_warps),
        ports_from_(timers_from_ + config.sms * entries_),
        selects_from_(ports_from_ + config.sms),
        wheel_(selects_from_ + config.sms),
        memory_(config, config.dram_config(map_.bytes())),
        records_(config.rt.sibling_prefetch ? lanes_.size() * config.rt.prefetcher.records : 0),
        newest_(config.rt.sibling_prefetch ? lanes_.size() : 0),
        checkpoints_(header_.checkpoint ? lanes_.size() : 0) {
    for (unsigned s = 0; s < config.sms; ++s) {
      sms_.push_back(std::make_unique<Sm>(config, header_, map_, s));
      Sm& sm = *sms_.back();
      sm.calls.resize(entries_);
      sm.ages.resize(entries_);
      sm.warps.resize(config.resident_warps);
      sm.free_slots = mask_of(config.resident_warps);
      sm.free_entries = mask_of(entries_);
    }
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      lanes_[i].sm = static_cast<std::uint16_t>(i / (entries_ * kMaxLanes));
      lanes_[i].entry = static_cast<std::uint16_t>(i / kMaxLanes % entries_);
    }
    for (const NodeKind kind : {NodeKind::internal, NodeKind::instance, NodeKind::triangle, NodeKind::procedural}) {
      units_[static_cast<std::size_t>(kind)] =
          static_cast<std::uint32_t>(traffic_.stored_bytes(kind) / traces::kNodeUnit);
    }
    selection_ = make_warp_selection(config.rt.scheduler.policy);
    result_.group_end.resize(groups.size());
    result_.group_sm.resize(groups.size());
    leaf_latency_ =
        traffic_.leaf_kind() == NodeKind::triangle ? config.rt.ray_triangle.latency : config.rt.ray_sphere.latency;
  }

  OutlineRun run() {
    launch(0);
    wheel_.run([this](Number number) {
      const Cycle now = wheel_.now();
      if (now >= advanced_ + 256) {
        memory_.advance(advanced_ = now);
        for (const auto& sm : sms_) sm->responses.advance(now);
      }
      if (number < warps_from_) {
        tested(now, number, lanes_[number]);
      } else if (number < timers_from_) {
        warp_event(now, number - warps_from_);
      } else if (number < ports_from_) {
        timer_event(now, number - timers_from_);
      } else if (number < selects_from_) {
        sms_[number - ports_from_]->port_timed = false;
        serve(now, number - ports_from_);
      } else {
        select(now, number - selects_from_);
      }
    });
    result_.cycles = end_;
    result_.l2_accesses = memory_.accesses;
    result_.dram = memory_.dram_sectors;
    return std::move(result_);
  }

 private:
  static LaneMask mask_of(unsigned bits) { return bits >= 64 ? ~LaneMask{0} : bit(bits) - 1; }
  Number lane_number(unsigned sm, unsigned entry, unsigned lane) const {
    return (sm * entries_ + entry) * kMaxLanes + lane;
  }

  // ---- launches
  void launch(Cycle now) {
    while (next_ < groups_.size()) {
      unsigned s = turn_;
      if (next_ < known_.size()) {
        s = known_[next_].sm;
      } else {
        for (unsigned i = 0; i < config_.sms && sms_[s]->free_slots == 0; ++i) s = (s + 1) % config_.sms;
      }
      Sm& sm = *sms_[s];
      if (sm.free_slots == 0) return;
      if (!ready_) {
        reader_.read(groups_[next_], next_group_);
        check_group(next_group_, header_, reader_.path());
        if (decoded_) decoded_(next_group_);
        ready_ = true;
      }
      if (!secondary_ && next_group_.kind != traces::RayKind::primary) {
        if (running_ > 0) return;
        secondary_ = true;
      }
      const auto slot = static_cast<unsigned>(std::countr_zero(sm.free_slots));
      sm.free_slots &= sm.free_slots - 1;
      Warp& warp = sm.warps[slot];
      std::swap(warp.group, next_group_);
      ready_ = false;
      warp.position = next_;
      warp.cursor = {};
      result_.group_sm[next_] = s;
      sm.program.begin(slot, warp.group);
      last_launch_ = std::max(now, next_ == 0 ? 0 : last_launch_ + 1);
      start(last_launch_ + config_.sm_links.message_latency, s, slot, Step::prologue);
      turn_ = (s + 1) % config_.sms;
      ++next_;
      ++running_;
    }
  }

  void ended(Cycle now, unsigned s, unsigned slot) {
    Sm& sm = *sms_[s];
    const Cycle seen = now + config_.sm_links.message_latency;
    result_.group_end[sm.warps[slot].position] = seen;
    end_ = std::max(end_, seen);
    sm.free_slots |= bit(slot);
    --running_;
    launch(seen);
  }

  // ---- shader phases
  void start(Cycle now, unsigned s, unsigned slot, Step step) {
    Sm& sm = *sms_[s];
    sm.warps[slot].step = step;
    switch (step) {
      case Step::prologue:
        sm.program.prologue(slot, phase_);
        break;
      case Step::evict_move:
        sm.program.evict_move(slot, phase_);
        break;
      case Step::trace_call:
        sm.program.trace_call(slot, phase_);
        break;
      case Step::sort:
        sm.program.sort(slot, phase_);
        break;
      case Step::blend:
        sm.program.blend(slot, phase_);
        break;
      default:
        sm.program.epilogue(slot, phase_);
    }
    load(now, s, slot);
  }

  /// Consecutive sectors of a line are one request.
  template <typename F>
  void for_each_line(const std::vector<SectorAccess>& sectors, F&& f) {
    const SectorCacheTags& tags = sms_.front()->tags;
    for (std::size_t i = 0; i < sectors.size();) {
      const std::uint64_t line = tags.line_address(sectors[i].address);
      std::uint8_t mask = 0;
      for (; i < sectors.size() && tags.line_address(sectors[i].address) == line; ++i) {
        const std::uint8_t b = tags.sector_bit(sectors[i].address);
        if ((mask & b) != 0) break;
        mask |= b;
      }
      f(line, mask);
    }
  }

  void load(Cycle now, unsigned s, unsigned slot) {
    Sm& sm = *sms_[s];
    Warp& warp = sm.warps[slot];
    warp.instructions = phase_.instructions;
    warp.stores.swap(phase_.stores);
    warp.loads_seen = 0;
    const Number number = warps_from_ + s * config_.resident_warps + slot;
    const bool idle = sm.ports[kSimt].queue.empty();
    for_each_line(phase_.loads, [&](std::uint64_t line, std::uint8_t mask) {
      ++warp.loads_pending;
      sm.ports[kSimt].queue.push({line, number, mask, kNoPlace, false, true});
    });
    if (warp.loads_pending == 0) {
      wheel_.add(now + 1 + warp.instructions + config_.simt.instruction_latency, number);
    } else if (idle) {
      serve(now, s);
    }
  }

  void store(Cycle now, unsigned s, unsigned slot) {
    Sm& sm = *sms_[s];
    Warp& warp = sm.warps[slot];
    if (warp.stores.empty()) return;
    const Number number = warps_from_ + s * config_.resident_warps + slot;
    const bool idle = sm.ports[kSimt].queue.empty();
    for_each_line(warp.stores, [&](std::uint64_t line, std::uint8_t mask) {
      ++warp.stores_pending;
      sm.ports[kSimt].queue.push({line, number, mask, kNoPlace, true, true});
    });
    warp.stores.clear();
    if (idle) serve(now, s);
  }

  void warp_event(Cycle now, Number number) {
    const unsigned s = number / config_.resident_warps, slot = number % config_.resident_warps;
    Sm& sm = *sms_[s];
    Warp& warp = sm.warps[slot];
    if (warp.in_service) {
      warp.in_service = false;
      store(now, s, slot);
      Call& call = sm.calls[warp.entry];
      const Cycle back = now + 1 + config_.sm_links.message_latency;
      for_each_bit(warp.service_lanes, [&](unsigned i) {
        const Number lane = lane_number(s, warp.entry, i);
        wheel_.add(back, lane);
      });
      call.in_shader = 0;
      if (call.waiting != 0) consider_any_hit(now, s, warp.entry);
      return;
    }
    if (warp.step != Step::tracing && warp.step != Step::draining) store(now, s, slot);
    switch (warp.step) {
      case Step::prologue:
      case Step::blend:
        if (sm.program.active_lanes(slot) == 0) {
          start(now, s, slot, Step::epilogue);
        } else {
          start(now, s, slot, sm.program.moves_evictions() ? Step::evict_move : Step::trace_call);
        }
        break;
      case Step::evict_move:
        start(now, s, slot, Step::trace_call);
        break;
      case Step::trace_call:
        warp.step = Step::tracing;
        sm.waiting_calls.push(static_cast<std::uint16_t>(slot));
        accept(now + config_.sm_links.message_latency, s);
        break;
      case Step::tracing:
      case Step::sort:
        start(now, s, slot, sm.program.sorts(slot) ? Step::sort : Step::blend);
        break;
      case Step::epilogue:
        warp.step = Step::draining;
        if (warp.stores_pending == 0) wheel_.add(std::max(now, warp.stores_seen), number + warps_from_);
        break;
      case Step::draining:
        ended(now, s, slot);
    }
  }

  // ---- RT unit
  void accept(Cycle now, unsigned s) {
    Sm& sm = *sms_[s];
    while (sm.free_entries != 0 && !sm.waiting_calls.empty()) {
      const unsigned slot = sm.waiting_calls.front();
      sm.waiting_calls.pop();
      const auto entry = static_cast<unsigned>(std::countr_zero(sm.free_entries));
      sm.free_entries &= sm.free_entries - 1;
      Warp& warp = sm.warps[slot];
      warp.entry = entry;
      const std::uint32_t round = sm.program.round(slot);
      warp.cursor.seek(warp.group, round);
      Call& call = sm.calls[entry];
      call.slot = static_cast<std::uint16_t>(slot);
      call.active = call.ready = call.waiting = call.in_shader = 0;
      for (Fetch& f : call.fetches) f = {};
      for_each_bit(sm.program.active_lanes(slot), [&](unsigned i) {
        const auto events = warp.cursor.events(i);
        if (events.empty()) return;
        const Number number = lane_number(s, entry, i);
        Lane& lane = lanes_[number];
        lane.next = events.data();
        lane.end = events.data() + events.size();
        call.active |= bit(i);
        call.ready |= bit(i);
        if (!records_.empty()) {
          std::fill_n(records_of(number), config_.rt.prefetcher.records, Record{});
          newest_[number] = 0;
        }
        if (header_.checkpoint) begin_checkpoints(s, slot, i, round, number, warp.cursor.round(i).replay);
      });
      sm.ages[entry] = next_age_++;
      if (call.ready != 0) {
        sm.ready |= bit(entry);
        select_soon(now, s);
      } else {
        retire(now, s, entry);
      }
    }
  }

  void retire(Cycle now, unsigned s, unsigned entry) {
    Sm& sm = *sms_[s];
    sm.free_entries |= bit(entry);
    const unsigned slot = sm.calls[entry].slot;
    wheel_.add(now + 1 + config_.sm_links.message_latency, warps_from_ + s * config_.resident_warps + slot);
    if (!sm.waiting_calls.empty()) accept(now + 1, s);
  }

  const traces::RayGroup& group_of(const Lane& lane) const {
    const Sm& sm = *sms_[lane.sm];
    return sm.warps[sm.calls[lane.entry].slot].group;
  }

  /// The next event of the lane waits for its warp's turn.
  void make_ready(Cycle now, Number number, const Lane& lane) {
    Sm& sm = *sms_[lane.sm];
    sm.calls[lane.entry].ready |= bit(number % kMaxLanes);
    sm.ready |= bit(lane.entry);
    select_soon(now, lane.sm);
  }
  bool has_room(const Sm& sm) const { return sm.fetches + kMaxLanes <= config_.rt.memory.queue; }
  void select_soon(Cycle now, unsigned s) {
    Sm& sm = *sms_[s];
    if (sm.select_timed || !has_room(sm)) return;
    sm.select_timed = true;
    wheel_.add(now + 1, selects_from_ + s);
  }
  /// One warp a cycle: all its lanes that are ready.
  void select(Cycle now, unsigned s) {
    Sm& sm = *sms_[s];
    sm.select_timed = false;
    if (sm.ready == 0 || !has_room(sm)) return;
    const unsigned entry = selection_->select(sm.ready, sm.ages);
    const LaneMask lanes = sm.calls[entry].ready;
    sm.calls[entry].ready = 0;
    sm.ready &= ~bit(entry);
    const bool idle = sm.ports[kNode].queue.empty();
    if (idle) sm.ports[kNode].next = std::max(sm.ports[kNode].next, now + 2);
    for_each_bit(lanes, [&](unsigned i) {
      const Number number = lane_number(s, entry, i);
      handle(now, number, lanes_[number]);
    });
    if (idle) serve(now, s);
    if (sm.ready != 0) select_soon(now, s);
  }

  void handle(Cycle now, Number number, Lane& lane) {
    const Event event = *lane.next;
    switch (event.kind()) {
      case EventKind::visit_internal: {
        const auto& node = group_of(lane).nodes[event.node];
        fetch(now, number, lane, NodeKind::internal, std::uint64_t{node.address} * traces::kNodeUnit, false);
        return;
      }
      case EventKind::visit_instance:
        fetch(now, number, lane, NodeKind::instance, std::uint64_t{event.node} * traces::kNodeUnit,
              event.detail == 0 && traffic_.header_read());
        if (!records_.empty()) note_leaf(number, lane, event.node);
        return;
      case EventKind::visit_leaf:
        fetch(now, number, lane, traffic_.leaf_kind(), std::uint64_t{event.node} * traces::kNodeUnit, false);
        if (!records_.empty()) note_leaf(number, lane, event.node);
        return;
      case EventKind::cull:
        advance(now, number, lane, event.checkpoints);
        return;
      default:
        if (read_checkpoint(now, number)) advance(now, number, lane, event.checkpoints);
    }
  }

  void advance(Cycle now, Number number, Lane& lane, unsigned checkpoints) {
    ++lane.next;
    const bool last = lane.next == lane.end;
    if (header_.checkpoint) write_checkpoints(now, number, checkpoints, last);
    if (!last) return make_ready(now, number, lane);
    Call& call = sms_[lane.sm]->calls[lane.entry];
    call.active &= ~bit(number % kMaxLanes);
    if (call.active == 0) {
      retire(now, lane.sm, lane.entry);
    } else if (call.waiting != 0) {
      consider_any_hit(now, lane.sm, lane.entry);
    }
  }

  void tested(Cycle now, Number number, Lane& lane) {
    const Event event = *lane.next;
    unsigned checkpoints = 0;
    switch (event.kind()) {
      case EventKind::visit_internal:
        checkpoints = static_cast<unsigned>(std::popcount(unsigned{event.checkpoints}));
        if (!records_.empty() && (event.pushed() & (event.pushed() - 1)) != 0) note_internal(number, lane, event);
        break;
      case EventKind::visit_leaf: {
        Call& call = sms_[lane.sm]->calls[lane.entry];
        const LaneMask b = bit(number % kMaxLanes);
        if (traces::calls_any_hit(event.outcome()) && (call.in_shader & b) == 0 && !returned(lane)) {
          if (call.waiting == 0) call.since = now;
          call.waiting |= b;
          returned_from_shader(lane, true);
          consider_any_hit(now, lane.sm, lane.entry);
          return;
        }
        returned_from_shader(lane, false);
        checkpoints = event.checkpoints;
        break;
      }
      case EventKind::visit_instance:
        break;
      default:  // replays whose entry has come
        checkpoints = event.kind() == EventKind::replay_forward ? event.checkpoints : 0;
    }
    advance(now, number, lane, checkpoints);
  }
  bool returned(const Lane& lane) const { return lane.seen == kNever; }
  void returned_from_shader(Lane& lane, bool yes) { lane.seen = yes ? kNever : 0; }

  void consider_any_hit(Cycle now, unsigned s, unsigned entry) {
    Call& call = sms_[s]->calls[entry];
    if (call.in_shader != 0) return;
    const Cycle due = call.since + config_.rt.any_hit.timeout;
    if (call.waiting == call.active || due <= now) return fire(now, s, entry);
    if (call.timing) return;
    call.timing = true;
    wheel_.add(due, timers_from_ + s * entries_ + entry);
  }
  void timer_event(Cycle now, Number number) {
    const unsigned s = number / entries_, entry = number % entries_;
    Call& call = sms_[s]->calls[entry];
    call.timing = false;
    if (call.waiting != 0) consider_any_hit(now, s, entry);
  }
  void fire(Cycle now, unsigned s, unsigned entry) {
    Sm& sm = *sms_[s];
    Call& call = sm.calls[entry];
    Warp& warp = sm.warps[call.slot];
    AnyHitBatch batch;
    batch.slot = call.slot;
    batch.lanes = call.waiting;
    for_each_bit(call.waiting, [&](unsigned i) {
      const Event& event = *lanes_[lane_number(s, entry, i)].next;
      batch.outcome[i] = event.outcome();
      batch.shifts[i] = static_cast<std::uint16_t>(event.shifts());
    });
    call.in_shader = warp.service_lanes = call.waiting;
    call.waiting = 0;
    warp.in_service = true;
    sm.program.any_hit(batch, phase_);
    load(now + config_.sm_links.message_latency, s, call.slot);
  }

  // ---- node fetches
  void fetch(Cycle now, Number number, Lane& lane, NodeKind kind, std::uint64_t address, bool header) {
    Sm& sm = *sms_[lane.sm];
    Call& call = sm.calls[lane.entry];
    lane.seen = 0;
    if (lane.next + 1 != lane.end && lane.next[1].kind() == EventKind::visit_internal) {
      prefetch_for_read(&group_of(lane).nodes[lane.next[1].node]);
    }
    const std::uint64_t key = address / kSectorBytes << 1 | (header ? 1u : 0u);
    const auto home = static_cast<unsigned>((key * 0x9E3779B97F4A7C15u) >> 58);
    auto place = static_cast<std::uint8_t>(home);
    bool found = false;
    for (unsigned i = 0; !found && i < kProbes; ++i) {
      const auto probe = static_cast<std::uint8_t>((home + i) % kPlaces);
      const Fetch& g = call.fetches[probe];
      found = g.key == key && g.ready > now;
      if (found || g.ready < call.fetches[place].ready) place = probe;
    }
    Fetch& f = call.fetches[place];
    if (found) {
      if (f.ready == kNever) {
        f.lanes |= bit(number % kMaxLanes);
      } else {
        await(number, lane, f.ready);
      }
      return;
    }
    if (f.ready == kNever) {
      place = kNoPlace;
    } else {
      f = {key, kNever, bit(number % kMaxLanes)};
    }
    ++sm.fetches;
    push_node(sm, kNode, number, address, traffic_.sectors(kind), place, !header);
    if (header) {
      push_node(sm, kNode, number, traffic_.blas_header(), static_cast<unsigned>(traces::kHeaderBytes / kSectorBytes),
                place, true);
    }
  }
  /// Asks the host for what serving a request will read.
  void prefetch_host(const Sm& sm, std::uint64_t address) const {
    sm.tags.prefetch(address);
    memory_.prefetch_host(sm.tags.line_address(address));
  }

  void push_node(Sm& sm, Client client, Number owner, std::uint64_t address, unsigned sectors, std::uint8_t place,
                 bool last) {
    while (sectors > 0) {
      const std::uint64_t line = sm.tags.line_address(address);
      std::uint8_t mask = 0;
      for (; sectors > 0 && sm.tags.line_address(address) == line; --sectors, address += kSectorBytes) {
        mask |= sm.tags.sector_bit(address);
      }
      sm.ports[client].queue.push({line, owner, mask, place, false, last && sectors == 0});
    }
  }

  /// The node is there in cycle `ready`.
  void await(Number number, const Lane& lane, Cycle ready) {
    const EventKind kind = lane.next->kind();
    if (lane.next + 1 != lane.end) {
      const Event& following = lane.next[1];
      if (following.kind() == EventKind::visit_internal) {
        prefetch_host(*sms_[lane.sm], std::uint64_t{group_of(lane).nodes[following.node].address} * traces::kNodeUnit);
      } else {
        prefetch_host(*sms_[lane.sm], std::uint64_t{following.node} * traces::kNodeUnit);
      }
    }
    const Cycle latency = kind == EventKind::visit_internal   ? config_.rt.ray_box.latency
                          : kind == EventKind::visit_instance ? config_.rt.ray_transform.latency
                                                              : leaf_latency_;
    wheel_.add(ready + latency, number);
  }

  Record* records_of(Number number) { return &records_[std::size_t{number} * config_.rt.prefetcher.records]; }

  void note_internal(Number number, const Lane& lane, const Event& event) {
    const traces::NodeDefinition& node = group_of(lane).nodes[event.node];
    bool has_leaf = false;
    std::uint32_t end = node.child_base;
    for (unsigned i = 0; i < node.child_count; ++i) {
      end += units_[static_cast<std::size_t>(node.child_kinds[i])];
      has_leaf = has_leaf || ((event.pushed() >> i & 1) != 0 && node.child_kinds[i] != NodeKind::internal);
    }
    if (!has_leaf) return;
    std::uint8_t& newest = newest_[number];
    newest = newest + 1u == config_.rt.prefetcher.records ? std::uint8_t{0} : static_cast<std::uint8_t>(newest + 1);
    records_of(number)[newest] = {node.child_base, end, event.node, static_cast<std::uint8_t>(event.pushed()), true};
  }

  void note_leaf(Number number, const Lane& lane, std::uint32_t address) {
    Record* const records = records_of(number);
    unsigned at = newest_[number];
    for (unsigned back = 0; back < config_.rt.prefetcher.records; ++back) {
      Record& record = records[at];
      at = at == 0 ? config_.rt.prefetcher.records - 1 : at - 1;
      if (record.hit == 0) return;
      if (address < record.begin || address >= record.end) continue;
      if (!record.armed) return;
      record.armed = false;
      const traces::NodeDefinition& node = group_of(lane).nodes[record.definition];
      Sm& sm = *sms_[lane.sm];
      RingQueue<Request>& queue = sm.ports[kPrefetch].queue;
      const bool idle = queue.empty();
      std::uint32_t child = node.child_base;
      for (unsigned i = 0; i < node.child_count; ++i) {
        const NodeKind kind = node.child_kinds[i];
        if ((record.hit >> i & 1) != 0 && child != address && queue.size() < config_.rt.prefetcher.queue) {
          push_node(sm, kPrefetch, 0, std::uint64_t{child} * traces::kNodeUnit, traffic_.sectors(kind), kNoPlace, true);
          prefetch_host(sm, std::uint64_t{child} * traces::kNodeUnit);
        }
        child += units_[static_cast<std::size_t>(kind)];
      }
      if (idle) serve(wheel_.now(), lane.sm);
      return;
    }
  }

  // ---- checkpoints
  void begin_checkpoints(unsigned s, unsigned slot, unsigned i, std::uint32_t round, Number number, bool replay) {
    Checkpoints& c = checkpoints_[number];
    const std::uint64_t ray = map_.ray_slot(s, slot, i);
    c = {};
    c.destination = map_.checkpoint_entry(ray, round & 1, 0);
    c.source = map_.checkpoint_entry(ray, (round & 1) ^ 1, 0);
    if (header_.checkpoint_order != "lifo" || !replay) return;
    for (const Event* e = lanes_[number].next; e != lanes_[number].end; ++e) {
      if (e->kind() == EventKind::replay_take || e->kind() == EventKind::replay_forward) ++c.source_entries;
    }
  }
  void push_sector(Cycle now, Number number, std::uint64_t sector, bool write, bool last) {
    Sm& sm = *sms_[lanes_[number].sm];
    const std::uint64_t address = sector * kSectorBytes;
    RingQueue<Request>& queue = sm.ports[kCheckpoint].queue;
    queue.push({sm.tags.line_address(address), number, sm.tags.sector_bit(address), kNoPlace, write, last});
    if (queue.size() == 1) serve(now, lanes_[number].sm);
  }
  void write_checkpoints(Cycle now, Number number, unsigned entries, bool last) {
    Checkpoints& c = checkpoints_[number];
    const bool combine = config_.rt.checkpoint.write_combine;
    for (; entries > 0; --entries) {
      const std::uint64_t begin = c.destination + c.written * traces::kCheckpointEntryBytes;
      const std::uint64_t end = begin + traces::kCheckpointEntryBytes;
      const std::uint64_t first = begin / kSectorBytes, final = (end - 1) / kSectorBytes;
      if (!combine || first != final || end % kSectorBytes == 0) push_sector(now, number, first, true, false);
      if (!combine && first != final) push_sector(now, number, final, true, false);
      ++c.written;
    }
    const std::uint64_t open = c.destination + c.written * traces::kCheckpointEntryBytes;
    if (last && combine && c.written > 0 && open % kSectorBytes != 0) {
      push_sector(now, number, open / kSectorBytes, true, false);
    }
  }
  /// Whether the entry is there already; else the lane waits.
  bool read_checkpoint(Cycle now, Number number) {
    Checkpoints& c = checkpoints_[number];
    const bool lifo = header_.checkpoint_order == "lifo";
    const std::uint64_t index = lifo ? c.source_entries - 1 - c.read : c.read;
    ++c.read;
    const std::uint64_t begin = c.source + index * traces::kCheckpointEntryBytes;
    const std::uint64_t first = begin / kSectorBytes;
    const std::uint64_t final = (begin + traces::kCheckpointEntryBytes - 1) / kSectorBytes;
    const bool need_first = first != c.held, need_final = final != first && final != c.held;
    if (config_.rt.checkpoint.read_buffer) c.held = lifo ? first : final;
    if (!need_first && !need_final) return true;
    Lane& lane = lanes_[number];
    lane.seen = 0;
    if (need_first) push_sector(now, number, first, false, !need_final);
    if (need_final) push_sector(now, number, final, false, true);
    return false;
  }

  // ---- L1
  void serve(Cycle now, unsigned s) {
    Sm& sm = *sms_[s];
    for (bool progress = true; progress;) {
      progress = false;
      for (unsigned i = 0, c = sm.first; i < kClients; ++i, c = (c + 1) % kClients) {
        Port& port = sm.ports[c];
        while (!port.queue.empty() && port.until <= now && port.next <= now + kAhead) {
          const Taken taken = try_head(now, s, sm, c);
          if (taken == Taken::refused) break;
          if (taken == Taken::hit) continue;
          sm.first = (c + 1) % kClients;  // the others may send a miss first
          progress = true;
          break;
        }
      }
    }
    if (sm.ready != 0) select_soon(now, s);
    if (sm.port_timed) return;
    Cycle due = kNever;
    for (const Port& port : sm.ports) {
      if (port.queue.empty()) continue;
      due = std::min(due, std::max(port.until, port.next > kAhead / 2 ? port.next - kAhead / 2 : 0));
    }
    if (due == kNever) return;
    sm.port_timed = true;
    wheel_.add(due, ports_from_ + s);
  }

  Taken try_head(Cycle now, unsigned s, Sm& sm, unsigned client) {
    Port& port = sm.ports[client];
    const Request r = port.queue.front();
    Cycle at = std::max({port.next, now + 1, client == kNode ? sm.hits.room() : 0});
    const auto count = static_cast<unsigned>(std::popcount(r.sectors));
    Taken taken = Taken::hit;
    Cycle seen = 0;
    if (!config_.l1.perfect) {
      SectorCacheTags::Slot slot = sm.tags.find(r.line);
      const std::uint8_t valid = slot == SectorCacheTags::kNone ? std::uint8_t{0} : sm.tags.valid(slot);
      const auto missing = static_cast<std::uint8_t>(r.write ? r.sectors : r.sectors & ~valid);
      if (missing != 0) {
        const Cycle crossing = sm.crossed.room();
        Cycle room = crossing > config_.l1.tag_latency ? crossing - config_.l1.tag_latency : 0;
        if (!r.write) room = std::max(room, sm.mshrs.room());
        at = std::max(at, room);
        if (at > now + kAhead) {
          port.until = at - kAhead / 2;
          return Taken::refused;
        }
      }
      seen = at + count - 1 + config_.l1.latency;
      if (slot != SectorCacheTags::kNone) sm.tags.touch(slot);
      if (!r.write) {
        if (valid != 0 && sm.line_arrives[slot] > at)
          for (std::uint8_t rest = r.sectors & valid; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
            seen = std::max(seen, sm.arrives[slot * sm.sectors + static_cast<unsigned>(std::countr_zero(rest))] + 1);
          }
        result_.l1_reads += count;
        result_.l1_hits += static_cast<unsigned>(std::popcount(static_cast<std::uint8_t>(r.sectors & valid)));
      }
      if (missing != 0) {
        taken = Taken::miss;
        const OutlineMemory::Trip trip = memory_.access(s, r.line, missing, r.write, at + config_.l1.tag_latency);
        const auto sent = static_cast<unsigned>(std::popcount(missing));
        for (unsigned i = 0; i < sent; ++i) sm.crossed.take(trip.crossed);
        seen = std::max(seen, trip.seen + 1);
        if (!r.write) {
          if (slot == SectorCacheTags::kNone) {
            SectorCacheTags::Victim victim;
            slot = sm.tags.insert(r.line, &victim);
          }
          sm.tags.set_valid(slot, missing);
          sm.line_arrives[slot] = std::max(sm.line_arrives[slot], trip.seen);
          for (std::uint8_t rest = missing; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
            sm.arrives[slot * sm.sectors + static_cast<unsigned>(std::countr_zero(rest))] = trip.seen;
          }
          for (unsigned i = 0; i < sent; ++i) sm.mshrs.take(trip.seen);
        }
      }
    }
    if (config_.l1.perfect) seen = at + count - 1 + config_.l1.latency;
    port.next = at + count;
    port.queue.pop();
    if (client == kNode) {
      const bool in_pipeline = seen == at + count - 1 + config_.l1.latency;
      for (unsigned i = count; i > 0; --i) {
        const Cycle response = sm.responses.reserve(seen - (i - 1));
        if (in_pipeline) sm.hits.take(response);
        if (i == 1) seen = response;
      }
    } else if (sm.ports[kNode].next > at) {
      // Half of the conflicts about a bank are lost by the node request.
      sm.conflicts += count;
      if (sm.conflicts >= 2 * config_.l1.banks) {
        sm.conflicts -= 2 * config_.l1.banks;
        ++sm.ports[kNode].next;
      }
    }
    deliver(s, sm, client, r, seen);
    return taken;
  }

  void deliver(unsigned s, Sm& sm, unsigned client, const Request& r, Cycle seen) {
    switch (client) {
      case kNode: {
        Lane& lane = lanes_[r.owner];
        lane.seen = std::max(lane.seen, seen);
        if (!r.last) return;
        --sm.fetches;
        const Cycle ready = lane.seen;
        lane.seen = 0;
        if (r.place == kNoPlace) return await(r.owner, lane, ready);
        Fetch& f = sm.calls[lane.entry].fetches[r.place];
        f.ready = ready;
        for_each_bit(f.lanes, [&](unsigned i) {
          const Number number = lane_number(s, lane.entry, i);
          await(number, lanes_[number], ready);
        });
        f.lanes = 0;
        return;
      }
      case kCheckpoint: {
        if (r.write) return;
        Lane& lane = lanes_[r.owner];
        lane.seen = std::max(lane.seen, seen);
        if (r.last) wheel_.add(lane.seen, r.owner);
        return;
      }
      case kSimt: {
        Warp& warp = sm.warps[r.owner - warps_from_ - s * config_.resident_warps];
        if (r.write) {
          warp.stores_seen = std::max(warp.stores_seen, seen);
          if (--warp.stores_pending == 0 && warp.step == Step::draining) wheel_.add(warp.stores_seen, r.owner);
          return;
        }
        warp.loads_seen = std::max(warp.loads_seen, seen);
        if (--warp.loads_pending > 0) return;
        wheel_.add(warp.loads_seen + 1 + warp.instructions + config_.simt.instruction_latency, r.owner);
        return;
      }
      default:
        return;
    }
  }

  const traces::Reader& reader_;
  const traces::Header& header_;
  const std::vector<std::uint64_t>& groups_;
  const std::vector<Launch>& known_;
  const GpuConfig& config_;
  const std::function<void(const traces::RayGroup&)>& decoded_;
  NodeTraffic traffic_;
  MemoryMap map_;
  unsigned entries_;
  std::vector<Lane> lanes_;
  Number warps_from_, timers_from_, ports_from_, selects_from_;
  EventWheel wheel_;
  OutlineMemory memory_;
  std::vector<Record> records_;       ///< so many of each lane as the prefetcher has
  std::vector<std::uint8_t> newest_;  ///< of a lane's records
  std::vector<Checkpoints> checkpoints_;
  std::vector<std::unique_ptr<Sm>> sms_;
  std::array<std::uint32_t, 8> units_{};
  unsigned leaf_latency_ = 0;
  std::unique_ptr<WarpSelection> selection_;
  ShaderPhase phase_;
  traces::RayGroup next_group_;
  bool ready_ = false, secondary_ = false;
  std::size_t next_ = 0, running_ = 0;
  std::uint64_t next_age_ = 0;
  unsigned turn_ = 0;
  Cycle last_launch_ = 0, end_ = 0, advanced_ = 0;
  OutlineRun result_;
};

}  // namespace

OutlineRun run_outline(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                       const std::vector<Launch>& known, const GpuConfig& config,
                       const std::function<void(const traces::RayGroup&)>& decoded) {
  return Machine(reader, groups, known, config, decoded).run();
}

}  // namespace grtx::tlm
