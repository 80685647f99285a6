// SPDX-License-Identifier: Apache-2.0
// Plain RT unit: lanes kept as plain structs, every cycle ticked. Written from docs/model/{rt_scheduler,warp_buffer,
// memory_scheduler,intersection_units,checkpoint_unit,sibling_prefetcher,stack_unit,warp_walk}.md.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "grtx/modules/rt_unit/any_hit_unit/any_hit_unit.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "rtl_tlm/plain/address_map.h"
#include "rtl_tlm/plain/messages.h"
#include "rtl_tlm/plain/simt_core.h"
#include "rtl_tlm/plain/statistics.h"
#include "rtl_tlm/plain/warp_walk.h"

namespace grtx::sim::plain {

/// An entry has 16 B with a t, 8 B without.
inline unsigned stack_entries_of_a_sector(const traces::Header& header) {
  return header.pop_test == traces::PopTest::on ? 2 : 4;
}

class RtUnit {
 public:
  /// Ports to the L1; those that a configuration does not use are never touched.
  struct Memory {
    MemoryPort *node, *checkpoint, *prefetch, *stack;
  };
  RtUnit(const modules::RtUnitConfig& config, const traces::Header& header, const AddressMap& map, unsigned sm,
         RtMessages& messages, const Memory& memory)
      : config_(config), header_(header), map_(map), sm_(sm), messages_(messages), memory_(memory) {
    warps_.resize(config.warp_buffer.entries);
    const auto pipelines = [&](const modules::IntersectionUnit::Config& c) {
      return Unit{c.count,
                  c.latency,
                  c.interval,
                  std::vector<Cycle>(c.count, 0),
                  {},
                  {},
                  0,
                  0,
                  0,
                  0,
                  config.warp_buffer.ray_banks,
                  config.memory.node_ports};
    };
    units_ = {pipelines(config.ray_box), pipelines(config.ray_triangle), pipelines(config.ray_sphere),
              pipelines(config.ray_gaussian), pipelines(config.ray_transform)};
    leaf_unit_ = !traces::has_procedural_leaves(header.accel) ? 1 : config.gaussian_unit ? 3 : 2;
    ellipsoid_ = header.accel == traces::AccelKind::ellipsoid;
    if (header.layout == traces::NodeLayout::quantised) units_[4].latency += config.leaf_decode_latency;
    if (ellipsoid_) units_[leaf_unit_].ray_banks = units_[leaf_unit_].node_ports = 0;  // all comes from the transform
    boxes_ = header.accel == traces::AccelKind::box || header.accel == traces::AccelKind::tlas_box;
    heaps_.resize(config.any_hit_unit.count);
  }

  /// Whether the L1 holds the sector of an access now; nothing where it cannot take the read. For
  /// rt.memory.l1_hit_latency.
  std::function<std::optional<bool>(Cycle, const Access&)> l1;

  void tick(Cycle now) {
    now_ = now;
    count_warps();
    for (Unit& unit : units_) {
      take_results(unit);
      start_operations(unit);
    }
    take_responses();
    issue();
    hand_over();
    any_hit();
    retire();
    if (walks()) {
      walk_enter();
      walk_write();
    }
    schedule();
    accept();
  }
  bool idle() const {
    return std::none_of(warps_.begin(), warps_.end(), [](const Warp& w) { return w.used; }) && fetches_.empty() &&
           second_reads_.empty() && read_queue_.empty() && write_queue_.empty() && prefetch_queue_.empty() &&
           stack_queue_.empty() && outstanding_ == 0;
  }
  std::uint64_t selections() const { return selections_; }
  /// cycles: of the run; stalls and occupancy count up to it.
  void report(Statistics& s) const {
    const std::string p = "gpu.rt.";
    static constexpr const char* kRegions[] = {"tlas", "blas", "leaf", "instance"};
    for (std::size_t r = 0; r < 4; ++r) {
      for (const std::string& name : {std::string(), "." + std::string(kRegions[r])}) {
        s.add(p + "node_visits" + name, node_visits_[r]);
        s.add(p + "node_fetches" + name, node_fetches_[r]);
        s.add(p + "node_sectors" + name, node_sectors_[r]);
      }
    }
    s.add(p + "shader_fetch.batches", shader_batches_);
    s.add(p + "shader_fetch.sectors", shader_sectors_);
    s.add(p + "node_fetch_latency", fetch_latency_);
    s.add(p + "selections", selections_);
    s.add(p + "lanes_handled", lanes_handled_);
    s.add(p + "lanes_active", lanes_active_);
    s.add(p + "stall.empty", stall_empty_);
    s.add(p + "stall.queue_full", stall_queue_full_);
    for (std::size_t w = 0; w < kWaits; ++w) {
      if (w > 0) s.add(p + "stall." + kWaitNames[w], stalls_[w]);
      s.add(p + "warp_cycles." + kWaitNames[w], warp_cycles_[w]);
      s.add(p + "occupancy_integral", warp_cycles_[w]);
    }
    static constexpr const char* kEvents[] = {"visits_internal", "visits_instance", "visits_leaf",
                                              "culls",           "replay_takes",    "replay_forwards"};
    for (std::size_t e = 0; e < 6; ++e) s.add(p + kEvents[e], events_[e]);
    s.add(p + "any_hit_calls", any_hit_calls_);
    if (boxes_) s.add(p + "intersection_calls", any_hit_lanes_);
    s.add(p + "calls", calls_);
    s.most(p + "max_stack_depth", max_depth_);
    s.add(p + "warp_latency", warp_latency_);
    static constexpr const char* kUnits[] = {"ray_box.", "ray_triangle.", "ray_sphere.", "ray_gaussian.",
                                             "ray_transform."};
    for (std::size_t u = 0; u < 5; ++u) {
      s.add(p + kUnits[u] + "operations", units_[u].operations);
      s.add(p + kUnits[u] + "tests", units_[u].tests);
      s.add(p + kUnits[u] + "busy_cycles", units_[u].tests * units_[u].interval);
      s.add(p + kUnits[u] + "queue_cycles", units_[u].queue_cycles);
      s.most(p + kUnits[u] + "queue_max", units_[u].queue_max);
    }
    s.add(p + "any_hit.batches", any_hit_batches_);
    s.add(p + "any_hit.lanes", any_hit_lanes_);
    s.add(p + "any_hit.timeouts", any_hit_timeouts_);
    s.add(p + "any_hit.wait_cycles", any_hit_wait_);
    s.add(p + "any_hit.unit.hits", heap_hits_);
    s.add(p + "any_hit.unit.entered", heap_entered_);
    s.add(p + "any_hit.unit.busy_cycles", heap_busy_);
    s.add(p + "any_hit.unit.wait_cycles", heap_wait_);
    s.add(p + "any_hit.unit.bounded", heap_bounded_);
    s.add(p + "any_hit.unit.hidden", heap_hidden_);
    s.add(p + "checkpoint.entries_written", entries_written_);
    s.add(p + "checkpoint.entries_read", entries_read_);
    s.add(p + "checkpoint.sectors_written", sectors_written_);
    s.add(p + "checkpoint.sectors_read", sectors_read_);
    s.add(p + "checkpoint.straddling_written", straddling_written_);
    s.add(p + "checkpoint.straddling_read", straddling_read_);
    s.most(p + "checkpoint.max_entries", max_entries_);
    s.add(p + "checkpoint.blocked_cycles", blocked_cycles_);
    s.add(p + "prefetch.triggers", triggers_);
    s.add(p + "prefetch.nodes", prefetch_nodes_);
    s.add(p + "prefetch.merged", prefetch_merged_);
    s.add(p + "prefetch.dropped", prefetch_dropped_);
    s.add(p + "prefetch.sectors", prefetch_sectors_);
    s.add(p + "prefetch.replayed", triggers_replayed_);
    s.add(p + "stack.spills", spills_);
    s.add(p + "stack.fills", fills_);
    s.most(p + "stack.max_spilled", max_spilled_);
    if (!walks()) return;
    s.add(p + "walk.entries", walk_entries_);
    s.add(p + "walk.dropped", walk_dropped_);
    s.add(p + "walk.in_vain", walk_in_vain_);
    s.add(p + "walk.under_way.sum", walk_under_way_);
    s.most(p + "walk.max_waiting", walk_most_);
  }
  /// Means and ratios, once the counts of all units are summed. unit_cycles: cycles of the run times units.
  static void finish(Statistics& s, std::uint64_t unit_cycles) {
    const std::string p = "gpu.rt.";
    s.finish_mean(p + "node_fetch_latency");
    s.finish_mean(p + "warp_latency");
    s.values[p + "simt_efficiency"] = Statistics::ratio(s[p + "lanes_handled"], s[p + "lanes_active"]);
    s.values[p + "occupancy"] = Statistics::ratio(s[p + "occupancy_integral"], static_cast<double>(unit_cycles));
    s.values[p + "any_hit.lanes_per_batch"] = Statistics::ratio(s[p + "any_hit.lanes"], s[p + "any_hit.batches"]);
    if (s.values.contains(p + "walk.entries")) {
      s.values[p + "walk.lanes_per_entry"] = Statistics::ratio(s[p + "lanes_handled"], s[p + "walk.entries"]);
      s.values[p + "walk.under_way"] =
          Statistics::ratio(s[p + "walk.under_way.sum"], s[p + "walk.entries"] - s[p + "walk.dropped"]);
      s.values.erase(p + "walk.under_way.sum");
    }
    s.values[p + "merge_factor"] = Statistics::ratio(s[p + "node_visits"], s[p + "node_fetches"]);
  }
  /// The run is over: cycles from here on are no part of it.
  void stop_counting() { counting_ = false; }

