// A second implementation of the RT unit: one file, no SystemC, no skipping, every cycle ticked, lanes kept as plain
// structs. Written from docs/model/{rt_scheduler,warp_buffer,memory_scheduler,intersection_units,checkpoint_unit,
// sibling_prefetcher,stack_unit}.md, so that the pages, the SystemC model and this file check one another to the cycle.
// It brings the surroundings of RtBench with it: a SIMT core that answers after a fixed time, and memories of fixed
// latency.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::sim::test {

class PlainRtUnit {
 public:
  struct Done {
    unsigned slot, round;
    std::uint64_t cycle;
    friend bool operator==(const Done&, const Done&) = default;
  };
  struct Batch {
    unsigned slot, round;
    std::uint64_t lanes;
    std::uint64_t cycle;
    friend bool operator==(const Batch&, const Batch&) = default;
  };
  struct Request {
    std::uint64_t address;
    bool write;
    std::uint64_t cycle;
    friend bool operator==(const Request&, const Request&) = default;
  };
  std::vector<Done> dones;
  std::vector<Batch> batches;
  std::vector<Request> requests[4];  ///< node, checkpoint, prefetch, stack

  PlainRtUnit(const modules::RtUnitConfig& config, const traces::Header& header, const modules::MemoryMap& map,
              unsigned memory_latency, unsigned any_hit_cycles)
      : config_(config), header_(header), map_(map), memory_latency_(memory_latency), any_hit_cycles_(any_hit_cycles) {
    warps_.resize(config.warp_buffer.entries);
    const bool procedural =
        header.accel == traces::AccelKind::ellipsoid || header.accel == traces::AccelKind::tlas_sphere;
    const auto pipelines = [](const modules::IntersectionUnit::Config& c) {
      return Unit{c.count, c.latency, c.interval, std::vector<std::uint64_t>(c.count, 0), {}, {}};
    };
    // Layout obb: the ray is rotated first.
    modules::IntersectionUnit::Config box = config.ray_box;
    if (header.layout == traces::NodeLayout::obb) box.latency += config.box_rotate_latency;
    units_ = {pipelines(box), pipelines(config.ray_triangle), pipelines(config.ray_sphere),
              pipelines(config.ray_transform)};
    leaf_unit_ = procedural ? 2 : 1;
    ellipsoid_ = header.accel == traces::AccelKind::ellipsoid;
  }

  void launch(const traces::RayGroup& group, unsigned slot) {
    groups_.resize(std::max<std::size_t>(groups_.size(), slot + std::size_t{1}));
    groups_[slot] = &group;
    to_call_.push_back({slot, 0});
  }
  void run(std::uint64_t limit = 1'000'000) {
    for (now_ = 0; now_ < limit; ++now_) {
      surroundings();
      take_results();
      start_operations();
      take_responses();
      issue();
      hand_over();
      any_hit();
      retire();
      schedule();
      accept();
      if (to_call_.empty() && calls_.empty() && pending_calls_ == 0 && idle()) return;
    }
    throw std::runtime_error("the plain RT unit does not come to an end");
  }

 private:
  enum class State { absent, ready, memory, unit, any_hit_wait, any_hit_run, read, write, stack, finished };
  struct Record {  // of the sibling prefetcher
    std::uint64_t node_address, child_base;
    const traces::NodeDefinition* node;
    unsigned hit;
    bool triggered = false;
  };
  /// What stands at a place of a ray's log: an entry (no places), or a run entry that names others.
  struct ListItem {
    std::vector<std::uint64_t> names;
  };
  /// A ray's log: all that was ever appended, and where the lists of two rounds begin and end.
  struct Log {
    std::vector<ListItem> items;
    std::uint64_t list_begin = 0;              // of the list being written
    std::uint64_t source = 0, source_end = 0;  // of that being read
  };
  struct Lane {
    State state = State::absent;
    const traces::Ray* ray = nullptr;
    std::size_t next = 0, end = 0;    // events of the round
    std::uint64_t waiting_since = 0;  // any-hit
    // checkpoint unit
    unsigned to_write = 0;  // entries submitted, not yet taken
    bool flush = false;     // the open sector is an item behind them
    std::uint64_t written = 0, reads = 0, source = 0;
    std::optional<std::uint64_t> open_sector, held_sector;
    unsigned sectors_due = 0;  // of the entry being read
    // forward = reference: the run being forwarded (places of the log), the entry read last, and what is to be read.
    std::vector<std::uint64_t> run;
    std::uint64_t entry_place = 0;
    std::deque<ListItem> items;  // to be written
    std::deque<std::uint64_t> run_to_read;
    bool reading_run = false, run_down = false;
    bool forwarded = false;  // the entry to be written is the one read last
    // The source list: its sectors in the order of reading, which of them is in use (1: the first), the next to be
    // read ahead; entries read, and how many of them have had their nodes prefetched.
    std::vector<std::uint64_t> source_sectors;
    std::size_t in_use = 0, next_ahead = 0;
    std::uint64_t entries_read = 0, named = 0;
    std::size_t begin = 0;  // first event of the round
    std::deque<Record> records;
    std::uint64_t taken = ~std::uint64_t{0};  // node that the last source entry named
    // stack unit
    std::uint64_t depth = 0, spilled = 0;  // entries in all, and of these in memory
    unsigned held_back = 0;                // checkpoint entries that wait for the stack
  };
  struct Warp {
    bool used = false;
    unsigned slot = 0, round = 0;
    std::uint64_t age = 0;
    bool shader_busy = false;
    Lane lanes[32];
  };
  using LaneName = std::pair<unsigned, unsigned>;  // entry, lane
  struct Operation {
    LaneName lane;
    std::uint64_t queued;
    unsigned tests;
  };
  struct Result {
    std::uint64_t due, order;
    LaneName lane;
  };
  struct Unit {
    unsigned count, latency, interval;
    std::vector<std::uint64_t> free_from;
    std::deque<Operation> queue;
    std::vector<Result> flying;
  };
  struct Fetch {
    unsigned entry;
    std::uint64_t address;
    bool header;
    traces::NodeKind kind;
    std::vector<unsigned> lanes;
    std::vector<std::uint64_t> sectors;
    std::size_t sent = 0, back = 0;
    std::uint64_t opened;
  };
  struct Response {
    std::uint64_t visible;
    std::size_t what;  // node: fetch number; checkpoint: see below
  };

