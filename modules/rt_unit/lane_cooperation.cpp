#include "grtx/modules/rt_unit/lane_cooperation.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"

namespace grtx::modules {

const CounterTable<LaneCooperation::Counters>& LaneCooperation::Counters::table() {
  using C = LaneCooperation::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .when([](const C& c) { return c.taken > 0; })
          .sum(&C::taken, "taken", "nodes", "nodes of busy lanes' stacks that idle lanes fetched and tested")
          .sum(&C::helped, "helped", "nodes", "of these, whose result was there when the busy lane came")
          .sum(&C::waited, "waited", "nodes", "of these, whose result the busy lane had to wait for")
          .sum(&C::wasted, "wasted", "nodes", "of these, whose entry was culled in the end");
  return table;
}

LaneCooperation::LaneCooperation(const sc_core::sc_module_name& name, const Config& config,
                                 const traces::Header& header, const NodeTraffic& traffic, unsigned entries)
    : CooperationModule(name),
      config_(config),
      traffic_(traffic),
      warp_size_(header.warp_size),
      width_(header.bvh_width),
      lanes_(std::size_t{entries} * kMaxLanes),
      jobs_(lanes_.size()) {
  require_allowed("rt.cooperation", config);
}

void LaneCooperation::end_of_elaboration() {
  table_ = &warp_buffer->warps();
  if (stack.size() > 0) stack_ = stack.operator->();
}

void LaneCooperation::begin_lane(LaneId id, const traces::RayGroup& group, std::span<const traces::Event> events) {
  assert(lanes_[id].results.empty());
  lanes_[id].stack.begin(group, events, traffic_);
}

// The event that the lane handles now, or next.
std::uint32_t LaneCooperation::present(LaneId id) const {
  return static_cast<std::uint32_t>(lanes_[id].stack.events() - table_->lane(id).left);
}

std::vector<LaneCooperation::Result>::iterator LaneCooperation::find(Lane& lane, std::uint32_t entry) {
  return std::find_if(lane.results.begin(), lane.results.end(), [&](const Result& r) { return r.entry == entry; });
}

void LaneCooperation::remove(Lane& lane, std::vector<Result>::iterator result) {
  lane.results.erase(result);
  --held_;
}

HelpState LaneCooperation::claim(LaneId id) {
  Lane& lane = lanes_[id];
  const auto result = find(lane, present(id));
  if (result == lane.results.end()) return HelpState::none;
  if (!result->there) {
    ++counters_.waited;
    result->awaited = true;
    return HelpState::under_way;
  }
  ++counters_.helped;
  remove(lane, result);
  return HelpState::tested;
}

void LaneCooperation::drop(LaneId id) {
  Lane& lane = lanes_[id];
  const auto result = find(lane, present(id));
  if (result == lane.results.end()) return;
  ++counters_.wasted;
  remove(lane, result);
}

std::optional<std::uint32_t> LaneCooperation::candidate(const Warp& warp, LaneId id, unsigned level) const {
  const Lane& lane = lanes_[id];
  if (lane.results.size() >= config_.ahead) return std::nullopt;
  const modules::Lane& state = warp.lane[lane_of(id)];
  if (!EventEffect(state.event).takes_top()) return std::nullopt;  // its stack is empty
  const LaneMask at_shader = warp.in_state(LaneState::waiting_any_hit) | warp.in_state(LaneState::in_any_hit);
  // The present event's entry has left the stack only where the shader runs.
  const unsigned above = (at_shader & bit(lane_of(id))) != 0 ? 0 : 1;
  const std::uint32_t in_memory = stack_ != nullptr ? stack_->in_memory(id) : 0;
  if (state.stack_depth < in_memory + above + level + 1) return std::nullopt;
  std::uint32_t entry = lane.stack.below(present(id));
  for (unsigned i = 0; i < level && entry != StackContents::kNone; ++i) entry = lane.stack.below(entry);
  if (entry == StackContents::kNone || lane.stack.marked(entry) || !lane.stack.known(entry)) {
    return std::nullopt;
  }
  return entry;
}

std::optional<Help> LaneCooperation::next(unsigned entry) {
  Warp& warp = table_->warp(entry);
  const LaneMask idle = (bit(warp_size_) - 1) & ~warp.active() & ~warp.helping;
  if (idle == 0) return std::nullopt;
  for (unsigned level = 0; level < config_.ahead; ++level) {
    for (LaneMask busy = warp.active(); busy != 0; busy &= busy - 1) {
      const LaneId id = lane_id(entry, static_cast<unsigned>(std::countr_zero(busy)));
      const auto node = candidate(warp, id, level);
      if (!node) continue;
      const auto lane = static_cast<unsigned>(std::countr_zero(idle));
      const LaneId helper = lane_id(entry, lane);
      StackContents& entries = lanes_[id].stack;
      entries.mark(*node);
      lanes_[id].results.push_back({*node, helper});
      jobs_[helper] = {id, *node};
      ++held_;
      ++helping_;
      ++counters_.taken;
      warp.helping |= bit(lane);
      const NodeVisit visit = entries.node(*node);
      // The trace does not know the children of an internal node that nobody visits: as many as there can be.
      warp.helped_children[lane] =
          static_cast<std::uint8_t>(entries.culled(*node) || visit.kind != traces::NodeKind::internal
                                        ? width_
                                        : entries.group().nodes[entries.event(*node).node].child_count);
      return Help{helper, id, visit};
    }
  }
  return std::nullopt;
}

bool LaneCooperation::helps(LaneId id) const { return (table_->warp(entry_of(id)).helping & bit(lane_of(id))) != 0; }

std::optional<LaneId> LaneCooperation::tested(LaneId helper) {
  const Job job = jobs_[helper];
  --helping_;
  table_->end_help(entry_of(helper), bit(lane_of(helper)));
  Lane& lane = lanes_[job.busy];
  const auto result = find(lane, job.entry);
  if (result == lane.results.end()) return std::nullopt;  // culled meanwhile
  result->there = true;
  if (!result->awaited) return std::nullopt;
  remove(lane, result);
  return job.busy;
}

void LaneCooperation::count(RtUnitCounters& all) const { all.cooperation.add(counters_); }

Inventory LaneCooperation::inventory() const {
  Inventory inventory{name(), {}, {}};
  const std::uint64_t lanes = lanes_.size();
  // The largest result: hit mask, t and order of an internal node's children, or a ray in an instance's space. With it
  // the place of its entry in the stack (8 bits), and whether it is there.
  const unsigned result = std::max(width_ * (1 + 32 + 3), 6u * 32) + 8 + 2;
  inventory.storage.push_back({"results", StorageKind::ram, lanes * config_.ahead * result, 1, 1, false, result});
  // For each lane that helps: whom it helps, and with which of that lane's results.
  const auto index = static_cast<unsigned>(std::bit_width(config_.ahead));
  inventory.storage.push_back({"jobs", StorageKind::flip_flop, lanes * (5 + index + 1)});
  // Which entries are taken, and an idle lane for each of them.
  inventory.storage.push_back({"taken", StorageKind::flip_flop, lanes * config_.ahead});
  inventory.operators.push_back({"arbiter", kMaxLanes, 2});
  inventory.operators.push_back({"match", 8, std::uint64_t{config_.ahead} * kMaxLanes});
  return inventory;
}

void LaneCooperation::dump_state(std::ostream& out) const {
  out << name() << ": " << helping_ << " lanes help, " << held_ << " results held or under way\n";
}

}  // namespace grtx::modules
