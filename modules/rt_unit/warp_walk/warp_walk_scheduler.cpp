// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/warp_walk/warp_walk_scheduler.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"

namespace grtx::modules {

using traces::Event;
using traces::EventKind;
using traces::NodeKind;

void require_walkable(const traces::Header& header) {
  const auto refuse = [](const char* rule) { throw Error("configuration", "rt.traversal", rule); };
  if (header.two_level) refuse("warp is for structures of one level: a lane keeps one ray, in the space of the scene");
  if (header.checkpoint) refuse("warp is for traces without checkpoints: a warp's stack has no replay");
  if (header.tracing != traces::Tracing::multi) refuse("warp is for traces of --tracing multi: hits come in any order");
  if (header.any_hit == traces::AnyHit::delayed) {
    refuse("warp is for hits that are handled at once: the trace has --any-hit delayed");
  }
}

WarpWalkScheduler::WarpWalkScheduler(const sc_core::sc_module_name& name, const Config& config,
                                     const RtSchedulerConfig& scheduler, unsigned entries, const traces::Header& header,
                                     unsigned node_ports)
    : SchedulerBase(name, scheduler, entries, traces::has_box_leaves(header.accel)),
      stacks_(config),
      layout_(warp_stack_entry_layout(header.pop_test)),
      node_ports_(node_ports),
      by_slot_(header.child_order == traces::ChildOrder::slot) {
  require_allowed("rt.warp_stack", config);
  require_walkable(header);
  const traces::NodeSizes sizes = header.node_sizes();
  const NodeKind leaf = traces::has_procedural_leaves(header.accel) ? NodeKind::procedural : NodeKind::triangle;
  record_bits_ = static_cast<unsigned>(8 * std::max(sizes.read_bytes(NodeKind::internal), sizes.read_bytes(leaf)));
  restart();
}

void WarpWalkScheduler::end_of_elaboration() {
  SchedulerBase::end_of_elaboration();
  units_ = node_test.operator->();
  leaf_ = traffic_->leaf_kind();
}

void WarpWalkScheduler::restart() {
  SchedulerBase::restart();
  walks_.clear();
  for (unsigned entry = 0; entry < entries_; ++entry) walks_.emplace_back(WarpStack(stacks_, layout_.in_a_sector));
  for (Entering& unit : entering_) unit = Entering();
  writing_ = 0;
  working_ = false;
}

void WarpWalkScheduler::begin(unsigned entry) {
  const Warp& warp = buffer_->warp(entry);
  Walk& walk = walks_[entry];
  assert(walk.stack.empty() && walk.hits == 0 && !walk.moving);
  WarpStackEntry root;
  root.lanes = warp.in_state(LaneState::ready);
  walk.held = 0;
  stack_->begin_lane(lane_id(entry, 0), warp.slot);
  for_each_bit(warp.lanes, [&](unsigned i) {
    any_hit_->begin_lane(lane_id(entry, i), warp.group->rays[i].rounds[warp.round].preloaded);
  });
  bool first = true;
  for_each_bit(root.lanes, [&](unsigned i) {
    LaneWalk& lane = walk.lanes[i];
    const char* broken = lane.tree.build({warp.lane[i].next, warp.lane[i].left}, *warp.group, *traffic_);
    if (broken != nullptr) refuse(lane_id(entry, i), broken);
    lane.left = lane.tree.size();
    if (!first && root.address != lane.tree.address(0))
      refuse(lane_id(entry, i), "begins at another node than its warp");
    root.address = lane.tree.address(0);
    root.kind = lane.tree.kind(0);
    first = false;
  });
  if (root.lanes != 0) {
    buffer_->move(entry, root.lanes, LaneState::ready, LaneState::in_unit);
    walk.stack.begin(root);
  }
  refresh(entry);
}

void WarpWalkScheduler::refresh(unsigned entry) {
  Walk& walk = walks_[entry];
  walk.next = walk.stack.next(WarpStackConfig::kHits - walk.held, leaf_);
  const LaneMask ready = walk.next != WarpStack::kNone ? 1 : 0;
  const LaneMask by_stack = walk.moving || !walk.done.empty() ? 1 : 0;
  buffer_->tell(entry, wait_of(ready, walk.fetching, 0, by_stack, walk.testing, walk.hits));
}

void WarpWalkScheduler::schedule(Cycle now) {
  const LaneMask candidates = buffer_->ready_entries();
  if (candidates == 0 || !memory_->has_room()) {
    count_idle(1);
    return;
  }
  const unsigned entry = selected_entry(*selection_, config_.policy, candidates, buffer_->ages(), *this);
  Walk& walk = walks_[entry];
  ++counters_.selections;
  start(now, entry, walk.next);
  refill(entry);
  refresh(entry);
}

SelectableWarp WarpWalkScheduler::at(unsigned entry) const {
  const Walk& walk = walks_[entry];
  const WarpStackEntry& node = walk.stack.at(walk.next);
  SelectableWarp seen;
  seen.unfinished = static_cast<unsigned>(std::popcount(buffer_->warp(entry).active()));
  for_each_bit(node.lanes, [&](unsigned lane) {
    const EventKind kind = walk.lanes[lane].tree.event(node.event[lane]).kind();
    const NextStep step = kind == EventKind::cull             ? NextStep::other
                          : kind == EventKind::visit_internal ? NextStep::internal
                                                              : NextStep::leaf;
    ++seen.lanes[static_cast<std::size_t>(step)];
  });
  seen.stack_depth = walk.stack.depth();
  return seen;
}

void WarpWalkScheduler::prepare(Cycle now) {
  for (Entering& unit : entering_) enter(now, unit);
  if (writing_ != 0) write_children();
  working_ = writing_ != 0 || can_enter(entering_[0]) || can_enter(entering_[1]);
}

void WarpWalkScheduler::enter(Cycle now, Entering& unit) {
  while (can_enter(unit)) {
    const unsigned entry = entry_of(unit.nodes.front()), slot = lane_of(unit.nodes.front());
    WarpStack::Node& node = walks_[entry].stack.node(slot);
    if (node.entering == node.entry.lanes) units_->begin_node(node.entry.kind);
    const auto lane = static_cast<unsigned>(std::countr_zero(node.entering));
    node.entering &= ~bit(lane);
    if (node.entering == 0) unit.nodes.pop();
    ++unit.tests;
    units_->test(now, walk_test(entry, slot, lane), node.entry.kind, node.child_count);
  }
}

// The oldest warp's come first.
void WarpWalkScheduler::write_children() {
  for (unsigned written = 0; writing_ != 0 && (stacks_.write_ports == 0 || written < stacks_.write_ports);) {
    const unsigned entry = buffer_->oldest(writing_);
    if (write_child(entry)) ++written;
    note_children(entry);
    refill(entry);
    refresh(entry);
  }
}

bool WarpWalkScheduler::write_child(unsigned entry) {
  Walk& walk = walks_[entry];
  const unsigned slot = walk.done.front();
  const WarpStack::Node& node = walk.stack.node(slot);
  if (node.written == 0 && !walk.stack.has_room(node.children.size())) {
    move(entry, node.children.size(), false);
    return false;
  }
  if (walk.stack.write_child(slot)) walk.done.pop_front();
  counters_.walk.most_waiting = std::max<std::uint64_t>(counters_.walk.most_waiting, walk.stack.depth());
  return true;
}

void WarpWalkScheduler::note_children(unsigned entry) {
  const Walk& walk = walks_[entry];
  if (!walk.moving && !walk.done.empty()) {
    writing_ |= bit(entry);
    working_ = true;
  } else {
    writing_ &= ~bit(entry);
  }
}

LaneMask WarpWalkScheduler::count_events(const WarpStackEntry& node, const Walk& walk) {
  LaneMask visiting = 0;
  for_each_bit(node.lanes, [&](unsigned lane) {
    const EventKind kind = walk.lanes[lane].tree.event(node.event[lane]).kind();
    if (kind == EventKind::cull) {
      ++counters_.culls;
      return;
    }
    ++(kind == EventKind::visit_internal ? counters_.visits_internal : counters_.visits_leaf);
    visiting |= bit(lane);
  });
  return visiting;
}

void WarpWalkScheduler::start(Cycle now, unsigned entry, std::size_t place) {
  Walk& walk = walks_[entry];
  const WarpStackEntry node = walk.stack.at(place);
  const auto lanes = static_cast<unsigned>(std::popcount(node.lanes));
  counters_.lanes_handled += lanes;
  counters_.lanes_active += static_cast<unsigned>(std::popcount(buffer_->warp(entry).active()));
  ++counters_.walk.entries;
  const LaneMask visiting = count_events(node, walk);
  if (visiting == 0) {
    ++counters_.walk.dropped;
    walk.stack.drop(place);
    for_each_bit(node.lanes, [&](unsigned lane) { event_done(entry, lane); });
    return;
  }
  const unsigned slot = walk.stack.start(place);
  const auto visits = static_cast<unsigned>(std::popcount(visiting));
  counters_.walk.in_vain += lanes - visits;
  counters_.walk.under_way += walk.stack.under_way();
  if (is_leaf(node.kind)) walk.held += lanes;
  const NodeVisit visit{node.kind, traffic_->address(node.address), false};
  memory_->begin_warp(now, entry);
  memory_->visit(lane_id(entry, slot), visit.kind, visit.address, visit.header);
  for (unsigned i = 1; i < visits; ++i) memory_->count_visit(visit);
  ++walk.fetching;
}

void WarpWalkScheduler::fetched(Cycle now, unsigned entry, LaneMask slots, NodeKind kind) {
  Walk& walk = walks_[entry];
  for_each_bit(slots, [&](unsigned slot) {
    WarpStack::Node& node = walk.stack.node(slot);
    node.fetched = true;
    --walk.fetching;
    const LaneMask lanes = node.entry.lanes;
    walk.testing += static_cast<unsigned>(std::popcount(lanes));
    if (boxes_ && is_leaf(kind)) {  // no unit tests it
      for_each_bit(lanes, [&](unsigned lane) { units_->test(now, walk_test(entry, slot, lane), kind, 0); });
      return;
    }
    node.child_count = children_in_node(entry, node.entry);
    entering_[is_leaf(kind) ? 1 : 0].nodes.push(lane_id(entry, slot));
    working_ = true;
  });
  refresh(entry);
}

unsigned WarpWalkScheduler::children_in_node(unsigned entry, const WarpStackEntry& node) const {
  if (is_leaf(node.kind)) return 0;
  for (LaneMask rest = node.lanes; rest != 0; rest &= rest - 1) {  // one lane that visits it says it for all
    const auto lane = static_cast<unsigned>(std::countr_zero(rest));
    const Event& event = walks_[entry].lanes[lane].tree.event(node.event[lane]);
    if (event.kind() == EventKind::visit_internal) {
      return buffer_->warp(entry).group->nodes[event.node].child_count;
    }
  }
  return 0;
}

void WarpWalkScheduler::unit_result(Cycle now, LaneId test) {
  const unsigned lane = test % kMaxLanes, slot = test / kMaxLanes % WarpStackConfig::kMostAhead;
  const unsigned entry = test / kMaxLanes / WarpStackConfig::kMostAhead;
  const bool asked = entry < entries_ && slot < stacks_.ahead && walks_[entry].stack.node(slot).fetched &&
                     (walks_[entry].stack.node(slot).testing & bit(lane)) != 0;
  if (!asked) throw WrongAnswer{"has a result for test " + std::to_string(test) + ", which no lane asked for"};
  Walk& walk = walks_[entry];
  WarpStack::Node& node = walk.stack.node(slot);
  node.testing &= ~bit(lane);
  --walk.testing;
  if (!(boxes_ && is_leaf(node.entry.kind))) {
    Entering& unit = entering_[is_leaf(node.entry.kind) ? 1 : 0];
    --unit.tests;
    if (!unit.nodes.empty()) working_ = true;
  }
  const std::uint32_t index = node.entry.event[lane];
  if (EventEffect(walk.lanes[lane].tree.event(index)).calls_shader(boxes_)) {
    found(now, entry, lane, index);
  } else {
    if (is_leaf(node.entry.kind)) --walk.held;
    event_done(entry, lane);
  }
  if (node.testing == 0) node_done(entry, slot);
  refresh(entry);
}

void WarpWalkScheduler::found(Cycle now, unsigned entry, unsigned lane, std::uint32_t event) {
  Walk& walk = walks_[entry];
  counters_.any_hit_calls += EventEffect(walk.lanes[lane].tree.event(event)).calls_any_hit() ? 1 : 0;
  counters_.intersection_calls += boxes_ ? 1 : 0;
  ++walk.hits;
  walk.lanes[lane].hits.push(event);
  if (walk.lanes[lane].hits.size() == 1) offer(now, entry, lane);
}

// A lane has one hit at a time at the any-hit part, which sees it as the lane's event.
void WarpWalkScheduler::offer(Cycle now, unsigned entry, unsigned lane) {
  const LaneWalk& walk = walks_[entry].lanes[lane];
  buffer_->warp(entry).lane[lane].event = walk.tree.event(walk.hits.front());
  any_hit_->arrive(now, lane_id(entry, lane));
}

void WarpWalkScheduler::any_hit_done(Cycle now, const AnyHitDone& done) {
  const unsigned entry = entry_of_answer(done);
  Walk& walk = walks_[entry];
  buffer_->move(entry, done.lanes, LaneState::in_any_hit, LaneState::in_unit);
  for_each_bit(done.lanes, [&](unsigned lane) {
    walk.lanes[lane].hits.pop();
    --walk.hits;
    --walk.held;
    event_done(entry, lane);
  });
  if (buffer_->warp(entry).in_state(LaneState::in_any_hit) == 0) any_hit_->finished(entry);
  for_each_bit(done.lanes, [&](unsigned lane) {
    if (!walk.lanes[lane].hits.empty()) offer(now, entry, lane);
  });
  refresh(entry);
}

void WarpWalkScheduler::event_done(unsigned entry, unsigned lane) {
  if (--walks_[entry].lanes[lane].left == 0) {
    buffer_->move(entry, bit(lane), LaneState::in_unit, LaneState::finished);
  }
}

void WarpWalkScheduler::node_done(unsigned entry, unsigned slot) {
  Walk& walk = walks_[entry];
  WarpStack::Node& node = walk.stack.node(slot);
  children_of(
      node.entry, by_slot_, [&](unsigned lane) -> const LaneTree& { return walk.lanes[lane].tree; }, node.children);
  if (node.children.empty()) {
    walk.stack.finish(slot);
    return refill(entry);
  }
  walk.done.push_back(slot);
  note_children(entry);
}

void WarpWalkScheduler::refill(unsigned entry) {
  Walk& walk = walks_[entry];
  const WarpStack& entries = walk.stack;
  if (!walk.moving && walk.done.empty() && entries.waiting() == 0 && entries.in_memory() != 0 && entries.has_slot())
    move(entry, 0, true);
}

void WarpWalkScheduler::move(unsigned entry, std::size_t more, bool top) {
  Walk& walk = walks_[entry];
  const std::uint32_t depth = walk.stack.depth() + static_cast<std::uint32_t>(more);
  walk.filling = walk.stack.settle(more, top).fill;
  walk.moving = stack_->settle(lane_id(entry, 0), depth, top);
  assert(walk.moving);
}

void WarpWalkScheduler::stack_settled(LaneId id) {
  const unsigned entry = entry_of(id);
  Walk& walk = walks_[entry];
  if (walk.filling) walk.stack.filled();
  walk.moving = walk.filling = false;
  note_children(entry);
  refill(entry);
  refresh(entry);
}

// Entries that wait in the RT unit, nodes under way and hits, of all its warps.
std::vector<UnitProbe> WarpWalkScheduler::probes() const {
  const auto of_all = [this](auto number) {
    return [this, number] {
      std::uint64_t sum = 0;
      for_each_bit(buffer_->occupied(), [&](unsigned entry) { sum += number(walks_[entry]); });
      return sum;
    };
  };
  return {{"waiting", kLevelBits, of_all([](const Walk& walk) { return walk.stack.waiting(); })},
          {"under_way", kLevelBits, of_all([](const Walk& walk) { return walk.stack.under_way(); })},
          {"hits", kLevelBits, of_all([](const Walk& walk) { return walk.hits; })}};
}

Inventory WarpWalkScheduler::inventory() const {
  Inventory inventory{name(), {}, {}};
  const std::uint64_t n = entries_, slots = stacks_.slots(entries_);
  const unsigned place = static_cast<unsigned>(std::bit_width(stacks_.entries - 1));
  const auto slot_bits = static_cast<unsigned>(std::bit_width(stacks_.ahead));
  auto& storage = inventory.storage;
  // Entries have one port to read and as many to write as are configured: banks. They are linked in order, so that
  // children come where their parent was; links both ways and which places are free change beside each other.
  const unsigned banks = std::max(1U, stacks_.write_ports);
  storage.push_back({"stack", StorageKind::ram, n * stacks_.entries * layout_.bits, 1, 1, false, layout_.bits, banks});
  storage.push_back({"links", StorageKind::flip_flop, n * stacks_.entries * (2 * place + 1)});
  // Of each place in the window: the entry's number, node slot, whether a leaf, number of lanes. Places move up and
  // down.
  const std::uint64_t window = stacks_.window != 0 ? stacks_.window : stacks_.entries;
  const unsigned window_bits = place + slot_bits + 1 + 6;
  storage.push_back({"window", StorageKind::flip_flop, n * window * window_bits});
  inventory.operators.push_back({"mux", window_bits, 2 * n * window});
  inventory.operators.push_back({"int_compare", 8, n * window});       // room for the hits of a leaf's lanes
  const unsigned node_ports = node_ports_ != 0 ? 2 * node_ports_ : 1;  // units that read: boxes, leaves
  storage.push_back({"nodes", StorageKind::ram, slots * record_bits_, node_ports, 1, false, record_bits_});
  // Of a slot: address, place in the stack, state; lanes, those to be tested, those being tested, those of each of
  // eight children.
  storage.push_back({"slots", StorageKind::flip_flop, slots * (48 + place + 2 + kMaxLanes * (3 + traces::kMaxWidth))});
  // Orders of node slots: of a warp, whose children are to be written; of all, whose lanes are to be tested.
  storage.push_back({"done", StorageKind::flip_flop, slots * slot_bits});
  const auto node_name = static_cast<unsigned>(std::bit_width(slots - 1));
  storage.push_back({"arrived", StorageKind::ram, 2 * slots * node_name, 1, 1, false, node_name, 2});
  // Hits are linked, a list for each lane: t, alpha, id and the next one; the first and the last of each list.
  constexpr unsigned kHitBits = 32 * HitHeap::kEntryWords + 7;
  storage.push_back({"hits", StorageKind::ram, n * WarpStackConfig::kHits * kHitBits, 1, 1, false, kHitBits});
  storage.push_back({"hit_lists", StorageKind::flip_flop, n * kMaxLanes * 2 * 7});
  storage.push_back({"age_matrix", StorageKind::flip_flop, n * n});
  inventory.operators.push_back({"arbiter", static_cast<unsigned>(n), n});
  inventory.operators.push_back({"arbiter", stacks_.ahead, n});
  // t of an entry against t_max of each of its lanes; the least t of a child among the lanes as their results come.
  inventory.operators.push_back({"fp_compare", 32, kMaxLanes + traces::kMaxWidth});
  return inventory;
}

void WarpWalkScheduler::dump_state(std::ostream& out) const {
  out << name() << ": " << counters_.selections << " entries started\n";
  for_each_bit(buffer_->occupied(), [&](unsigned entry) {
    const Walk& walk = walks_[entry];
    out << "  entry " << entry << ": " << walk.stack.waiting() << " entries wait, " << walk.stack.in_memory()
        << " in memory, " << walk.stack.under_way() << " under way, " << walk.fetching << " nodes fetched, "
        << walk.testing << " tests, " << walk.hits << " hits" << (walk.moving ? ", stack moving\n" : "\n");
  });
}

PartInfo part_info(const WarpStackConfig&, bool used, unsigned ray_banks) {
  PartInfo part;
  part.name = "warp_walk_scheduler";
  if (!used) return part;
  part.energy = {{.name = "rt.warp_stack",
                  .statistics = {"gpu.rt.walk.entries"},
                  .terms = {reads(part.name, "stack"), writes(part.name, "stack"), writes(part.name, "nodes")},
                  .basis = "entries of warps: each in and out, and its node in",
                  .off_by_default = true},
                 {.name = "rt.warp_nodes",
                  .statistics = {"gpu.rt.lanes_handled"},
                  .factor = 1.0 / std::max(1U, ray_banks),
                  .terms = {reads(part.name, "nodes")},
                  .basis = "nodes read for tests that start together",
                  .off_by_default = true},
                 {.name = "rt.warp_hits",
                  .statistics = {"gpu.rt.any_hit_calls"},
                  .terms = {reads(part.name, "hits"), writes(part.name, "hits")},
                  .basis = "hits of lanes, in and out of their queues"}};
  return part;
}

}  // namespace grtx::modules