  // --- what the trace says -----------------------------------------------------------------------------------------
  const traces::Event& event(const Lane& lane) const { return lane.ray->events[lane.next]; }
  const traces::NodeDefinition& definition(const Warp& warp, const traces::Event& e) const {
    return groups_[warp.slot]->nodes[e.node];
  }
  // docs/model/node-image.md: nodes of layout compact have 80 B, but instance leaves two of these, of which the first
  // is read, and leaves of four triangles; of layout compressed all nodes have 64 B. Neither has headers to read.
  bool compact() const { return header_.layout == traces::NodeLayout::compact; }
  bool compressed() const { return header_.layout == traces::NodeLayout::compressed; }
  std::uint64_t unit() const { return compact() ? 80 : 64; }
  std::uint64_t stored(traces::NodeKind kind) const {
    if (compact()) return kind == traces::NodeKind::instance ? 160 : 80;
    if (compressed()) return 64;
    return traces::node_bytes(kind, header_.bvh_width);
  }
  std::uint64_t read(traces::NodeKind kind) const {
    if (compact()) return 80;
    if (compressed()) return 64;
    return kind == traces::NodeKind::instance ? config_.memory.traffic.instance_leaf_bytes : stored(kind);
  }
  std::vector<std::uint64_t> sectors_of(traces::NodeKind kind, std::uint64_t address) const {
    std::vector<std::uint64_t> sectors;
    for (std::uint64_t b = address / 32 * 32; b < address + read(kind); b += 32) sectors.push_back(b);
    return sectors;
  }

  // --- SIMT core and memory as in RtBench --------------------------------------------------------------------------
  void surroundings() {
    // Retired and fired in cycle c, seen here in c + 1. This stage runs before those that take messages, so a place
    // freed in a cycle is free from the next one on, as in a Link.
    while (!done_messages_.empty() && done_messages_.front().cycle + 1 <= now_) {
      const Done done = done_messages_.front();
      done_messages_.pop_front();
      --pending_calls_;
      if (rounds(done.slot) > done.round + 1) to_call_.push_back({done.slot, done.round + 1});
    }
    while (!batch_messages_.empty() && batch_messages_.front().cycle + 1 <= now_) {
      const Batch batch = batch_messages_.front();
      batch_messages_.pop_front();
      shading_.push_back({now_ + any_hit_cycles_, batch});
    }
    if (!shading_.empty() && shading_.front().first <= now_ && shaded_.size() < 2) {
      shaded_.push_back({now_ + 1, shading_.front().second});
      shading_.pop_front();
    }
    if (!to_call_.empty() && calls_.size() < 2) {
      calls_.push_back({now_ + 1, to_call_.front()});
      to_call_.pop_front();
      ++pending_calls_;
    }
  }
  std::size_t rounds(unsigned slot) const {
    std::size_t most = 0;
    for (const auto& ray : groups_[slot]->rays) most = std::max(most, ray.rounds.size());
    return most;
  }