 private:
  enum class State { absent, ready, memory, unit, any_hit_wait, any_hit_run, read, write, stack, finished };
  struct Record {  // of the sibling prefetcher
    std::uint64_t node_address, child_base;
    const traces::NodeDefinition* node;
    unsigned hit;
    bool triggered = false;
  };
  struct Lane {
    State state = State::absent;
    const traces::Ray* ray = nullptr;
    std::size_t next = 0, end = 0;  // events of the round
    Cycle waiting_since = 0;        // any-hit
    int heap = 0;                   // hits that entered its heap less those that left
    std::deque<AnyHitBatch::Call> delayed;
    // checkpoint unit
    unsigned to_write = 0;  // entries submitted, not yet taken
    bool flush = false;     // the open sector is an item behind them
    std::uint64_t written = 0, reads = 0, source = 0;
    std::optional<std::uint64_t> open_sector, held_sector;
    unsigned sectors_due = 0;  // of the entry being read
    std::deque<Record> records;
    std::uint64_t taken = ~std::uint64_t{0};  // node that the last source entry named
    // stack unit
    std::uint64_t depth = 0, spilled = 0;  // entries in all, and of these in memory
    unsigned held_back = 0;                // checkpoint entries that wait for the stack
  };
  struct Warp {
    bool used = false;
    const traces::RayGroup* group = nullptr;
    unsigned slot = 0, round = 0;
    std::uint64_t age = 0;
    Cycle accepted = 0;
    bool shader_busy = false;
    Lane lanes[kLanes];
    WarpWalk walk;
  };
  using LaneName = std::pair<unsigned, unsigned>;  // entry, lane
  struct Operation {
    LaneName lane;
    Cycle queued;
    unsigned tests;
    std::uint64_t node;  // of how many that came to units before
  };
  struct Result {
    Cycle due;
    std::uint64_t order;
    LaneName lane;
  };
  struct Unit {
    unsigned count, latency, interval;
    std::vector<Cycle> free_from;
    std::deque<Operation> queue;
    std::vector<Result> flying;
    std::uint64_t operations, tests, queue_cycles, queue_max;
    unsigned ray_banks, node_ports;
  };
  static constexpr Cycle kLater = ~Cycle{0};
  struct HeapHit {
    LaneName lane;
    Cycle came;
    std::uint64_t order;
    Cycle begun;
  };
  struct Fetch {
    unsigned entry, leader;  // the lane that opened it
    std::uint64_t address;
    bool header;
    traces::NodeKind kind;
    Region region;
    std::vector<unsigned> lanes;
    std::vector<std::pair<std::uint64_t, Region>> sectors;
    std::size_t sent = 0, back = 0;
    Cycle opened;
    bool second = false;                                  // what waited for another fetch
    unsigned wait = 0;                                    // until what waits for this one,
    std::vector<std::pair<std::uint64_t, Region>> later;  // the sectors of which are these
  };
  /// What a warp waits for, in order of precedence.
  enum Wait { kReady, kMemory, kCheckpoint, kStack, kUnit, kAnyHit, kRetire, kWaits };
  static constexpr const char* kWaitNames[] = {"ready", "memory", "checkpoint", "stack", "unit", "any_hit", "retire"};

  // --- what the trace says -----------------------------------------------------------------------------------------
  const traces::Event& event(const Lane& lane) const { return lane.ray->events[lane.next]; }
  const traces::NodeDefinition& definition(const Warp& warp, const traces::Event& e) const {
    return warp.group->nodes[e.node];
  }
  // docs/model/node-image.md: nodes of layout compact have 80 B, but instance leaves two of these, of which the first
  // is read, and leaves of four triangles; of layout compressed all nodes have 64 B; of quantised instances and
  // procedural leaves have 32 B, wide ones 64. None has headers to read.
  bool compact() const { return header_.layout == traces::NodeLayout::compact; }
  bool compressed() const { return header_.layout == traces::NodeLayout::compressed; }
  bool quantised() const { return header_.layout == traces::NodeLayout::quantised; }
  std::uint64_t unit() const { return compact() ? 80 : quantised() ? 32 : 64; }
  std::uint64_t stored(traces::NodeKind kind) const {
    if (compact()) return kind == traces::NodeKind::instance ? 160 : 80;
    if (quantised()) return kind == traces::NodeKind::instance || kind == traces::NodeKind::procedural ? 32 : 64;
    return compressed() ? 64 : traces::node_bytes(kind, header_.bvh_width);
  }
  /// The kind of a leaf in the image, which the child byte of its parent gives.
  static traces::NodeKind kind_in_image(const traces::Event& e, traces::NodeKind kind) {
    if (!e.wide()) return kind;
    return kind == traces::NodeKind::instance ? traces::NodeKind::wide_instance : traces::NodeKind::wide_procedural;
  }
  static bool is_instance(traces::NodeKind kind) {
    return kind == traces::NodeKind::instance || kind == traces::NodeKind::wide_instance;
  }
  static bool is_procedural(traces::NodeKind kind) {
    return kind == traces::NodeKind::procedural || kind == traces::NodeKind::wide_procedural;
  }
  /// Sectors of what a visit reads of a node.
  std::vector<std::uint64_t> sectors_of(traces::NodeKind kind, std::uint64_t address) const {
    std::uint64_t bytes = compact() ? 80 : stored(kind);
    if (kind == traces::NodeKind::instance && !compact() && !compressed() && !quantised()) {
      bytes = config_.memory.traffic.instance_leaf_bytes;
    }
    std::vector<std::uint64_t> sectors;
    for (std::uint64_t at = address / kSector * kSector; at < address + bytes; at += kSector) sectors.push_back(at);
    return sectors;
  }
  std::uint64_t entry_bytes() const { return config_.checkpoint.entry_bytes; }
  Lane& lane(LaneName name) { return warps_[name.first].lanes[name.second]; }
  static std::uint64_t tag(LaneName name) { return std::uint64_t{name.first} * kLanes + name.second; }
  static LaneName lane_of(std::uint64_t tag) {
    return {static_cast<unsigned>(tag / kLanes), static_cast<unsigned>(tag % kLanes)};
  }

  // --- statistics of every cycle -----------------------------------------------------------------------------------
  Wait waits_for(const Warp& warp) const {
    if (walks()) return walk_waits_for(warp);
    const auto any = [&](auto... states) {
      return std::any_of(std::begin(warp.lanes), std::end(warp.lanes),
                         [&](const Lane& lane) { return ((lane.state == states) || ...); });
    };
    if (any(State::ready)) return kReady;
    if (any(State::memory)) return kMemory;
    if (any(State::read, State::write)) return kCheckpoint;
    if (any(State::stack)) return kStack;
    if (any(State::unit)) return kUnit;
    if (any(State::any_hit_wait, State::any_hit_run)) return kAnyHit;
    return kRetire;
  }
  void count_warps() {
    if (!counting_) return;
    for (const Warp& warp : warps_) {
      if (warp.used) ++warp_cycles_[waits_for(warp)];
    }
  }
  void count_stall(bool candidate) {
    if (!counting_) return;
    const Warp* oldest = nullptr;
    for (const Warp& warp : warps_) {
      if (warp.used && (oldest == nullptr || warp.age < oldest->age)) oldest = &warp;
    }
    if (oldest == nullptr) {
      ++stall_empty_;
    } else if (candidate) {
      ++stall_queue_full_;
    } else {
      ++stalls_[waits_for(*oldest)];
    }
  }

