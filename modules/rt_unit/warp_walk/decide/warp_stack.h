// SPDX-License-Identifier: Apache-2.0
// The common traversal stack of a warp: entries of a node and the lanes that visit it. Untimed: the warp walk scheduler
// sends requests and moves lanes. docs/model/warp_walk.md states the rules.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/stack/decide/stack_spill.h"
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack_config.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

// Rules that a trace must keep to be walked by warps; texts of the errors.
inline constexpr const char* kRuleChildPushed = "visits a node that its parent did not push";
inline constexpr const char* kRuleNothingLeft = "leaves nodes on its stack";
inline constexpr const char* kRuleWalkedKinds = "has an event that a warp cannot walk: an instance or a replay";

/// The tree of a lane's events of one round, which the trace lists depth first. With the tree the lane can visit nodes
/// in any order in which a node follows its parent.
class LaneTree {
 public:
  /// Returns the rule that the events break, or null. The group must outlive the tree.
  const char* build(std::span<const traces::Event> events, const traces::RayGroup& group, const NodeTraffic& traffic);

  std::uint32_t size() const { return static_cast<std::uint32_t>(events_.size()); }
  const traces::Event& event(std::uint32_t index) const { return events_[index]; }
  std::uint32_t address(std::uint32_t index) const;  ///< address of the event's node, in units
  traces::NodeKind kind(std::uint32_t index) const { return kind_[index]; }
  /// Calls f(event) for each event of a child, in the order in which the lane alone would visit them.
  template <typename F>
  void for_each_child(std::uint32_t parent, F&& f) const {
    for (std::uint32_t child = parent + 1; child < end_[parent]; child = end_[child]) f(child);
  }

 private:
  struct Open {
    std::uint32_t event = 0;
    unsigned waiting = 0;  ///< pushed children that no event has visited yet
  };
  std::span<const traces::Event> events_;
  const traces::RayGroup* group_ = nullptr;
  std::vector<std::uint32_t> end_;      ///< [event] the first event behind its subtree
  std::vector<traces::NodeKind> kind_;  ///< [event] of its node
  std::vector<Open> open_;
};

struct WarpStackEntry {
  std::uint32_t address = 0;  ///< in units
  traces::NodeKind kind = traces::NodeKind::internal;
  LaneMask lanes = 0;
  std::array<std::uint32_t, kMaxLanes> event{};  ///< [lane] its event at this node
};

/// Entries wait, or are under way in a node slot. Entries under way keep their place, into which their children come.
/// Only waiting entries take room in the RT unit's part of the stack.
class WarpStack {
 public:
  /// An entry that is under way.
  struct Node {
    WarpStackEntry entry;
    LaneMask testing = 0;  ///< lanes whose test is not done
    bool used = false;
    bool fetched = false;
    unsigned child_count = 0;              ///< boxes of a node that has been fetched
    LaneMask entering = 0;                 ///< lanes whose test is not in the queue of its unit yet
    std::vector<WarpStackEntry> children;  ///< the topmost first
    std::size_t written = 0;               ///< children that are on the stack
  };

  explicit WarpStack(const WarpStackConfig& config, unsigned in_a_sector)
      : entries_(config.entries),
        ahead_(config.ahead),
        window_(config.window),
        spill_(config.entries, in_a_sector),
        nodes_(config.ahead) {}

  /// The stack, which must be empty, holds the root.
  void begin(const WarpStackEntry& root);
  bool empty() const { return order_.empty() && below_.empty(); }
  unsigned waiting() const { return waiting_; }                                                 ///< in the RT unit
  std::size_t in_memory() const { return below_.size(); }                                       ///< entries spilled
  std::uint32_t depth() const { return waiting_ + static_cast<std::uint32_t>(below_.size()); }  ///< all that wait
  bool has_slot() const { return under_way_ < ahead_; }
  unsigned under_way() const { return under_way_; }
  Node& node(unsigned slot) { return nodes_[slot]; }
  const Node& node(unsigned slot) const { return nodes_[slot]; }
  unsigned slots() const { return ahead_; }

  /// Place of the entry to start next: in the topmost `window` places the topmost that waits and may start; kNone if
  /// there is none, or no slot. room: hits that the warp has room for; a leaf with more lanes must wait.
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t next(unsigned room, traces::NodeKind leaf) const;
  const WarpStackEntry& at(std::size_t place) const { return order_[place].entry; }
  /// Starts the entry at `place`; returns its slot.
  unsigned start(std::size_t place);
  /// Takes the entry at `place` off the stack.
  void drop(std::size_t place);
  /// The entry in `slot` is done and has no children.
  void finish(unsigned slot);
  /// Writes the next of the children of the entry in `slot`; the last one takes its place. Returns whether it was.
  bool write_child(unsigned slot);
  bool has_room(std::size_t children) const { return waiting_ + children <= entries_; }
  /// The move needed before `more` entries come (StackSpill); spilled entries leave at once. top: an entry is to start.
  StackSpill::Move settle(std::size_t more, bool top);
  /// The entries of the fill that settle() returned have arrived.
  void filled();

 private:
  struct Item {
    WarpStackEntry entry;
    int slot = -1;  ///< -1: waits
  };
  std::size_t place_of(unsigned slot) const;

  unsigned entries_, ahead_, window_;
  StackSpill spill_;
  StackSpill::Lane spilled_;
  std::vector<Node> nodes_;             ///< [slot]
  std::vector<Item> order_;             ///< the topmost last
  std::vector<WarpStackEntry> below_;   ///< in memory, the topmost last
  std::vector<WarpStackEntry> coming_;  ///< being filled
  unsigned waiting_ = 0, under_way_ = 0;
};

/// Children of a finished entry as entries, the topmost first. by_slot: lanes visit children in the order of their
/// slots, and so does the warp. Else first the children of the lowest lane in its order, then those that only other
/// lanes push, lane by lane. tree(lane): the lane's tree.
template <typename Trees>
void children_of(const WarpStackEntry& parent, bool by_slot, Trees&& tree, std::vector<WarpStackEntry>& children) {
  children.clear();
  for_each_bit(parent.lanes, [&](unsigned lane) {
    const LaneTree& of_lane = tree(lane);
    of_lane.for_each_child(parent.event[lane], [&](std::uint32_t event) {
      const std::uint32_t address = of_lane.address(event);
      const auto same = [&](const WarpStackEntry& child) { return child.address == address; };
      auto child = std::find_if(children.begin(), children.end(), same);
      if (child == children.end()) child = children.insert(child, {address, of_lane.kind(event), 0, {}});
      child->lanes |= bit(lane);
      child->event[lane] = event;
    });
  });
  if (!by_slot) return;
  std::sort(children.begin(), children.end(),
            [](const WarpStackEntry& a, const WarpStackEntry& b) { return a.address < b.address; });
}

}  // namespace grtx::modules