  // --- 1 results ---------------------------------------------------------------------------------------------------
  void take_results() {
    for (Unit& unit : units_) {
      std::sort(unit.flying.begin(), unit.flying.end(),
                [](const Result& a, const Result& b) { return std::tie(a.due, a.order) < std::tie(b.due, b.order); });
      while (!unit.flying.empty() && unit.flying.front().due <= now_) {
        const LaneName name = unit.flying.front().lane;
        unit.flying.erase(unit.flying.begin());
        // A procedural leaf of a monolithic BVH: transformed first, then tested.
        if (ellipsoid_ && &unit == &units_[3]) {
          units_[2].queue.push_back({name, now_, 1});
        } else {
          result(name);
        }
      }
    }
  }
  void result(LaneName name) {
    Warp& warp = warps_[name.first];
    Lane& lane = warp.lanes[name.second];
    const traces::Event& e = event(lane);
    if (e.kind() != traces::EventKind::visit_instance) --lane.depth;
    if (e.kind() == traces::EventKind::visit_internal) lane.depth += static_cast<unsigned>(std::popcount(e.pushed()));
    if (e.kind() == traces::EventKind::visit_leaf && traces::calls_any_hit(e.outcome())) {
      lane.state = State::any_hit_wait;
      lane.waiting_since = now_;
      return;
    }
    if (e.kind() == traces::EventKind::visit_internal) remember(name, e);
    finish_event(name, static_cast<unsigned>(std::popcount(unsigned{e.checkpoints})));
  }
  bool logged() const { return config_.checkpoint.forward == modules::CheckpointForward::reference; }
  Log& log_of(LaneName name) { return logs_[{warps_[name.first].slot, name.second}]; }
  std::uint64_t place_address(LaneName name, std::uint64_t place) const {
    const std::uint64_t places = (4 * header_.checkpoint_capacity + 7) / 8 * 8;
    return map_.checkpoint_log(map_.ray_slot(0, warps_[name.first].slot, name.second)) + place % places * entry_bytes();
  }
  /// Which items a lane's entries become.
  void list_entries(LaneName name, unsigned entries, bool forwarded, bool last) {
    Lane& lane = warps_[name.first].lanes[name.second];
    Log& log = log_of(name);
    const auto append = [&](ListItem item) {
      log.items.push_back(item);
      lane.items.push_back(std::move(item));
    };
    const auto close = [&] {
      if (lane.run.size() == 1) append({});
      if (lane.run.size() > 1) append({lane.run});
      lane.run.clear();
    };
    const auto young = [&] { return log.items.size() - lane.entry_place <= header_.checkpoint_capacity; };
    if (entries > 0 && forwarded) {
      bool goes_on = false;
      if (!lane.run.empty()) {
        const auto step = static_cast<std::int64_t>(lane.entry_place - lane.run.back());
        goes_on = lane.run.size() == 1 ? step == 1 || step == -1
                                       : step == static_cast<std::int64_t>(lane.run[1] - lane.run[0]);
      }
      if (!goes_on || !young()) close();
      if (young()) {
        lane.run.push_back(lane.entry_place);
      } else {
        append({});
      }
    } else if (entries > 0) {
      close();
      for (unsigned i = 0; i < entries; ++i) append({});
    }
    if (last) close();
  }
  // The event is over but for its checkpoint entries.
  void finish_event(LaneName name, unsigned entries) {
    Lane& lane = warps_[name.first].lanes[name.second];
    lane.forwarded = event(lane).kind() == traces::EventKind::replay_forward;
    ++lane.next;
    if (config_.warp_buffer.spill && stack_moves(name)) {
      lane.held_back = entries;
      lane.state = State::stack;
    } else {
      submit(name, entries);
    }
  }
  // Keeps at most stack_entries in the warp buffer, and one there for an event that takes it. Entries move by sectors
  // of 32 B: two with a t, four without.
  unsigned sector_entries() const { return header_.pop_test == traces::PopTest::on ? 2 : 4; }
  bool stack_moves(LaneName name) {
    Lane& lane = warps_[name.first].lanes[name.second];
    const std::size_t before = stack_queue_.size();
    while (lane.depth - lane.spilled > config_.warp_buffer.stack_entries) {
      stack_queue_.push_back({name, stack_address(name, lane.spilled / sector_entries()), true});
      lane.spilled += sector_entries();
    }
    if (lane.depth == lane.spilled && lane.spilled > 0 && lane.next != lane.end) {
      const auto kind = event(lane).kind();
      if (kind != traces::EventKind::replay_take && kind != traces::EventKind::replay_forward) {
        lane.spilled -= sector_entries();
        stack_queue_.push_back({name, stack_address(name, lane.spilled / sector_entries()), false});
      }
    }
    return stack_queue_.size() != before;
  }
  std::uint64_t stack_address(LaneName name, std::uint64_t sector) const {
    return map_.stack_sector(map_.ray_slot(0, warps_[name.first].slot, name.second), sector);
  }
  void stack_moved(LaneName name) { submit(name, warps_[name.first].lanes[name.second].held_back); }
  void submit(LaneName name, unsigned entries) {
    Lane& lane = warps_[name.first].lanes[name.second];
    const bool last = lane.next == lane.end;
    lane.to_write = entries;
    std::uint64_t ends_at = (lane.written + entries) * entry_bytes();
    if (header_.checkpoint && logged()) {
      list_entries(name, entries, lane.forwarded, last);
      lane.to_write = static_cast<unsigned>(lane.items.size());
      const Log& log = log_of(name);
      ends_at = log.items.size() == log.list_begin ? 0 : log.items.size() * entry_bytes();
    }
    lane.flush = last && config_.checkpoint.write_combine && ends_at % 32 != 0;
    if (lane.to_write > 0 || lane.flush) {
      lane.state = State::write;
      submitted_.push_back(name);
    } else {
      lane.state = last ? State::finished : State::ready;
    }
  }

  // --- 2 start -----------------------------------------------------------------------------------------------------
  void start_operations() {
    for (Unit& unit : units_) {
      for (std::uint64_t& free : unit.free_from) {
        if (free > now_ || unit.queue.empty() || unit.queue.front().queued >= now_) continue;
        const Operation op = unit.queue.front();
        unit.queue.pop_front();
        free = now_ + std::uint64_t{op.tests} * unit.interval;
        unit.flying.push_back({now_ + unit.latency + std::uint64_t{op.tests - 1} * unit.interval, order_++, op.lane});
      }
    }
  }