  // --- 1 results ---------------------------------------------------------------------------------------------------
  void take_results(Unit& unit) {
    std::sort(unit.flying.begin(), unit.flying.end(),
              [](const Result& a, const Result& b) { return std::tie(a.due, a.order) < std::tie(b.due, b.order); });
    while (!unit.flying.empty() && unit.flying.front().due <= now_) {
      const LaneName name = unit.flying.front().lane;
      unit.flying.erase(unit.flying.begin());
      if (ellipsoid_ && &unit == &units_[4]) {
        queue_at(units_[leaf_unit_], {name, now_, 1, 0});  // a leaf with a matrix of its own: transformed, then tested
      } else {
        result(name);
      }
    }
  }
  void result(LaneName name) {
    if (walks()) return walk_result(name);
    Warp& warp = warps_[name.first];
    Lane& lane = warp.lanes[name.second];
    const traces::Event& e = event(lane);
    if (e.kind() != traces::EventKind::visit_instance) --lane.depth;
    if (e.kind() == traces::EventKind::visit_internal) {
      lane.depth += static_cast<unsigned>(std::popcount(e.pushed()));
      max_depth_ = std::max(max_depth_, lane.depth);
    }
    if (e.kind() == traces::EventKind::visit_leaf && (boxes_ || traces::calls_any_hit(e.outcome()))) {
      if (config_.any_hit_unit.enabled) return to_heap(name);
      if (delayed()) {
        lane.delayed.push_back({name.second, e.outcome(), e.shifts(), e.node * std::uint64_t{64}});
        return finish_event(name, e.written());
      }
      lane.state = State::any_hit_wait;
      lane.waiting_since = now_;
      return;
    }
    if (e.kind() == traces::EventKind::visit_internal) remember(warp, name, e);
    finish_event(name, static_cast<unsigned>(std::popcount(unsigned{e.checkpoints})));
  }
  // The event is over but for its checkpoint entries.
  void finish_event(LaneName name, unsigned entries) {
    if (walks()) return walk_hit_answered(name);
    Lane& lane = this->lane(name);
    ++events_[static_cast<std::size_t>(event(lane).kind())];
    ++lane.next;
    if (config_.warp_buffer.spill && stack_moves(name)) {
      lane.held_back = entries;
      lane.state = State::stack;
    } else {
      submit(name, entries);
    }
  }
  // Keeps at most stack_entries in the warp buffer, and one there for an event that takes it; entries move by sectors.
  bool stack_moves(LaneName name) {
    Lane& lane = this->lane(name);
    const std::size_t before = stack_queue_.size();
    const unsigned together = stack_entries_of_a_sector(header_);
    while (lane.depth - lane.spilled > config_.warp_buffer.stack_entries) {
      stack_queue_.push_back({name, stack_address(name, lane.spilled / together), true});
      lane.spilled += together;
    }
    max_spilled_ = std::max(max_spilled_, lane.spilled);
    if (lane.depth == lane.spilled && lane.spilled > 0 && lane.next != lane.end) {
      const auto kind = event(lane).kind();
      if (kind != traces::EventKind::replay_take && kind != traces::EventKind::replay_forward) {
        lane.spilled -= together;
        stack_queue_.push_back({name, stack_address(name, lane.spilled / together), false});
      }
    }
    return stack_queue_.size() != before;
  }
  std::uint64_t stack_address(LaneName name, std::uint64_t sector) const {
    return map_.stack(sm_, warps_[name.first].slot, name.second, sector);
  }
  void stack_moved(LaneName name) {
    if (walks()) return walk_stack_moved(warps_[name.first]);
    submit(name, lane(name).held_back);
  }
  void submit(LaneName name, unsigned entries) {
    Lane& lane = this->lane(name);
    lane.to_write = entries;
    const bool last = lane.next == lane.end;
    const std::uint64_t total = lane.written + entries;
    lane.flush =
        last && charged() && config_.checkpoint.write_combine && total > 0 && total * entry_bytes() % kSector != 0;
    if (binned()) lane.flush = last && charged() && config_.checkpoint.write_combine;
    if (entries > 0 || (binned() ? lane.flush && !bins(name).open.empty() : lane.flush)) {
      lane.state = State::write;
      submitted_.push_back(name);
    } else {
      lane.state = !last ? State::ready : lane.delayed.empty() ? State::finished : State::any_hit_wait;
    }
  }
  bool delayed() const { return header_.any_hit == traces::AnyHit::delayed; }

  // --- 2 start -----------------------------------------------------------------------------------------------------
  void start_operations(Unit& unit) {
    std::set<unsigned> banks;
    std::set<std::uint64_t> nodes;
    for (Cycle& free : unit.free_from) {
      if (free > now_ || unit.queue.empty() || unit.queue.front().queued >= now_) continue;
      const Operation op = unit.queue.front();
      const unsigned bank = unit.ray_banks == 0 ? 0 : op.lane.second % kLanes % unit.ray_banks;
      if (unit.node_ports != 0 && !nodes.contains(op.node) && nodes.size() == unit.node_ports) break;
      if (unit.ray_banks != 0 && banks.contains(bank)) break;
      banks.insert(bank);
      nodes.insert(op.node);
      unit.queue.pop_front();
      free = now_ + Cycle{op.tests} * unit.interval;
      unit.flying.push_back({now_ + unit.latency + Cycle{op.tests - 1} * unit.interval, order_++, op.lane});
      ++unit.operations;
      unit.tests += op.tests;
      unit.queue_cycles += now_ - op.queued - 1;
    }
  }

  // --- 3 responses -------------------------------------------------------------------------------------------------
  void take_responses() {
    if (config_.memory.by_shader) {
      if (messages_.fetched.front(now_) != nullptr) {
        std::vector<std::uint64_t> numbers = messages_.fetched.pop(now_).fetches;
        std::sort(numbers.begin(), numbers.end(),
                  [this](std::uint64_t a, std::uint64_t b) { return fetches_.at(a).leader < fetches_.at(b).leader; });
        for (const std::uint64_t number : numbers) complete(number);
      }
    }
    for (unsigned i = 0; !config_.memory.by_shader && i < config_.memory.sectors_per_cycle; ++i) {
      const std::optional<Access> answer = take(memory_.node);
      if (!answer) break;
      Fetch& fetch = fetches_.at(answer->tag);
      if (++fetch.back == fetch.sectors.size()) complete(answer->tag);
    }
    if (const std::optional<Access> answer = take(memory_.checkpoint); answer && !answer->write) {
      const LaneName reader = lane_of(answer->tag);
      if (--lane(reader).sectors_due == 0) entry_read(reader);
    }
    take(memory_.prefetch);
    if (const std::optional<Access> answer = take(memory_.stack); answer && !answer->write) {
      stack_moved(lane_of(answer->tag));
    }
  }
  std::optional<Access> take(MemoryPort* port) {
    if (port == nullptr || port->response.front(now_) == nullptr) return std::nullopt;
    --outstanding_;
    return port->response.pop(now_);
  }
  void complete(std::uint64_t number) {
    const Fetch fetch = fetches_.at(number);
    fetches_.erase(number);
    fetch_latency_.add(now_ - fetch.opened);
    std::vector<unsigned> lanes = fetch.lanes;
    std::sort(lanes.begin(), lanes.end());
    if (!fetch.later.empty()) {
      Fetch second = fetch;
      second.lanes = lanes;
      second_reads_.emplace(now_ + fetch.wait, second);
      return;
    }
    const bool internal = fetch.kind == traces::NodeKind::internal;
    Unit& unit = units_[internal ? 0 : is_instance(fetch.kind) || ellipsoid_ ? 4 : leaf_unit_];
    if (walks()) return walk_fetched(fetch);
    ++nodes_that_came_;
    for (const unsigned l : lanes) {
      Warp& warp = warps_[fetch.entry];
      Lane& lane = warp.lanes[l];
      if (boxes_ && is_procedural(fetch.kind)) {  // no unit: a shader tests
        result({fetch.entry, l});
        continue;
      }
      unsigned tests = 1;
      lane.state = State::unit;
      if (internal && config_.box_op_per_child) tests = definition(warp, event(lane)).child_count;
      if (event(lane).kind() == traces::EventKind::visit_leaf && compact() && leaf_unit_ == 1) tests = 4;
      queue_at(unit, {{fetch.entry, l}, now_, tests, nodes_that_came_});
    }
  }
  static void queue_at(Unit& unit, const Operation& operation) {
    unit.queue.push_back(operation);
    unit.queue_max = std::max<std::uint64_t>(unit.queue_max, unit.queue.size());
  }
  // The source entry of the event is there: a replay_take pushes it, a replay_forward may submit it.
  void entry_read(LaneName name) {
    Lane& lane = this->lane(name);
    if (event(lane).kind() == traces::EventKind::replay_take) {
      max_depth_ = std::max(max_depth_, ++lane.depth);
      lane.taken = std::uint64_t{event(lane).node} * unit();
    }
    finish_event(name, event(lane).written());
  }

