// SPDX-License-Identifier: Apache-2.0
// Plain walk of a warp: the stack of entries and the trees of its lanes, as lists and maps. Written from
// docs/model/warp_walk.md. The plain RT unit moves its entries.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <iterator>
#include <list>
#include <map>
#include <optional>
#include <vector>

#include "grtx/traces/event.h"

namespace grtx::sim::plain {

struct WarpWalk {
  struct Entry {
    std::uint64_t address = 0;  // in units
    traces::NodeKind kind = traces::NodeKind::internal;
    std::map<unsigned, std::size_t> events;  // of each of its lanes
    std::optional<unsigned> slot;            // under way there
    bool fetched = false;
    std::vector<unsigned> testing;  // lanes without a result
    std::deque<unsigned> to_test;   // lanes whose test is not queued yet
    std::vector<Entry> children;    // to be written, the topmost first
    bool writing = false;           // some of them are there
    std::uint64_t number = 0;       // of how many nodes that came to units
  };
  std::list<Entry> stack;     // the topmost first
  std::deque<Entry> memory;   // the topmost first
  std::deque<Entry> filling;  // on their way back
  std::deque<unsigned> done;  // slots of nodes whose children are not all there yet
  std::map<unsigned, std::map<std::size_t, std::vector<std::size_t>>> children;  // lane, event: events of its children
  std::map<unsigned, std::size_t> left;                                          // lane: events that are not done
  std::map<unsigned, std::deque<std::size_t>> hits;                              // lane: the first is being answered
  bool moving = false;

  /// Reads the lane's events from `at` on, depth first; returns the first behind the node's subtree.
  std::size_t read(unsigned lane, const traces::Ray& ray, std::size_t at) {
    const traces::Event& event = ray.events.at(at);
    std::size_t next = at + 1;
    if (event.kind() == traces::EventKind::visit_internal) {
      for (unsigned mask = event.pushed(); mask != 0; mask &= mask - 1) {
        children[lane][at].push_back(next);
        next = read(lane, ray, next);
      }
    }
    return next;
  }
  std::size_t waiting() const {
    return static_cast<std::size_t>(
        std::count_if(stack.begin(), stack.end(), [](const Entry& e) { return !e.slot.has_value(); }));
  }
  std::size_t under_way() const { return stack.size() - waiting(); }
  std::size_t hits_held() const {
    std::size_t all = 0;
    for (const auto& [lane, of_lane] : hits) all += of_lane.size();
    return all;
  }
  /// Places for hits that are taken: by hits, and by leaf tests that may find one.
  std::size_t held() const {
    std::size_t all = hits_held();
    for (const Entry& entry : stack) {
      if (entry.kind != traces::NodeKind::internal) all += entry.testing.size();
    }
    return all;
  }
  /// In the topmost places of the window (0: all) the topmost that waits and may start.
  const Entry* next(unsigned ahead, unsigned window) const {
    if (under_way() >= ahead) return nullptr;
    unsigned looked_at = 0;
    for (auto entry = stack.begin(); entry != stack.end() && (window == 0 || looked_at < window); ++entry) {
      ++looked_at;
      if (entry->slot) continue;
      const bool leaf = entry->kind != traces::NodeKind::internal;
      const bool blocked = leaf && held() + entry->events.size() > 128;
      if (!blocked) return &*entry;
    }
    return nullptr;
  }
  std::list<Entry>::iterator place_of(const Entry* entry) {
    return std::find_if(stack.begin(), stack.end(), [entry](const Entry& e) { return &e == entry; });
  }
  std::list<Entry>::iterator in_slot(unsigned slot) {
    return std::find_if(stack.begin(), stack.end(), [slot](const Entry& e) { return e.slot == slot; });
  }
  unsigned free_slot() {
    unsigned slot = 0;
    while (in_slot(slot) != stack.end()) ++slot;
    return slot;
  }
  /// The two lowest that wait leave for memory.
  void spill_sector() {
    for (int i = 0; i < 2; ++i) {
      const auto lowest = std::find_if(stack.rbegin(), stack.rend(), [](const Entry& e) { return !e.slot; });
      memory.push_front(*lowest);
      stack.erase(std::next(lowest).base());
    }
  }
  void fill_sector() {
    for (int i = 0; i < 2; ++i) {
      filling.push_back(memory.front());
      memory.pop_front();
    }
  }
  void filled() {
    stack.insert(stack.end(), filling.begin(), filling.end());
    filling.clear();
  }
};

}  // namespace grtx::sim::plain