  // --- 3 responses -------------------------------------------------------------------------------------------------
  void take_responses() {
    for (unsigned i = 0; i < config_.memory.sectors_per_cycle; ++i) {
      if (node_responses_.empty() || node_responses_.front().visible > now_) break;
      Fetch& fetch = fetches_.at(node_responses_.front().what);
      node_responses_.pop_front();
      if (++fetch.back == fetch.sectors.size()) {
        complete(fetch);
        for (auto it = fetches_.begin(); it != fetches_.end(); ++it) {
          if (&it->second == &fetch) {
            fetches_.erase(it);
            break;
          }
        }
      }
    }
    if (!checkpoint_responses_.empty() && checkpoint_responses_.front().visible <= now_) {
      const auto [reader, address, ahead] = checkpoint_readers_.front();
      checkpoint_responses_.pop_front();
      checkpoint_readers_.pop_front();
      if (reader) prefetch_named(*reader, address);
      if (reader && !ahead) {
        Lane& lane = warps_[reader->first].lanes[reader->second];
        if (--lane.sectors_due == 0) {
          if (lane.reading_run) {
            read_entry(*reader);
          } else {
            entry_read(*reader);
          }
        }
      }
    }
    if (!prefetch_responses_.empty() && prefetch_responses_.front().visible <= now_) prefetch_responses_.pop_front();
    if (!stack_responses_.empty() && stack_responses_.front().first <= now_) {
      const std::optional<LaneName> filled = stack_responses_.front().second;
      stack_responses_.pop_front();
      if (filled) stack_moved(*filled);
    }
  }
  void complete(const Fetch& fetch) {
    std::vector<unsigned> lanes = fetch.lanes;
    std::sort(lanes.begin(), lanes.end());
    const bool internal = fetch.kind == traces::NodeKind::internal;
    Unit& unit = units_[internal ? 0 : fetch.kind == traces::NodeKind::instance || ellipsoid_ ? 3 : leaf_unit_];
    for (const unsigned l : lanes) {
      Warp& warp = warps_[fetch.entry];
      Lane& lane = warp.lanes[l];
      lane.state = State::unit;
      unsigned tests = internal && config_.box_op_per_child ? definition(warp, event(lane)).child_count : 1;
      if (event(lane).kind() == traces::EventKind::visit_leaf && compact() && leaf_unit_ != 2) tests = 4;
      unit.queue.push_back({{fetch.entry, l}, now_, tests});
    }
  }
  // The source entry of the event is there: a replay_take pushes it, a replay_forward may submit it.
  void entry_read(LaneName name) {
    Lane& lane = warps_[name.first].lanes[name.second];
    if (event(lane).kind() == traces::EventKind::replay_take) {
      ++lane.depth;
      lane.taken = std::uint64_t{event(lane).node} * unit();
    }
    finish_event(name, event(lane).checkpoints);
  }