  // --- 4 issue -----------------------------------------------------------------------------------------------------
  void issue() {
    take_hits();
    begin_second_reads();
    if (config_.memory.by_shader) send_batch();
    for (unsigned i = 0; !config_.memory.by_shader && i < config_.memory.sectors_per_cycle; ++i) {
      if (fetch_queue_.empty()) break;
      Fetch& fetch = fetches_.at(fetch_queue_.front());
      const auto [address, region] = fetch.sectors[fetch.sent];
      if (!ask(address, region, fetch_queue_.front())) break;
      ++node_sectors_[modules::index(region)];
      if (++fetch.sent == fetch.sectors.size()) fetch_queue_.pop_front();
      take_hits();
    }
    const bool read_blocked = !read_queue_.empty() && std::find(write_queue_.begin(), write_queue_.end(),
                                                                read_queue_.front().second) != write_queue_.end();
    if (memory_.checkpoint != nullptr && memory_.checkpoint->request.has_room(now_)) {
      if (!read_queue_.empty() && !read_blocked) {
        send(memory_.checkpoint, read_queue_.front().second, Region::checkpoint, false, tag(read_queue_.front().first));
        read_queue_.pop_front();
        ++sectors_read_;
      } else if (!write_queue_.empty()) {
        send(memory_.checkpoint, write_queue_.front(), Region::checkpoint, true, 0);
        write_queue_.pop_front();
        ++sectors_written_;
      }
    }
    if (!prefetch_queue_.empty() && memory_.prefetch->request.has_room(now_)) {
      Prefetch& prefetch = prefetch_queue_.front();
      send(memory_.prefetch, prefetch.address / kSector * kSector + kSector * prefetch.sent, prefetch.region, false, 0,
           true);
      ++prefetch_sectors_;
      if (++prefetch.sent == prefetch.sectors) prefetch_queue_.pop_front();
    }
    if (!stack_queue_.empty() && memory_.stack->request.has_room(now_)) {
      const StackMove move = stack_queue_.front();
      stack_queue_.pop_front();
      send(memory_.stack, move.address, Region::stack, move.write, tag(move.lane));
      ++(move.write ? spills_ : fills_);
      const bool more = !stack_queue_.empty() && stack_queue_.front().lane == move.lane;
      if (move.write && !more) stack_moved(move.lane);
    }
  }
  // Of a sector of this fetch: through the port, or at once.
  bool ask(std::uint64_t address, Region region, std::uint64_t fetch) {
    if (!l1) {
      if (!memory_.node->request.has_room(now_)) return false;
      send(memory_.node, address, region, false, fetch);
      return true;
    }
    const std::optional<bool> held = l1(now_, {address, region, false, false, fetch, 0, 0});
    if (!held) return false;
    ++outstanding_;
    if (*held) hits_.emplace_back(now_ + config_.memory.l1_hit_latency, fetch);
    return true;
  }
  void take_hits() {
    while (!hits_.empty() && hits_.front().first <= now_) {
      const std::uint64_t number = hits_.front().second;
      hits_.pop_front();
      --outstanding_;
      Fetch& fetch = fetches_.at(number);
      if (++fetch.back == fetch.sectors.size()) complete(number);
    }
  }
  // What waited long enough for the first read of its visit becomes a fetch, or joins one of the warp for the same.
  void begin_second_reads() {
    while (!second_reads_.empty() && second_reads_.begin()->first <= now_ &&
           fetch_queue_.size() < config_.memory.queue) {
      Fetch fetch = second_reads_.begin()->second;
      second_reads_.erase(second_reads_.begin());
      fetch.leader = fetch.lanes.front();
      fetch.sectors = std::exchange(fetch.later, {});
      fetch.region = fetch.sectors.front().second;
      fetch.sent = fetch.back = 0;
      fetch.opened = now_;
      fetch.second = true;
      bool joined = false;
      for (auto& [number, other] : fetches_) {
        if (!config_.memory.merge_in_flight || !other.second || other.entry != fetch.entry) continue;
        if (other.sectors.front() != fetch.sectors.front()) continue;
        other.lanes.insert(other.lanes.end(), fetch.lanes.begin(), fetch.lanes.end());
        joined = true;
      }
      if (joined) continue;
      ++node_fetches_[modules::index(fetch.region)];
      queue(std::move(fetch));
    }
  }
  void send(MemoryPort* port, std::uint64_t address, Region region, bool write, std::uint64_t tag,
            bool prefetch = false) {
    port->request.push(now_, {address, region, write, prefetch, tag, 0, 0});
    ++outstanding_;
  }
  // The fetches at the front of the queue that belong to one warp, for its shader.
  void send_batch() {
    if (fetch_queue_.empty() || !messages_.fetches.has_room(now_)) return;
    const unsigned entry = fetches_.at(fetch_queue_.front()).entry;
    NodeFetchBatch batch{warps_[entry].slot, {}, {}};
    while (!fetch_queue_.empty() && fetches_.at(fetch_queue_.front()).entry == entry) {
      const Fetch& fetch = fetches_.at(fetch_queue_.front());
      batch.fetches.push_back(fetch_queue_.front());
      for (const auto& [address, region] : fetch.sectors) {
        batch.sectors.push_back({address, region, false, false, 0, 0, 0});
        ++node_sectors_[modules::index(region)];
      }
      fetch_queue_.pop_front();
    }
    ++shader_batches_;
    shader_sectors_ += batch.sectors.size();
    messages_.fetches.push(now_, batch);
  }

  // --- 5 hand-over -------------------------------------------------------------------------------------------------
  void hand_over() {
    take_items();
    if (!submitted_.empty()) ++blocked_cycles_;
  }
  bool charged() const { return config_.checkpoint.traffic == modules::TrafficCharging::charged; }
  void take_items() {
    const unsigned places = config_.checkpoint.write_combine || entry_bytes() < 20 ? 1 : 2;
    for (unsigned taken = 0; taken < config_.checkpoint.lanes && !submitted_.empty(); ++taken) {
      const LaneName name = submitted_.front();
      Warp& warp = warps_[name.first];
      Lane& lane = warp.lanes[name.second];
      if (!charged()) {
        --lane.to_write;
        if (binned()) place_in_bin(name);
        ++entries_written_;
        max_entries_ = std::max(max_entries_, ++lane.written);
      } else if (write_queue_.size() + places > config_.checkpoint.write_queue) {
        return;
      } else if (binned()) {
        take_binned(name);
      } else if (lane.to_write > 0) {
        --lane.to_write;
        const std::uint64_t first = entry_address(warp, name.second, warp.round % 2, lane.written++);
        ++entries_written_;
        max_entries_ = std::max(max_entries_, lane.written);
        const std::uint64_t last_sector = (first + entry_bytes() - 1) / kSector * kSector;
        const std::uint64_t first_sector = first / kSector * kSector;
        if (last_sector != first_sector) ++straddling_written_;
        if (!config_.checkpoint.write_combine) {
          write_queue_.push_back(first_sector);
          if (last_sector != first_sector) write_queue_.push_back(last_sector);
        } else {
          const std::uint64_t end = first + entry_bytes();
          if (end / kSector * kSector != first_sector) write_queue_.push_back(first_sector);
          lane.open_sector.reset();
          if (end % kSector != 0) lane.open_sector = end / kSector * kSector;
        }
      } else {
        write_queue_.push_back(*lane.open_sector);
        lane.open_sector.reset();
        lane.flush = false;
      }
      if (lane.to_write == 0 && !(binned() ? lane.flush && !bins(name).open.empty() : lane.flush)) {
        submitted_.pop_front();
        lane.state = lane.next == lane.end ? State::finished : State::ready;
      }
    }
  }
  std::uint64_t entry_address(const Warp& warp, unsigned lane, unsigned buffer, std::uint64_t index) const {
    return map_.checkpoint(sm_, warp.slot, lane, buffer, index);
  }

  // Bins: queues by distance, the last one for all beyond.
  bool binned() const { return header_.checkpoint_bins > 0; }
  struct Bins {
    struct Queue {
      std::deque<std::uint64_t> places;  // of the entries that are there
      std::uint64_t next = 0;            // place of the next to be written
      std::size_t readable = 0;          // of this round
    };
    std::vector<Queue> queues;
    std::vector<std::size_t> order;  // in which the round reads them
    std::size_t written = 0;         // by the ray: the next one's bin is ray->bins[written]
    std::deque<std::uint64_t> open;  // sectors, the one used last at the end
  };
  Bins& bins(LaneName name) { return bins_[{warps_[name.first].slot, name.second}]; }
  void begin_bins(LaneName name, const traces::Ray& ray) {
    const Warp& warp = warps_[name.first];
    Bins& b = bins(name);
    if (warp.round == 0) b = {};
    if (!ray.rounds[warp.round].replay) b.queues.assign(header_.checkpoint_bins + 1, {});
    const traces::BinOrder& order = ray.rounds[warp.round].bins;
    b.order.clear();
    for (std::size_t i = 0; i < header_.checkpoint_bins; ++i)
      b.order.push_back((order.first + i) % header_.checkpoint_bins);
    b.order.insert(b.order.begin() + order.before_far, header_.checkpoint_bins);
    for (Bins::Queue& queue : b.queues) {
      if (queue.places.empty()) queue.next = 0;
      queue.readable = queue.places.size();
    }
  }
  /// Address of the lane's next entry.
  std::uint64_t place_in_bin(LaneName name) {
    Bins& b = bins(name);
    const unsigned bin = lane(name).ray->bins.at(b.written++);
    Bins::Queue& queue = b.queues.at(bin);
    const std::uint64_t place = queue.next++ % header_.checkpoint_capacity;
    queue.places.push_back(place);
    return entry_address(warps_[name.first], name.second, bin, place);
  }
  std::uint64_t next_of_bins(LaneName name) {
    Bins& b = bins(name);
    for (const std::size_t bin : b.order) {
      Bins::Queue& queue = b.queues[bin];
      if (queue.readable == 0) continue;
      --queue.readable;
      const std::uint64_t place = queue.places.front();
      queue.places.pop_front();
      return entry_address(warps_[name.first], name.second, static_cast<unsigned>(bin), place);
    }
    throw std::logic_error("nothing to read in any bin");
  }
  /// An entry, or an open sector behind the last of them.
  void take_binned(LaneName name) {
    Lane& lane = this->lane(name);
    std::deque<std::uint64_t>& open = bins(name).open;
    if (lane.to_write == 0) {
      write_queue_.push_back(open.front());
      open.pop_front();
      return;
    }
    --lane.to_write;
    ++entries_written_;
    max_entries_ = std::max(max_entries_, ++lane.written);
    const std::uint64_t end = place_in_bin(name) + entry_bytes();
    const std::uint64_t sector = (end - 1) / kSector * kSector;
    const bool was_open = std::find(open.begin(), open.end(), sector) != open.end();
    std::erase(open, sector);
    if (!config_.checkpoint.write_combine || end % kSector == 0) return write_queue_.push_back(sector);
    if (!was_open && open.size() == config_.checkpoint.open_sectors) {
      write_queue_.push_back(open.front());
      open.pop_front();
    }
    open.push_back(sector);
  }

