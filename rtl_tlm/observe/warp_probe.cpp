// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/warp_probe.h"

#include <algorithm>
#include <bit>

#include "grtx/rtl_tlm/observe/wave_enumerations.h"

namespace grtx::sim {

using modules::for_each_bit;
using modules::LaneState;
using traces::Event;
using traces::EventKind;

namespace {

constexpr unsigned kAddressBits = 48;
constexpr unsigned kCountBits = 32;

/// Kind and address of the node that a lane's event fetches or tests.
struct Node {
  NodeSignal kind = NodeSignal::none;
  std::uint64_t address = 0;
};

Node node_of(const traces::RayGroup& group, const Event& event, const modules::NodeTraffic& traffic) {
  switch (event.kind()) {
    case EventKind::visit_internal:
      return {NodeSignal::internal, traffic.address(group.nodes[event.node].address)};
    case EventKind::visit_instance:
      return {NodeSignal::instance, traffic.address(event.node)};
    case EventKind::visit_leaf:
      return {traffic.leaf_kind() == traces::NodeKind::triangle ? NodeSignal::triangle : NodeSignal::procedural,
              traffic.address(event.node)};
    default:
      return {};
  }
}

}  // namespace

WarpProbe::WarpProbe(Wires& wires, const std::string& scope, const modules::WarpTable& buffer, unsigned entry,
                     const modules::CheckpointState* checkpoint, const traces::Header& header)
    : buffer_(buffer), checkpoint_(checkpoint), entry_(entry), k_(header.k), traffic_(header, {}) {
  const std::size_t before = wires.selected();
  const std::string name = scope + ".w" + std::to_string(entry) + ".";
  const auto add = [&](const char* leaf, unsigned width, const Enumeration* enumeration = nullptr) {
    return wires.add(name + leaf, width, WaveLevel::signals, enumeration);
  };
  state_ = add("state", 3, &warp_states());
  slot_ = add("slot", 6);
  group_ = add("group", kCountBits);
  round_ = add("round", kCountBits);
  active_ = add("active", modules::kMaxLanes);
  for (std::size_t s = 0; s < modules::kLaneStates; ++s) {
    const bool checkpointing = static_cast<LaneState>(s) == LaneState::waiting_checkpoint_read ||
                               static_cast<LaneState>(s) == LaneState::waiting_checkpoint_write;
    if (static_cast<LaneState>(s) == LaneState::idle || (checkpointing && checkpoint == nullptr)) continue;
    lanes_[s] = add(("lanes_" + std::string(name_at<modules::LaneState>(s))).c_str(), modules::kMaxLanes);
  }
  node_kind_ = add("node_kind", 3, &node_kinds());
  node_address_ = add("node_address", kAddressBits);
  node_lanes_ = add("node_lanes", modules::kMaxLanes);
  t_min_rank_ = add("t_min_rank", kCountBits);
  t_max_lowered_ = add("t_max_lowered", modules::kMaxLanes);
  k_fill_ = add("k_buffer_fill", 16);
  if (checkpoint != nullptr) {
    replay_ = add("replay", modules::kMaxLanes);
    source_offset_ = add("source_offset", kCountBits);
    destination_offset_ = add("destination_offset", kCountBits);
  }
  selected_ = wires.selected() != before;
}

void WarpProbe::sample() {
  if (!selected_) return;
  if ((buffer_.occupied() >> entry_ & 1) == 0) {
    if (occupied_) clear();
    return;
  }
  const modules::Warp& warp = buffer_.warp(entry_);
  LaneMask changed = 0;  // lanes that may have done an event
  if (warp.walks) return show_walk(warp);
  if (!occupied_ || warp.age != age_) {
    begin();
    changed = warp.lanes;
  } else {
    for (std::size_t s = 0; s < modules::kLaneStates; ++s) changed |= in_[s] ^ warp.in[s];
    // Lanes in other states may execute an event and return to the same state within a cycle.
    changed |= warp.active() & ~(warp.in_state(LaneState::waiting_memory) | warp.in_state(LaneState::in_unit) |
                                 warp.in_state(LaneState::waiting_any_hit) | warp.in_state(LaneState::in_any_hit));
    if (changed == 0) return;
  }
  in_ = warp.in;
  for_each_bit(changed, [&](unsigned lane) { follow_lane(lane); });
  state_.set(1 + static_cast<std::uint64_t>(warp.wait()));
  active_.set(warp.active());
  for (std::size_t s = 0; s < modules::kLaneStates; ++s) lanes_[s].set(warp.in[s]);
  t_max_lowered_.set(lowered_);
  std::uint16_t fill = 0;
  for_each_bit(warp.lanes, [&](unsigned lane) { fill = std::max(fill, fill_[lane]); });
  k_fill_.set(fill);
  show_node();
  if (checkpoint_ != nullptr) show_offsets();
}

// Lanes of a warp that walks together are at several nodes: its signals of one node and of t_max stay as they are.
void WarpProbe::show_walk(const modules::Warp& warp) {
  if (!occupied_ || warp.age != age_) begin();
  state_.set(1 + static_cast<std::uint64_t>(warp.wait()));
  active_.set(warp.active());
  for (std::size_t s = 0; s < modules::kLaneStates; ++s) lanes_[s].set(warp.in[s]);
}

// Begins to follow a call. If it was under way when the window began, its events so far are gone through.
void WarpProbe::begin() {
  const modules::Warp& warp = buffer_.warp(entry_);
  occupied_ = true;
  age_ = warp.age;
  lowered_ = 0;
  LaneMask replay = 0;
  std::uint64_t rank = 0;
  for_each_bit(warp.lanes, [&](unsigned i) {
    const traces::Ray& ray = warp.group->rays[i];
    std::size_t first = 0;
    std::uint64_t processed = 0;
    for (std::uint32_t r = 0; r < warp.round; ++r) {
      first += ray.rounds[r].event_count;
      processed += ray.rounds[r].processed_count;
    }
    next_[i] = ray.events.data() + first;
    fill_[i] = ray.rounds[warp.round].preloaded;
    if (ray.rounds[warp.round].replay) replay |= modules::bit(i);
    rank = std::max(rank, processed);
  });
  slot_.set(warp.slot);
  group_.set(warp.group->index);
  round_.set(warp.round);
  replay_.set(replay);
  t_min_rank_.set(rank);
}

void WarpProbe::follow_lane(unsigned lane) {
  const Event* now = buffer_.warp(entry_).lane[lane].next;
  for (const Event*& event = next_[lane]; event != now; ++event) {
    if (event->kind() != EventKind::visit_leaf) continue;
    switch (event->outcome()) {
      case traces::LeafOutcome::inserted:
        if (fill_[lane] < k_) ++fill_[lane];
        break;
      case traces::LeafOutcome::nearest:
        fill_[lane] = 1;
        [[fallthrough]];
      case traces::LeafOutcome::rejected:
        lowered_ |= modules::bit(lane);
        break;
      default:
        break;
    }
  }
}

// The node of the first lane that waits for one, else of the first lane that tests one.
void WarpProbe::show_node() {
  const modules::Warp& warp = buffer_.warp(entry_);
  LaneMask lanes = warp.in_state(LaneState::waiting_memory);
  if (lanes == 0) lanes = warp.in_state(LaneState::in_unit);
  Node node;
  LaneMask same = 0;
  if (lanes != 0) {
    node = node_of(*warp.group, warp.lane[static_cast<unsigned>(std::countr_zero(lanes))].event, traffic_);
    for_each_bit(lanes, [&](unsigned i) {
      const Node other = node_of(*warp.group, warp.lane[i].event, traffic_);
      if (other.address == node.address && other.kind == node.kind) same |= modules::bit(i);
    });
  }
  node_kind_.set(static_cast<std::uint64_t>(node.kind));
  node_address_.set(node.address);
  node_lanes_.set(same);
}

void WarpProbe::show_offsets() {
  std::uint32_t source = 0;
  std::uint32_t destination = 0;
  for_each_bit(buffer_.warp(entry_).lanes, [&](unsigned i) {
    const modules::LaneId id = modules::lane_id(entry_, i);
    source = std::max(source, checkpoint_->source_offset(id));
    destination = std::max(destination, checkpoint_->destination_offset(id));
  });
  source_offset_.set(source);
  destination_offset_.set(destination);
}

void WarpProbe::clear() {
  occupied_ = false;
  for (Wire* wire : {&state_, &slot_, &group_, &round_, &active_, &replay_, &node_kind_, &node_address_, &node_lanes_,
                     &t_min_rank_, &t_max_lowered_, &k_fill_, &source_offset_, &destination_offset_}) {
    wire->set(0);
  }
  for (Wire& wire : lanes_) wire.set(0);
}

}  // namespace grtx::sim