  // --- 4 issue -----------------------------------------------------------------------------------------------------
  void issue() {
    for (unsigned i = 0; i < config_.memory.sectors_per_cycle && !fetch_queue_.empty(); ++i) {
      const std::size_t number = fetch_queue_.front();
      Fetch& fetch = fetches_.at(number);
      if (fetch.opened < now_) {
        send(0, fetch.sectors[fetch.sent], false);
        node_responses_.push_back({now_ + memory_latency_, number});
        if (++fetch.sent == fetch.sectors.size()) fetch_queue_.pop_front();
      }
    }
    const bool read_blocked = !read_queue_.empty() && std::find(write_queue_.begin(), write_queue_.end(),
                                                                read_queue_.front().second) != write_queue_.end();
    if (!read_queue_.empty() && !read_blocked) {
      send(1, read_queue_.front().second, false);
      checkpoint_responses_.push_back({now_ + memory_latency_, 0});
      checkpoint_readers_.push_back({read_queue_.front().first, read_queue_.front().second, false});
      read_queue_.pop_front();
    } else if (!write_queue_.empty()) {
      send(1, write_queue_.front(), true);
      checkpoint_responses_.push_back({now_ + memory_latency_, 0});
      checkpoint_readers_.push_back({std::nullopt, 0, false});
      write_queue_.pop_front();
    } else {
      read_ahead();
    }
    if (!prefetch_queue_.empty()) {
      Prefetch& front = prefetch_queue_.front();
      send(2, front.address / 32 * 32 + 32 * front.sent, false);
      prefetch_responses_.push_back({now_ + memory_latency_, 0});
      if (++front.sent == front.sectors) prefetch_queue_.pop_front();
    }
    if (!stack_queue_.empty()) {
      const StackMove move = stack_queue_.front();
      stack_queue_.pop_front();
      send(3, move.address, move.write);
      stack_responses_.push_back({now_ + memory_latency_, move.write ? std::nullopt : std::optional(move.lane)});
      const bool more = !stack_queue_.empty() && stack_queue_.front().lane == move.lane;
      if (move.write && !more) stack_moved(move.lane);
    }
  }
  // The first lane in the queue that has a sector within its window; those before it have none and leave.
  void read_ahead() {
    while (!ahead_queue_.empty()) {
      const LaneName name = ahead_queue_.front();
      Lane& lane = warps_[name.first].lanes[name.second];
      const std::size_t window = lane.in_use + config_.checkpoint.read_ahead;
      if (lane.next_ahead < std::min(lane.source_sectors.size(), window)) {
        const std::uint64_t sector = lane.source_sectors[lane.next_ahead++];
        send(1, sector, false);
        checkpoint_responses_.push_back({now_ + memory_latency_, 0});
        checkpoint_readers_.push_back({name, sector, true});
        return;
      }
      ahead_queue_.pop_front();
    }
  }
  void queue_ahead(LaneName name) {
    if (config_.checkpoint.read_ahead == 0) return;
    if (std::find(ahead_queue_.begin(), ahead_queue_.end(), name) == ahead_queue_.end()) ahead_queue_.push_back(name);
  }
  bool backwards() const { return header_.checkpoint_order == traces::CheckpointOrder::lifo; }
  std::uint64_t source_address(LaneName name, std::uint64_t place) const {
    return logged() ? place_address(name, place)
                    : entry_address(warps_[name.first], name.second, (warps_[name.first].round + 1) % 2, place);
  }
  /// Places of the source list that have not been read, in the order of reading.
  std::vector<std::uint64_t> unread(LaneName name) {
    const Lane& lane = warps_[name.first].lanes[name.second];
    std::uint64_t begin = lane.reads, end = lane.source;
    if (logged()) {
      begin = log_of(name).source;
      end = log_of(name).source_end;
    } else if (backwards()) {
      begin = 0;
      end = lane.source - lane.reads;
    }
    std::vector<std::uint64_t> places;
    for (std::uint64_t place = begin; place < end; ++place) places.push_back(place);
    if (backwards()) std::reverse(places.begin(), places.end());
    return places;
  }
  void list_source_sectors(LaneName name) {
    Lane& lane = warps_[name.first].lanes[name.second];
    for (const std::uint64_t place : unread(name)) {
      std::vector<std::uint64_t> sectors = sectors_of(source_address(name, place));
      if (backwards()) std::reverse(sectors.begin(), sectors.end());
      for (const std::uint64_t sector : sectors) {
        if (lane.source_sectors.empty() || lane.source_sectors.back() != sector) lane.source_sectors.push_back(sector);
      }
    }
  }
  /// The sector from which reading goes on behind a place of the list.
  void use_source_sector(Lane& lane, std::uint64_t sector) {
    while (lane.in_use == 0 || lane.source_sectors[lane.in_use - 1] != sector) ++lane.in_use;
    lane.next_ahead = std::max(lane.next_ahead, lane.in_use);
  }
  std::vector<std::uint64_t> sectors_of(std::uint64_t entry) const {
    const std::uint64_t first = entry / 32 * 32, last = (entry + entry_bytes() - 1) / 32 * 32;
    return first == last ? std::vector{first} : std::vector{first, last};
  }
  // A sector of the source list has come: nodes of the entries that lie in it as a whole.
  void prefetch_named(LaneName name, std::uint64_t sector) {
    if (!config_.checkpoint.prefetch_nodes) return;
    Lane& lane = warps_[name.first].lanes[name.second];
    if (lane.ray == nullptr || !lane.run_to_read.empty()) return;
    lane.named = std::max(lane.named, lane.entries_read);
    std::uint64_t entry = lane.entries_read;
    bool any = false;
    for (const std::uint64_t place : unread(name)) {
      if (logged() && !log_of(name).items[place].names.empty()) return;
      const bool inside = sectors_of(source_address(name, place)) == std::vector{sector};
      if (entry >= lane.named && inside) {
        prefetch_entry(name, entry);
        lane.named = entry + 1;
        any = true;
      } else if (any) {
        return;
      }
      ++entry;
    }
  }
  void prefetch_entry(LaneName name, std::uint64_t number) {
    using traces::EventKind;
    const Lane& lane = warps_[name.first].lanes[name.second];
    std::size_t at = lane.begin;
    for (;; ++at) {
      const EventKind kind = lane.ray->events[at].kind();
      if (kind != EventKind::replay_take && kind != EventKind::replay_forward) continue;
      if (number-- == 0) break;
    }
    if (lane.ray->events[at].kind() != EventKind::replay_take) return;
    // Inside an object the visit of its leaf in the scene TLAS comes first.
    at += lane.ray->events[at].node * unit() >= objects_begin() ? 2 : 1;
    if (at >= lane.end) return;
    const traces::Event& next = lane.ray->events[at];
    std::uint64_t address = std::uint64_t{next.node} * unit();
    traces::NodeKind kind = leaf_unit_ == 2 ? traces::NodeKind::procedural : traces::NodeKind::triangle;
    if (next.kind() == EventKind::visit_internal) {
      address = std::uint64_t{definition(warps_[name.first], next).address} * unit();
      kind = traces::NodeKind::internal;
    } else if (next.kind() == EventKind::visit_instance) {
      kind = traces::NodeKind::instance;
    } else if (next.kind() != EventKind::visit_leaf) {
      return;
    }
    queue_prefetch(kind, address);
  }

  void send(unsigned client, std::uint64_t address, bool write) { requests[client].push_back({address, write, now_}); }