  // --- 6 any-hit ---------------------------------------------------------------------------------------------------
  void any_hit() {
    if (config_.any_hit_unit.enabled) return serve_heaps();
    if (delayed()) return serve_delayed();
    if (messages_.shaded.front(now_) != nullptr) {
      const AnyHitDone done = messages_.shaded.pop(now_);
      for (unsigned w = 0; w < warps_.size(); ++w) {
        Warp& warp = warps_[w];
        if (!warp.used || warp.slot != done.slot) continue;
        warp.shader_busy = false;
        for (const auto& call : done.calls) finish_event({w, call.lane}, event(warp.lanes[call.lane]).written());
        if (walks()) {
          for (const auto& call : done.calls) walk_next_hit({w, call.lane});
        }
      }
    }
    if (!messages_.batches.has_room(now_)) return;
    Warp* fires = nullptr;
    bool fires_late = false;
    for (Warp& warp : warps_) {
      if (!warp.used || warp.shader_busy) continue;
      bool all = true, any = false, late = false;
      for (const Lane& lane : warp.lanes) {
        if (lane.state == State::any_hit_wait) {
          any = true;
          late = late || now_ >= lane.waiting_since + config_.any_hit.timeout;
        } else if (lane.state != State::finished && lane.state != State::absent) {
          all = false;
        }
      }
      if (any && (all || late) && (fires == nullptr || warp.age < fires->age)) {
        fires = &warp;
        fires_late = !all;
      }
    }
    if (fires != nullptr) fire(*fires, fires_late);
  }
  // Delayed hits: when all lanes of a warp have traversed, a batch has the next hit of each lane that has one left.
  void serve_delayed() {
    if (messages_.shaded.front(now_) != nullptr) {
      const AnyHitDone done = messages_.shaded.pop(now_);
      for (Warp& warp : warps_) {
        if (!warp.used || warp.slot != done.slot) continue;
        for (const auto& call : done.calls) {
          Lane& lane = warp.lanes[call.lane];
          lane.state = lane.delayed.empty() ? State::finished : State::any_hit_wait;
        }
      }
    }
    if (!messages_.batches.has_room(now_)) return;
    Warp* oldest = nullptr;
    for (Warp& warp : warps_) {
      bool waits = false, traversed = true;
      for (const Lane& lane : warp.lanes) {
        waits = waits || lane.state == State::any_hit_wait;
        traversed = traversed &&
                    (lane.state == State::any_hit_wait || lane.state == State::finished || lane.state == State::absent);
      }
      if (warp.used && waits && traversed && (oldest == nullptr || warp.age < oldest->age)) oldest = &warp;
    }
    if (oldest == nullptr) return;
    AnyHitBatch batch{oldest->slot, oldest->round, {}};
    for (Lane& lane : oldest->lanes) {
      if (lane.state != State::any_hit_wait) continue;
      lane.state = State::any_hit_run;
      batch.calls.push_back(lane.delayed.front());
      lane.delayed.pop_front();
      any_hit_calls_ += traces::calls_any_hit(batch.calls.back().outcome) ? 1 : 0;
    }
    ++any_hit_batches_;
    any_hit_lanes_ += batch.calls.size();
    messages_.batches.push(now_, batch);
  }

  // docs/model/any_hit_unit.md: a hit waits for the heap logic of its lane, and then takes cycles by what it does
  // there.
  void to_heap(LaneName name) {
    Lane& lane = this->lane(name);
    lane.state = State::any_hit_run;
    ++any_hit_calls_;
    ++heap_hits_;
    std::deque<HeapHit>& waiting = heaps_[name.second % config_.any_hit_unit.count];
    waiting.push_back({name, now_, order_++, waiting.empty() ? now_ : kLater});
  }
  unsigned heap_cycles(LaneName name) {
    const auto depth = [](unsigned entries) {
      unsigned levels = 0;
      for (; entries > 1; entries /= 2) ++levels;
      return levels;
    };
    Lane& lane = this->lane(name);
    const modules::AnyHitUnit::Config& unit = config_.any_hit_unit;
    const traces::LeafOutcome outcome = event(lane).outcome();
    const auto held = [&](int entries) {
      return static_cast<unsigned>(std::min(std::max(entries, 1), int(header_.k)));
    };
    int entries = lane.heap;
    unsigned cycles = unit.latency;
    if (outcome == traces::LeafOutcome::inserted) {
      cycles += unit.level_latency * depth(held(++entries));
    } else if (outcome == traces::LeafOutcome::displaced) {
      cycles += unit.level_latency * (1 + depth(header_.k));
    } else {
      return cycles;
    }
    if (header_.opacity_bound == traces::OpacityBound::off) return cycles;
    cycles += unit.bound_latency;
    for (unsigned left = event(lane).hidden(); left > 0; --left) {
      cycles += unit.latency + unit.level_latency * (1 + depth(held(entries--)));
    }
    return cycles;
  }
  void serve_heaps() {
    std::vector<HeapHit> done;
    for (std::deque<HeapHit>& waiting : heaps_) {
      if (waiting.empty()) continue;
      if (waiting.front().begun + heap_cycles(waiting.front().lane) != now_) continue;
      done.push_back(waiting.front());
      waiting.pop_front();
      if (!waiting.empty()) waiting.front().begun = now_;
    }
    std::sort(done.begin(), done.end(), [](const HeapHit& a, const HeapHit& b) { return a.order < b.order; });
    for (const HeapHit& hit : done) {
      Lane& lane = this->lane(hit.lane);
      heap_busy_ += heap_cycles(hit.lane);
      heap_wait_ += hit.begun - hit.came;
      const traces::LeafOutcome outcome = event(lane).outcome();
      const bool enters = outcome == traces::LeafOutcome::inserted || outcome == traces::LeafOutcome::displaced;
      heap_entered_ += enters ? 1 : 0;
      if (outcome == traces::LeafOutcome::inserted) ++lane.heap;
      if (enters && header_.opacity_bound == traces::OpacityBound::on) {
        ++heap_bounded_;
        heap_hidden_ += event(lane).hidden();
        lane.heap -= static_cast<int>(event(lane).hidden());
      }
      if (header_.checkpoint && outcome != traces::LeafOutcome::inserted && outcome != traces::LeafOutcome::ignored) {
        fallen_out_.push_back(hit.lane);
      } else {
        finish_event(hit.lane, event(lane).written());
        if (walks()) walk_next_hit(hit.lane);
      }
    }
    if (fallen_out_.empty() || !messages_.batches.has_room(now_)) return;
    const LaneName name = fallen_out_.front();
    fallen_out_.pop_front();
    const Warp& warp = warps_[name.first];
    const traces::Event& e = event(lane(name));
    messages_.batches.push(now_, {warp.slot, warp.round, {{name.second, e.outcome(), e.shifts(), 0, 0}}});
    finish_event(name, e.written());
  }
  void fire(Warp& warp, bool late) {
    warp.shader_busy = true;
    AnyHitBatch batch{warp.slot, warp.round, {}};
    Cycle since = now_;
    for (unsigned l = 0; l < kLanes; ++l) {
      Lane& lane = warp.lanes[l];
      if (lane.state != State::any_hit_wait) continue;
      lane.state = State::any_hit_run;
      since = std::min(since, lane.waiting_since);
      std::uint64_t leaf = event(lane).node;
      for (std::size_t e = lane.next;
           header_.two_level && header_.opacity_bound == traces::OpacityBound::on && e > 0;) {
        if (lane.ray->events[--e].kind() != traces::EventKind::visit_instance) continue;
        leaf = lane.ray->events[e].node;
        break;
      }
      batch.calls.push_back({l, event(lane).outcome(), event(lane).shifts(), leaf * 64, event(lane).hidden()});
      any_hit_calls_ += traces::calls_any_hit(event(lane).outcome()) ? 1 : 0;
    }
    ++any_hit_batches_;
    any_hit_lanes_ += batch.calls.size();
    any_hit_timeouts_ += late ? 1 : 0;
    any_hit_wait_ += now_ - since;
    messages_.batches.push(now_, batch);
  }

  // --- 7 retire ----------------------------------------------------------------------------------------------------
  void retire() {
    Warp* oldest = nullptr;
    for (Warp& warp : warps_) {
      if (!warp.used || (oldest != nullptr && oldest->age < warp.age)) continue;
      const bool finished = std::all_of(std::begin(warp.lanes), std::end(warp.lanes), [](const Lane& lane) {
        return lane.state == State::finished || lane.state == State::absent;
      });
      if (finished) oldest = &warp;
    }
    if (oldest == nullptr || !messages_.dones.has_room(now_)) return;
    messages_.dones.push(now_, {oldest->slot, oldest->round});
    warp_latency_.add(now_ - oldest->accepted);
    for (unsigned l = 0; l < kLanes; ++l) written_before_[{oldest->slot, l}] = oldest->lanes[l].written;
    *oldest = {};
  }