  // --- 5 hand-over -------------------------------------------------------------------------------------------------
  void hand_over() {
    // Entries of 8 and 16 B lie in one sector, those of 20 and 28 B in up to two.
    const unsigned places = config_.checkpoint.write_combine || entry_bytes() < 20 ? 1 : 2;
    for (unsigned taken = 0; taken < config_.checkpoint.lanes && !submitted_.empty(); ++taken) {
      if (write_queue_.size() + places > config_.checkpoint.write_queue) return;
      const LaneName name = submitted_.front();
      Warp& warp = warps_[name.first];
      Lane& lane = warp.lanes[name.second];
      if (lane.to_write > 0) {
        --lane.to_write;
        std::uint64_t first = 0;
        if (logged()) {
          // Items that wait are the last of the log.
          first = place_address(name, log_of(name).items.size() - lane.items.size());
          lane.items.pop_front();
        } else {
          first = entry_address(warp, name.second, warp.round % 2, lane.written++);
        }
        const std::uint64_t last_sector = (first + entry_bytes() - 1) / 32 * 32;
        const std::uint64_t first_sector = first / 32 * 32;
        if (!config_.checkpoint.write_combine) {
          write_queue_.push_back(first_sector);
          if (last_sector != first_sector) write_queue_.push_back(last_sector);
        } else {
          const bool reaches_end = (first + entry_bytes()) / 32 * 32 != first_sector;
          if (reaches_end) write_queue_.push_back(first_sector);
          lane.open_sector.reset();
          if ((first + entry_bytes()) % 32 != 0) lane.open_sector = (first + entry_bytes()) / 32 * 32;
        }
      } else {
        write_queue_.push_back(*lane.open_sector);
        lane.open_sector.reset();
        lane.flush = false;
      }
      if (lane.to_write == 0 && !lane.flush) {
        submitted_.pop_front();
        lane.state = lane.next == lane.end ? State::finished : State::ready;
      }
    }
  }
  std::uint64_t entry_address(const Warp& warp, unsigned lane, unsigned buffer, std::uint64_t index) const {
    return map_.checkpoint_entry(map_.ray_slot(0, warp.slot, lane), buffer, 0) + index * entry_bytes();
  }
  std::uint64_t entry_bytes() const { return config_.checkpoint.entry_bytes; }