  // --- 8 schedule --------------------------------------------------------------------------------------------------
  void schedule() {
    std::vector<unsigned> candidates;
    for (unsigned w = 0; w < warps_.size(); ++w) {
      const bool ready = walks() ? waits_for(warps_[w]) == kReady
                                 : std::any_of(std::begin(warps_[w].lanes), std::end(warps_[w].lanes),
                                               [](const Lane& lane) { return lane.state == State::ready; });
      if (warps_[w].used && ready) candidates.push_back(w);
    }
    if (candidates.empty() || fetch_queue_.size() + kLanes > config_.memory.queue) {
      count_stall(!candidates.empty());
      return;
    }
    const unsigned chosen = choose(candidates);
    last_ = chosen;
    last_age_ = warps_[chosen].age;
    ++selections_;
    for (const Lane& lane : warps_[chosen].lanes) {
      lanes_active_ += lane.state != State::absent && lane.state != State::finished ? 1 : 0;
      lanes_handled_ += lane.state == State::ready ? 1 : 0;
    }
    if (walks()) return walk_start(chosen);
    for (unsigned l = 0; l < kLanes; ++l) {
      if (warps_[chosen].lanes[l].state == State::ready) handle({chosen, l});
    }
  }
  unsigned choose(const std::vector<unsigned>& candidates) const {
    const auto older = [this](unsigned a, unsigned b) { return warps_[a].age < warps_[b].age; };
    const unsigned oldest = *std::min_element(candidates.begin(), candidates.end(), older);
    if (config_.scheduler.policy == "oldest_first") return oldest;
    if (config_.scheduler.policy == "greedy_then_oldest") {
      const bool again = last_ && std::find(candidates.begin(), candidates.end(), *last_) != candidates.end() &&
                         warps_[*last_].age == last_age_;
      return again ? *last_ : oldest;
    }
    for (unsigned i = 1; i <= warps_.size(); ++i) {  // round_robin, from the one after the last
      const unsigned w = static_cast<unsigned>(((last_ ? *last_ : warps_.size() - 1) + i) % warps_.size());
      if (std::find(candidates.begin(), candidates.end(), w) != candidates.end()) return w;
    }
    throw std::logic_error("no candidate");
  }
  void handle(LaneName name) {
    using traces::EventKind;
    using traces::NodeKind;
    Warp& warp = warps_[name.first];
    Lane& lane = warp.lanes[name.second];
    const traces::Event& e = event(lane);
    const std::uint64_t at = std::uint64_t{e.node} * unit();
    switch (e.kind()) {
      case EventKind::visit_internal:
        visit(name, NodeKind::internal, std::uint64_t{definition(warp, e).address} * unit(), false);
        return;
      case EventKind::visit_instance:
        trigger(name, at);
        visit(name, kind_in_image(e, NodeKind::instance), at,
              e.detail == 0 && config_.memory.traffic.blas_header_read && !compact() && !compressed() && !quantised());
        return;
      case EventKind::visit_leaf:
        trigger(name, at);
        visit(name, kind_in_image(e, leaf_unit_ != 1 ? NodeKind::procedural : NodeKind::triangle), at, false);
        return;
      case EventKind::cull:
        --lane.depth;
        finish_event(name, e.written());
        return;
      default:
        read_entry(name);
    }
  }
  Region region_of(traces::NodeKind kind, std::uint64_t address) const {
    if (is_instance(kind)) return Region::instance;
    if (header_.two_level && address >= header_.blas_base) return Region::blas;
    return kind == traces::NodeKind::internal ? Region::tlas : Region::leaf;
  }
  void visit(LaneName name, traces::NodeKind kind, std::uint64_t address, bool header) {
    lane(name).state = State::memory;
    fetch(name, kind, address, header);
  }
  void fetch(LaneName name, traces::NodeKind kind, std::uint64_t address, bool header) {
    const Region region = region_of(kind, address);
    ++node_visits_[modules::index(region)];
    for (auto& [number, fetch] : fetches_) {
      if (fetch.entry != name.first || fetch.address != address || fetch.header != header || fetch.second) continue;
      if (!config_.memory.merge_in_flight && fetch.opened != now_) continue;
      fetch.lanes.push_back(name.second);
      return;
    }
    Fetch fetch{name.first, name.second, address, header, kind, region, {name.second}, {}, 0, 0, now_, false, 0, {}};
    const bool leaf = kind == traces::NodeKind::triangle || is_procedural(kind);
    if (leaf && config_.memory.traffic.leaf_descriptor_read)
      fetch.sectors.emplace_back(address / kSector * kSector, region);
    if (leaf) fetch.wait = config_.memory.traffic.descriptor_wait;
    for (const std::uint64_t sector : sectors_of(kind, address)) {
      (fetch.wait > 0 ? fetch.later : fetch.sectors).emplace_back(sector, region);
    }
    if (header) fetch.wait = config_.memory.traffic.header_wait;
    std::uint64_t below = header_.blas_base;  // the tree that an instance leaf leads to: the BLAS, or an object's TLAS
    for (const traces::SceneLeaf& placed : header_.scene_leaves) {
      if (placed.address == address) below = header_.object_roots[placed.object] - unit();
    }
    for (std::uint64_t b = 0; header && b < traces::kHeaderBytes; b += kSector) {
      (fetch.wait > 0 ? fetch.later : fetch.sectors)
          .emplace_back(below + b, region_of(traces::NodeKind::internal, below));
    }
    ++node_fetches_[modules::index(region)];
    queue(std::move(fetch));
  }
  void queue(Fetch fetch) {
    fetch_queue_.push_back(next_fetch_);
    fetches_.emplace(next_fetch_++, std::move(fetch));
    if (!config_.memory.oldest_warp_first) return;
    const auto age = [this](std::uint64_t number) { return warps_[fetches_.at(number).entry].age; };
    const bool begun = fetches_.at(fetch_queue_.front()).sent > 0;
    std::stable_sort(fetch_queue_.begin() + (begun ? 1 : 0), fetch_queue_.end(),
                     [&](std::uint64_t a, std::uint64_t b) { return age(a) < age(b); });
  }
  void read_entry(LaneName name) {
    Warp& warp = warps_[name.first];
    Lane& lane = warp.lanes[name.second];
    const bool backwards = header_.checkpoint_order == traces::CheckpointOrder::lifo;
    const std::uint64_t index = backwards ? lane.source - 1 - lane.reads : lane.reads;
    const std::uint64_t in_bin = binned() ? next_of_bins(name) : 0;
    ++lane.reads;
    ++entries_read_;
    if (!charged()) return entry_read(name);
    const std::uint64_t first = binned() ? in_bin : entry_address(warp, name.second, (warp.round + 1) % 2, index);
    const std::uint64_t last = first + entry_bytes() - 1;
    std::vector<std::uint64_t> sectors{first / kSector * kSector};
    if (last / kSector * kSector != sectors[0]) {
      sectors.push_back(last / kSector * kSector);
      ++straddling_read_;
    }
    if (backwards) std::reverse(sectors.begin(), sectors.end());
    for (const std::uint64_t sector : sectors) {
      if (config_.checkpoint.read_buffer && lane.held_sector == sector) continue;
      read_queue_.push_back({name, sector});
      ++lane.sectors_due;
    }
    lane.held_sector = sectors.back();
    if (lane.sectors_due > 0) {
      lane.state = State::read;
    } else {
      entry_read(name);
    }
  }

  // --- sibling prefetcher ------------------------------------------------------------------------------------------
  struct Prefetch {
    std::uint64_t address;
    Region region;
    unsigned sectors, sent = 0;
  };
  std::uint64_t child_address(const Record& record, unsigned slot) const {
    std::uint64_t address = record.child_base;
    for (unsigned s = 0; s < slot; ++s) address += stored(record.node->child_kinds[s]);
    return address;
  }
  void remember(const Warp& warp, LaneName name, const traces::Event& e) {
    if (!config_.sibling_prefetch) return;
    const traces::NodeDefinition& node = definition(warp, e);
    const auto siblings_with_leaf = [&](unsigned mask) {
      bool leaf = false;
      for (unsigned s = 0; s < node.child_count; ++s) {
        leaf = leaf || ((mask >> s & 1) != 0 && node.child_kinds[s] != traces::NodeKind::internal);
      }
      return leaf && std::popcount(mask) >= 2;
    };
    const Record record{std::uint64_t{node.address} * unit(), std::uint64_t{node.child_base} * unit(), &node,
                        e.pushed()};
    if (siblings_with_leaf(e.pushed())) keep(lane(name), record);
    const bool in_blas = header_.two_level && record.node_address >= header_.blas_base;
    if (siblings_with_leaf(e.checkpoints) && !in_blas) {
      auto& visits = written_together_[{warp.slot, name.second}];
      visits.push_back(record);
      visits.back().hit = e.checkpoints;
    }
  }
  void keep(Lane& lane, const Record& record) {
    lane.records.push_back(record);
    if (lane.records.size() > config_.prefetcher.records) lane.records.pop_front();
  }
  /// Whether the record has the leaf among its hit children.
  bool has(const Record& record, std::uint64_t leaf) const {
    for (unsigned s = 0; s < record.node->child_count; ++s) {
      if ((record.hit >> s & 1) != 0 && child_address(record, s) == leaf) return true;
    }
    return false;
  }
  void trigger(LaneName name, std::uint64_t leaf) {
    if (!config_.sibling_prefetch) return;
    Lane& lane = this->lane(name);
    for (auto record = lane.records.rbegin(); record != lane.records.rend(); ++record) {
      if (!has(*record, leaf)) continue;
      if (!record->triggered) queue_siblings(*record, leaf);
      record->triggered = true;
      return;
    }
    // The entry that named this leaf says with which siblings it was written.
    if (!config_.prefetcher.replayed || entry_bytes() == 8 || lane.taken != leaf) return;
    const auto& visits = written_together_[{warps_[name.first].slot, name.second}];
    const auto visit = std::find_if(visits.rbegin(), visits.rend(), [&](const Record& r) { return has(r, leaf); });
    if (visit == visits.rend()) return;
    ++triggers_replayed_;
    queue_siblings(*visit, leaf);
    keep(lane, *visit);
    lane.records.back().triggered = true;
  }
  void queue_siblings(const Record& record, std::uint64_t leaf) {
    ++triggers_;
    for (unsigned s = 0; s < record.node->child_count; ++s) {
      const std::uint64_t address = child_address(record, s);
      if ((record.hit >> s & 1) == 0 || address == leaf || !queued_now(record.node_address, address)) continue;
      const traces::NodeKind kind = record.node->child_kinds[s];
      const bool there = std::any_of(prefetch_queue_.begin(), prefetch_queue_.end(),
                                     [&](const Prefetch& p) { return p.address == address; });
      if (there) {
        ++prefetch_merged_;
      } else if (prefetch_queue_.size() >= config_.prefetcher.queue) {
        ++prefetch_dropped_;
      } else {
        const auto sectors = static_cast<unsigned>(sectors_of(kind, address).size());
        prefetch_queue_.push_back({address, region_of(kind, address), sectors});
        ++prefetch_nodes_;
      }
    }
  }
  /// Whether no lane has asked for this sibling of this node in this cycle yet; remembers it.
  bool queued_now(std::uint64_t node, std::uint64_t sibling) {
    if (asked_cycle_ != now_) asked_.clear();
    asked_cycle_ = now_;
    const bool first = asked_.insert({node, sibling}).second;
    if (!first) ++prefetch_merged_;
    return first;
  }

  // --- 9 accept ----------------------------------------------------------------------------------------------------
  void accept() {
    if (messages_.calls.front(now_) == nullptr) return;
    for (unsigned w = 0; w < warps_.size(); ++w) {
      Warp& warp = warps_[w];
      if (warp.used) continue;
      const TraceCall call = messages_.calls.pop(now_);
      ++calls_;
      warp.used = true;
      warp.group = call.group;
      warp.slot = call.slot;
      warp.round = call.round;
      warp.age = next_age_++;
      warp.accepted = now_;
      for (unsigned l = 0; l < call.group->rays.size(); ++l) {
        const traces::Ray& ray = call.group->rays[l];
        if (call.round >= ray.rounds.size()) continue;
        Lane& lane = warp.lanes[l];
        lane.ray = &ray;
        for (unsigned r = 0; r < call.round; ++r) lane.next += ray.rounds[r].event_count;
        lane.end = lane.next + ray.rounds[call.round].event_count;
        if (!ray.rounds[call.round].replay) written_together_[{call.slot, l}].clear();
        lane.source = written_before_[{call.slot, l}];
        if (header_.checkpoint && binned()) begin_bins({w, l}, ray);
        lane.depth = ray.rounds[call.round].replay ? 0 : 1;
        lane.heap = static_cast<int>(ray.rounds[call.round].preloaded);
        lane.state = lane.next == lane.end ? State::finished : State::ready;
      }
      if (walks()) walk_begin(warp);
      return;
    }
  }

  // --- warps that walk together (docs/model/warp_walk.md) ----------------------------------------------------------
  bool walks() const { return config_.traversal == modules::TraversalWay::warp; }
  // A lane's test in a slot bears the lane's name with the slot.
  static LaneName test_name(unsigned entry, unsigned slot, unsigned lane) { return {entry, slot * kLanes + lane}; }
  Wait walk_waits_for(const Warp& warp) const {
    const WarpWalk& walk = warp.walk;
    const auto any = [&](auto&& holds) { return std::any_of(walk.stack.begin(), walk.stack.end(), holds); };
    if (walk.next(config_.warp_stack.ahead, config_.warp_stack.window) != nullptr) return kReady;
    if (any([](const WarpWalk::Entry& e) { return e.slot && !e.fetched; })) return kMemory;
    if (walk.moving || !walk.done.empty()) return kStack;
    if (any([](const WarpWalk::Entry& e) { return e.slot && !e.testing.empty(); })) return kUnit;
    return walk.hits_held() > 0 ? kAnyHit : kRetire;
  }
  void walk_begin(Warp& warp) {
    WarpWalk::Entry root;
    for (unsigned l = 0; l < kLanes; ++l) {
      Lane& lane = warp.lanes[l];
      if (lane.state != State::ready) continue;
      lane.state = State::unit;
      warp.walk.read(l, *lane.ray, lane.next);
      warp.walk.left[l] = lane.end - lane.next;
      root.events[l] = lane.next;
      root.address = address_of(warp, event(lane));
      root.kind = event(lane).kind() == traces::EventKind::visit_internal ? traces::NodeKind::internal : leaf_kind();
    }
    if (!root.events.empty()) warp.walk.stack.push_back(root);
  }
  std::uint64_t address_of(const Warp& warp, const traces::Event& e) const {
    return e.kind() == traces::EventKind::visit_internal ? definition(warp, e).address : e.node;
  }
  traces::NodeKind kind_of_child(const traces::NodeDefinition& parent, std::uint64_t address) const {
    std::uint64_t at = parent.child_base;
    for (unsigned s = 0; s < parent.child_count; ++s) {
      const bool wide = parent.child_kinds[s] == traces::NodeKind::wide_procedural;
      if (at == address && parent.child_kinds[s] != traces::NodeKind::internal)
        return wide ? parent.child_kinds[s] : leaf_kind();
      if (at == address) return traces::NodeKind::internal;
      at += stored(parent.child_kinds[s]) / unit();
    }
    throw std::logic_error("no such child");
  }
  traces::NodeKind leaf_kind() const {
    return leaf_unit_ != 1 ? traces::NodeKind::procedural : traces::NodeKind::triangle;
  }
  const traces::Event& walk_event(const Warp& warp, const WarpWalk::Entry& entry, unsigned lane) const {
    return warp.lanes[lane].ray->events[entry.events.at(lane)];
  }
  void walk_event_done(Warp& warp, unsigned lane) {
    if (--warp.walk.left[lane] == 0) warp.lanes[lane].state = State::finished;
  }
  void walk_start(unsigned w) {
    Warp& warp = warps_[w];
    WarpWalk& walk = warp.walk;
    const auto entry = walk.place_of(walk.next(config_.warp_stack.ahead, config_.warp_stack.window));
    lanes_handled_ += entry->events.size();
    ++walk_entries_;
    std::vector<unsigned> visiting;
    for (const auto& [lane, number] : entry->events) {
      const traces::Event& e = walk_event(warp, *entry, lane);
      ++events_[static_cast<std::size_t>(e.kind())];
      if (e.kind() != traces::EventKind::cull) visiting.push_back(lane);
    }
    if (visiting.empty()) {
      ++walk_dropped_;
      for (const auto& [lane, number] : entry->events) walk_event_done(warp, lane);
      walk.stack.erase(entry);
    } else {
      const unsigned slot = walk.free_slot();
      entry->slot = slot;
      walk_under_way_ += walk.under_way();
      walk_in_vain_ += entry->events.size() - visiting.size();
      for (const auto& [lane, number] : entry->events) {
        entry->testing.push_back(lane);
      }
      const std::uint64_t address = entry->address * unit();
      fetch({w, slot}, entry->kind, address, false);
      node_visits_[modules::index(region_of(entry->kind, address))] += visiting.size() - 1;
    }
    walk_refill(warp);
  }
  void walk_fetched(const Fetch& fetch) {
    const auto entry = warps_[fetch.entry].walk.in_slot(fetch.leader);
    entry->fetched = true;
    const std::map<unsigned, std::size_t> lanes = entry->events;
    if (boxes_ && is_procedural(fetch.kind)) {
      for (const auto& [lane, number] : lanes) walk_result(test_name(fetch.entry, fetch.leader, lane));
      return;
    }
    for (const auto& [lane, number] : lanes) entry->to_test.push_back(lane);
    walk_arrived_[fetch.kind == traces::NodeKind::internal ? 0 : 1].emplace_back(fetch.entry, fetch.leader);
  }
  // Lanes of the nodes that came first are queued first, as long as tests of their kind are few enough.
  void walk_enter() {
    for (const unsigned kind : {0U, 1U}) {
      auto& arrived = walk_arrived_[kind];
      while (!arrived.empty() && (config_.warp_stack.tests == 0 || walk_tests_[kind] < config_.warp_stack.tests)) {
        const auto [w, slot] = arrived.front();
        const auto entry = warps_[w].walk.in_slot(slot);
        if (entry->to_test.size() == entry->events.size()) entry->number = ++nodes_that_came_;
        const unsigned lane = entry->to_test.front();
        entry->to_test.pop_front();
        if (entry->to_test.empty()) arrived.pop_front();
        ++walk_tests_[kind];
        Unit& unit = units_[kind == 0 ? 0 : ellipsoid_ ? 4 : leaf_unit_];
        queue_at(unit, {test_name(w, slot, lane), now_, walk_tests_of(warps_[w], *entry), entry->number});
      }
    }
  }
  unsigned walk_tests_of(const Warp& warp, const WarpWalk::Entry& entry) const {
    if (entry.kind == traces::NodeKind::triangle && compact()) return 4;
    for (const auto& [lane, number] : entry.events) {
      const traces::Event& e = walk_event(warp, entry, lane);
      if (e.kind() == traces::EventKind::visit_internal && config_.box_op_per_child) {
        return std::max(1U, unsigned{definition(warp, e).child_count});
      }
    }
    return 1;
  }
  void walk_result(LaneName name) {
    const unsigned lane = name.second % kLanes, slot = name.second / kLanes;
    Warp& warp = warps_[name.first];
    const auto entry = warp.walk.in_slot(slot);
    std::erase(entry->testing, lane);
    if (!boxes_ || entry->kind == traces::NodeKind::internal) {
      --walk_tests_[entry->kind == traces::NodeKind::internal ? 0 : 1];
    }
    const traces::Event& e = walk_event(warp, *entry, lane);
    if (e.kind() == traces::EventKind::visit_leaf && (boxes_ || traces::calls_any_hit(e.outcome()))) {
      auto& hits = warp.walk.hits[lane];
      hits.push_back(entry->events.at(lane));
      if (hits.size() == 1) walk_next_hit({name.first, lane});
    } else {
      walk_event_done(warp, lane);
    }
    if (!entry->testing.empty()) return;
    entry->children = walk_children(warp, *entry);
    if (!entry->children.empty()) return warp.walk.done.push_back(slot);
    warp.walk.stack.erase(entry);
    walk_refill(warp);
  }
  // The lane's next hit goes to the any-hit unit or waits for the shader.
  void walk_next_hit(LaneName name) {
    Warp& warp = warps_[name.first];
    Lane& lane = warp.lanes[name.second];
    if (warp.walk.hits[name.second].empty()) return;
    lane.next = warp.walk.hits[name.second].front();
    if (config_.any_hit_unit.enabled) return to_heap(name);
    lane.state = State::any_hit_wait;
    lane.waiting_since = now_;
  }
  void walk_hit_answered(LaneName name) {
    Warp& warp = warps_[name.first];
    warp.lanes[name.second].state = State::unit;
    warp.walk.hits[name.second].pop_front();
    walk_event_done(warp, name.second);
  }
  std::vector<WarpWalk::Entry> walk_children(Warp& warp, const WarpWalk::Entry& parent) {
    std::vector<WarpWalk::Entry> children;
    for (const auto& [lane, number] : parent.events) {
      for (const std::size_t child : warp.walk.children[lane][number]) {
        add_child(children, warp, lane, child, definition(warp, warp.lanes[lane].ray->events[number]));
      }
    }
    if (header_.child_order == traces::ChildOrder::slot) {
      std::sort(children.begin(), children.end(), [](const auto& a, const auto& b) { return a.address < b.address; });
    }
    return children;
  }
  // Children come above their parent and below those before them, as many a cycle as there are ports, those of the
  // oldest warp first. When a warp has no room for all children of a node, its lowest entries leave before.
  void walk_write() {
    for (unsigned written = 0; config_.warp_stack.write_ports == 0 || written < config_.warp_stack.write_ports;) {
      Warp* oldest = nullptr;
      for (Warp& warp : warps_) {
        if (!warp.used || warp.walk.moving || warp.walk.done.empty()) continue;
        if (oldest == nullptr || warp.age < oldest->age) oldest = &warp;
      }
      if (oldest == nullptr) return;
      WarpWalk& walk = oldest->walk;
      const auto parent = walk.in_slot(walk.done.front());
      if (!parent->writing && walk.waiting() + parent->children.size() > config_.warp_stack.entries) {
        while (walk.waiting() + parent->children.size() > config_.warp_stack.entries) {
          move_walk(*oldest, true);
          walk.spill_sector();
        }
        max_spilled_ = std::max<std::uint64_t>(max_spilled_, walk.memory.size());
        continue;
      }
      parent->writing = true;
      walk.stack.insert(parent, parent->children.front());
      parent->children.erase(parent->children.begin());
      ++written;
      if (parent->children.empty()) {
        walk.stack.erase(parent);
        walk.done.pop_front();
      }
      walk_most_ = std::max<std::uint64_t>(walk_most_, walk.waiting() + walk.memory.size());
      walk_refill(*oldest);
    }
  }
  // When none is left to start, some come back.
  void walk_refill(Warp& warp) {
    WarpWalk& walk = warp.walk;
    const bool slot = walk.under_way() < config_.warp_stack.ahead;
    if (!walk.moving && walk.done.empty() && walk.waiting() == 0 && !walk.memory.empty() && slot) {
      walk.fill_sector();
      move_walk(warp, false);
    }
  }
  void add_child(std::vector<WarpWalk::Entry>& children, const Warp& warp, unsigned lane, std::size_t number,
                 const traces::NodeDefinition& parent) const {
    const std::uint64_t address = address_of(warp, warp.lanes[lane].ray->events[number]);
    auto child = std::find_if(children.begin(), children.end(),
                              [address](const WarpWalk::Entry& other) { return other.address == address; });
    if (child == children.end()) {
      child = children.insert(
          child, WarpWalk::Entry{address, kind_of_child(parent, address), {}, {}, false, {}, {}, {}, false, 0});
    }
    child->events[lane] = number;
  }
  void move_walk(Warp& warp, bool write) {
    const auto entry = static_cast<unsigned>(&warp - warps_.data());
    warp.walk.moving = true;
    stack_queue_.push_back({{entry, 0}, map_.stack(sm_, warp.slot, 0, warp.walk.memory.size() / 2), write});
  }
  void walk_stack_moved(Warp& warp) {
    warp.walk.moving = false;
    warp.walk.filled();
    walk_refill(warp);
  }