  // --- 6 any-hit ---------------------------------------------------------------------------------------------------
  void any_hit() {
    if (!shaded_.empty() && shaded_.front().first <= now_) {
      const Batch batch = shaded_.front().second;
      shaded_.pop_front();
      for (unsigned w = 0; w < warps_.size(); ++w) {
        Warp& warp = warps_[w];
        if (!warp.used || warp.slot != batch.slot) continue;
        warp.shader_busy = false;
        for (unsigned l = 0; l < 32; ++l) {
          if ((batch.lanes >> l & 1) == 0) continue;
          finish_event({w, l}, event(warp.lanes[l]).checkpoints);
        }
      }
    }
    Warp* fires = nullptr;
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
      if (any && (all || late) && (fires == nullptr || warp.age < fires->age)) fires = &warp;
    }
    if (fires == nullptr) return;
    fires->shader_busy = true;
    Batch batch{fires->slot, fires->round, 0, now_};
    for (unsigned l = 0; l < 32; ++l) {
      if (fires->lanes[l].state != State::any_hit_wait) continue;
      fires->lanes[l].state = State::any_hit_run;
      batch.lanes |= std::uint64_t{1} << l;
    }
    batches.push_back(batch);
    batch_messages_.push_back(batch);
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
    if (oldest == nullptr) return;
    dones.push_back({oldest->slot, oldest->round, now_});
    done_messages_.push_back(dones.back());
    for (unsigned l = 0; l < 32; ++l) written_before_[{oldest->slot, l}] = oldest->lanes[l].written;
    *oldest = {};
  }

  // --- 8 schedule --------------------------------------------------------------------------------------------------
  void schedule() {
    std::vector<unsigned> candidates;
    for (unsigned w = 0; w < warps_.size(); ++w) {
      const bool ready = std::any_of(std::begin(warps_[w].lanes), std::end(warps_[w].lanes),
                                     [](const Lane& lane) { return lane.state == State::ready; });
      if (warps_[w].used && ready) candidates.push_back(w);
    }
    if (candidates.empty() || fetch_queue_.size() + 32 > config_.memory.queue) return;
    const unsigned chosen = choose(candidates);
    last_ = chosen;
    last_age_ = warps_[chosen].age;
    for (unsigned l = 0; l < 32; ++l) {
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
        visit(name, NodeKind::instance, at,
              e.detail == 0 && config_.memory.traffic.blas_header_read && !compact() && !compressed());
        return;
      case EventKind::visit_leaf:
        trigger(name, at);
        visit(name, leaf_unit_ == 2 ? NodeKind::procedural : NodeKind::triangle, at, false);
        return;
      case EventKind::cull:
        --lane.depth;
        finish_event(name, e.checkpoints);
        return;
      default:
        read_entry(name);
    }
  }
  /// Where the objects of a three-level trace begin.
  std::uint64_t objects_begin() const {
    return header_.object_roots.empty() ? ~std::uint64_t{0} : header_.object_roots[0] - unit();
  }
  /// Header of the tree that an instance leaf leads to: of an object's TLAS, or of the BLAS.
  std::uint64_t header_below(std::uint64_t leaf) const {
    for (const traces::SceneLeaf& placed : header_.scene_leaves) {
      if (placed.address == leaf) return header_.object_roots[placed.object] - unit();
    }
    return header_.blas_base;
  }
  void visit(LaneName name, traces::NodeKind kind, std::uint64_t address, bool header) {
    warps_[name.first].lanes[name.second].state = State::memory;
    for (auto& [number, fetch] : fetches_) {
      if (fetch.entry != name.first || fetch.address != address || fetch.header != header) continue;
      if (!config_.memory.merge_in_flight && fetch.opened != now_) continue;
      fetch.lanes.push_back(name.second);
      return;
    }
    Fetch fetch{name.first, address, header, kind, {name.second}, {}, 0, 0, now_};
    const bool leaf = kind == traces::NodeKind::triangle || kind == traces::NodeKind::procedural;
    if (leaf && config_.memory.traffic.leaf_descriptor_read) fetch.sectors.push_back(address / 32 * 32);
    for (const std::uint64_t sector : sectors_of(kind, address)) fetch.sectors.push_back(sector);
    if (header) {
      const std::uint64_t below = header_below(address);
      fetch.sectors.insert(fetch.sectors.end(), {below, below + 32});
    }
    fetch_queue_.push_back(next_fetch_);
    fetches_.emplace(next_fetch_++, std::move(fetch));
  }
  void read_entry(LaneName name) {
    Warp& warp = warps_[name.first];
    Lane& lane = warp.lanes[name.second];
    bool backwards = header_.checkpoint_order == traces::CheckpointOrder::lifo;
    std::uint64_t first = 0;
    const bool from_list = lane.run_to_read.empty();
    lane.reading_run = false;
    if (!logged()) {
      const std::uint64_t index = backwards ? lane.source - 1 - lane.reads : lane.reads;
      ++lane.reads;
      first = entry_address(warp, name.second, (warp.round + 1) % 2, index);
    } else if (!lane.run_to_read.empty()) {
      lane.entry_place = lane.run_to_read.front();
      lane.run_to_read.pop_front();
      backwards = lane.run_down;
      first = place_address(name, lane.entry_place);
    } else {
      Log& log = log_of(name);
      lane.entry_place = backwards ? --log.source_end : log.source++;
      const std::vector<std::uint64_t>& names = log.items[lane.entry_place].names;
      first = place_address(name, lane.entry_place);
      lane.run_to_read.assign(names.begin(), names.end());
      if (backwards) std::reverse(lane.run_to_read.begin(), lane.run_to_read.end());
      lane.reading_run = !names.empty();
      if (lane.reading_run) lane.run_down = lane.run_to_read[1] < lane.run_to_read[0];
    }
    std::vector<std::uint64_t> sectors{first / 32 * 32};
    const std::uint64_t last = first + entry_bytes() - 1;
    if (last / 32 * 32 != sectors[0]) sectors.push_back(last / 32 * 32);
    if (backwards) std::reverse(sectors.begin(), sectors.end());
    for (const std::uint64_t sector : sectors) {
      if (config_.checkpoint.read_buffer && lane.held_sector == sector) continue;
      read_queue_.push_back({name, sector});
      ++lane.sectors_due;
    }
    lane.held_sector = sectors.back();
    if (from_list && config_.checkpoint.read_ahead > 0) use_source_sector(lane, sectors.back());
    if (!lane.reading_run) ++lane.entries_read;
    queue_ahead(name);
    if (lane.sectors_due > 0) {
      lane.state = State::read;
    } else if (lane.reading_run) {
      read_entry(name);
    } else {
      entry_read(name);
    }
  }

  // --- sibling prefetcher ------------------------------------------------------------------------------------------
  struct Prefetch {
    std::uint64_t address;
    unsigned sectors, sent = 0;
  };
  std::uint64_t child_address(const Record& record, unsigned slot) const {
    std::uint64_t address = record.child_base;
    for (unsigned s = 0; s < slot; ++s) address += stored(record.node->child_kinds[s]);
    return address;
  }
  void remember(LaneName name, const traces::Event& e) {
    if (!config_.sibling_prefetch) return;
    const Warp& warp = warps_[name.first];
    Lane& lane = warps_[name.first].lanes[name.second];
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
    if (siblings_with_leaf(e.pushed())) keep(lane, record);
    const bool in_blas = header_.two_level && record.node_address >= header_.blas_base;
    if (siblings_with_leaf(e.checkpoints) && !in_blas) {
      written_together_[{warp.slot, name.second}].push_back(record);
      written_together_[{warp.slot, name.second}].back().hit = e.checkpoints;
    }
  }
  void keep(Lane& lane, const Record& record) {
    lane.records.push_back(record);
    if (lane.records.size() > config_.prefetcher.records) lane.records.pop_front();
  }
  /// Slot of the leaf if the record has it among its hit children; 8: it has not.
  unsigned slot_in(const Record& record, std::uint64_t leaf) const {
    for (unsigned s = 0; s < record.node->child_count; ++s) {
      if ((record.hit >> s & 1) != 0 && child_address(record, s) == leaf) return s;
    }
    return 8;
  }
  void trigger(LaneName name, std::uint64_t leaf) {
    Lane& lane = warps_[name.first].lanes[name.second];
    for (auto record = lane.records.rbegin(); record != lane.records.rend(); ++record) {
      if (slot_in(*record, leaf) == 8) continue;
      if (!record->triggered) queue_siblings(*record, leaf);
      record->triggered = true;
      return;
    }
    // The entry that named this leaf says with which siblings it was written.
    if (!config_.prefetcher.replayed || entry_bytes() == 8 || lane.taken != leaf) return;
    const auto& visits = written_together_[{warps_[name.first].slot, name.second}];
    const auto visit =
        std::find_if(visits.rbegin(), visits.rend(), [&](const Record& record) { return slot_in(record, leaf) != 8; });
    if (visit == visits.rend()) return;
    queue_siblings(*visit, leaf);
    keep(lane, *visit);
    lane.records.back().triggered = true;
  }
  void queue_siblings(const Record& record, std::uint64_t leaf) {
    for (unsigned s = 0; s < record.node->child_count; ++s) {
      const std::uint64_t address = child_address(record, s);
      if ((record.hit >> s & 1) == 0 || address == leaf) continue;
      if (queued_now(record.node_address, address)) queue_prefetch(record.node->child_kinds[s], address);
    }
  }
  void queue_prefetch(traces::NodeKind kind, std::uint64_t address) {
    const bool there = std::any_of(prefetch_queue_.begin(), prefetch_queue_.end(),
                                   [&](const Prefetch& p) { return p.address == address; });
    if (there || prefetch_queue_.size() >= config_.prefetcher.queue) return;
    prefetch_queue_.push_back({address, static_cast<unsigned>(sectors_of(kind, address).size())});
  }
  /// Whether no lane has asked for this sibling of this node in this cycle yet; remembers it.
  bool queued_now(std::uint64_t node, std::uint64_t sibling) {
    if (asked_cycle_ != now_) asked_.clear();
    asked_cycle_ = now_;
    return asked_.insert({node, sibling}).second;
  }

  // --- 9 accept ----------------------------------------------------------------------------------------------------
  void accept() {
    if (calls_.empty() || calls_.front().first > now_) return;
    for (unsigned w = 0; w < warps_.size(); ++w) {
      Warp& warp = warps_[w];
      if (warp.used) continue;
      const auto [slot, round] = calls_.front().second;
      calls_.pop_front();
      warp.used = true;
      warp.slot = slot;
      warp.round = round;
      warp.age = next_age_++;
      for (unsigned l = 0; l < groups_[slot]->rays.size(); ++l) {
        const traces::Ray& ray = groups_[slot]->rays[l];
        if (round >= ray.rounds.size()) continue;
        Lane& lane = warp.lanes[l];
        lane.ray = &ray;
        for (unsigned r = 0; r < round; ++r) lane.next += ray.rounds[r].event_count;
        lane.begin = lane.next;
        if (!ray.rounds[round].replay) written_together_[{slot, l}].clear();
        lane.end = lane.next + ray.rounds[round].event_count;
        lane.source = written_before_[{slot, l}];
        if (header_.checkpoint && logged()) {
          Log& log = logs_[{slot, l}];
          if (round == 0) log = {};
          log.source = log.list_begin;
          log.source_end = log.list_begin = log.items.size();
        }
        if (ray.rounds[round].replay && config_.checkpoint.read_ahead > 0) {
          list_source_sectors({w, l});
          queue_ahead({w, l});
        }
        lane.depth = ray.rounds[round].replay ? 0 : 1;
        lane.state = lane.next == lane.end ? State::finished : State::ready;
      }
      return;
    }
  }

  bool idle() const {
    return std::none_of(warps_.begin(), warps_.end(), [](const Warp& w) { return w.used; }) && fetches_.empty() &&
           read_queue_.empty() && write_queue_.empty() && ahead_queue_.empty() && checkpoint_responses_.empty() &&
           prefetch_queue_.empty() && prefetch_responses_.empty() && stack_queue_.empty() && stack_responses_.empty() &&
           done_messages_.empty();
  }

  modules::RtUnitConfig config_;
  traces::Header header_;
  const modules::MemoryMap& map_;
  unsigned memory_latency_, any_hit_cycles_;
  std::uint64_t now_ = 0, order_ = 0, next_age_ = 0;
  std::vector<const traces::RayGroup*> groups_;
  std::vector<Warp> warps_;
  std::vector<Unit> units_;  // box, triangle, sphere, transform
  unsigned leaf_unit_ = 1;
  bool ellipsoid_ = false;

  std::map<std::size_t, Fetch> fetches_;
  std::size_t next_fetch_ = 0;
  std::deque<std::size_t> fetch_queue_;
  std::deque<Response> node_responses_, checkpoint_responses_, prefetch_responses_;
  struct Reader {
    std::optional<LaneName> lane;  // none: a write
    std::uint64_t address;
    bool ahead;
  };
  std::deque<Reader> checkpoint_readers_;
  std::deque<LaneName> ahead_queue_;  // lanes that may have sectors to read ahead
  std::map<std::pair<unsigned, unsigned>, std::vector<Record>> written_together_;  // slot, lane
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
  std::deque<std::pair<std::uint64_t, std::optional<LaneName>>> stack_responses_;
  std::set<std::pair<std::uint64_t, std::uint64_t>> asked_;
  std::uint64_t asked_cycle_ = ~std::uint64_t{0};
  std::map<std::pair<unsigned, unsigned>, std::uint64_t> written_before_;  // slot, lane: entries of the last round
  std::map<std::pair<unsigned, unsigned>, Log> logs_;                      // slot, lane
  std::optional<unsigned> last_;
  std::uint64_t last_age_ = 0;

  struct CallName {
    unsigned slot, round;
  };
  std::deque<CallName> to_call_;
  std::deque<std::pair<std::uint64_t, CallName>> calls_;
  std::size_t pending_calls_ = 0;
  std::deque<Done> done_messages_;
  std::deque<Batch> batch_messages_;
  std::deque<std::pair<std::uint64_t, Batch>> shading_, shaded_;
};

}  // namespace grtx::sim::test