  modules::RtUnitConfig config_;
  const traces::Header& header_;
  const AddressMap& map_;
  unsigned sm_;
  RtMessages& messages_;
  Memory memory_;
  Cycle now_ = 0;
  std::uint64_t order_ = 0, next_age_ = 0;
  std::uint64_t outstanding_ = 0;  // requests at the L1
  std::vector<Warp> warps_;
  std::vector<Unit> units_;  // box, triangle, sphere, Gaussian, transform
  unsigned leaf_unit_ = 1;
  bool ellipsoid_ = false;

  std::map<std::uint64_t, Fetch> fetches_;  // by number
  std::uint64_t next_fetch_ = 0;
  std::deque<std::uint64_t> fetch_queue_;
  std::deque<std::pair<Cycle, std::uint64_t>> hits_;  // when, of which fetch
  std::multimap<Cycle, Fetch> second_reads_;          // by when they begin
  std::deque<std::pair<LaneName, std::uint64_t>> read_queue_;
  std::deque<std::uint64_t> write_queue_;
  std::deque<LaneName> submitted_;
  std::deque<Prefetch> prefetch_queue_;
  struct StackMove {
    LaneName lane;
    std::uint64_t address;
    bool write;
  };
  std::deque<StackMove> stack_queue_;
  std::set<std::pair<std::uint64_t, std::uint64_t>> asked_;
  Cycle asked_cycle_ = ~Cycle{0};
  std::map<std::pair<unsigned, unsigned>, std::vector<Record>> written_together_;  // slot, lane
  std::map<std::pair<unsigned, unsigned>, std::uint64_t> written_before_;  // slot, lane: entries of the last round
  std::map<std::pair<unsigned, unsigned>, Bins> bins_;                     // slot, lane
  std::optional<unsigned> last_;
  std::uint64_t last_age_ = 0;

  bool counting_ = true;
  std::array<std::uint64_t, 4> node_visits_{}, node_fetches_{}, node_sectors_{};  // by region
  std::array<std::uint64_t, 6> events_{};
  std::array<std::uint64_t, kWaits> warp_cycles_{}, stalls_{};
  Distribution fetch_latency_, warp_latency_;
  std::uint64_t selections_ = 0, lanes_handled_ = 0, lanes_active_ = 0, stall_empty_ = 0, stall_queue_full_ = 0;
  std::uint64_t calls_ = 0, max_depth_ = 0, shader_batches_ = 0, shader_sectors_ = 0;
  bool boxes_ = false;                      ///< a shader tests what lies in a leaf
  std::vector<std::deque<HeapHit>> heaps_;  // [heap logic]
  std::deque<LaneName> fallen_out_;
  std::uint64_t heap_bounded_ = 0, heap_hidden_ = 0;
  std::uint64_t heap_hits_ = 0, heap_entered_ = 0, heap_busy_ = 0, heap_wait_ = 0;
  std::uint64_t any_hit_calls_ = 0, any_hit_batches_ = 0, any_hit_lanes_ = 0, any_hit_timeouts_ = 0, any_hit_wait_ = 0;
  std::uint64_t entries_written_ = 0, entries_read_ = 0, sectors_written_ = 0, sectors_read_ = 0;
  std::uint64_t straddling_written_ = 0, straddling_read_ = 0, max_entries_ = 0, blocked_cycles_ = 0;
  std::uint64_t triggers_ = 0, triggers_replayed_ = 0, prefetch_nodes_ = 0, prefetch_merged_ = 0, prefetch_dropped_ = 0,
                prefetch_sectors_ = 0;
  std::uint64_t nodes_that_came_ = 0;                                      // to units
  std::array<std::deque<std::pair<unsigned, unsigned>>, 2> walk_arrived_;  // nodes, leaves: entry, slot
  std::array<unsigned, 2> walk_tests_{};                                   // of each, queued or in pipelines
  std::uint64_t spills_ = 0, fills_ = 0, max_spilled_ = 0;
  std::uint64_t walk_entries_ = 0, walk_dropped_ = 0, walk_in_vain_ = 0, walk_under_way_ = 0, walk_most_ = 0;
};

}  // namespace grtx::sim::plain
