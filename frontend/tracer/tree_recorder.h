// SPDX-License-Identifier: Apache-2.0
// Records a round whose nodes were handled in another order than depth first (TracerOptions::ahead), and then gives its
// events to the trace's recorder depth first, the order that traces have.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/traces/event.h"
#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

/// A pushed child: the event that pushed it, and its number among the children that this event pushed, from 0 in the
/// order of pushing.
struct PushedPlace {
  static constexpr std::uint32_t kRoot = ~std::uint32_t{0};
  std::uint32_t parent = kRoot;
  std::uint32_t child = 0;
};

class TreeRecorder {
 public:
  static constexpr bool kEnabled = true;
  static constexpr bool kDepthFirst = false;

  /// The children that the event pushes, from the last to be popped to the first.
  struct Children {
    TreeRecorder* recorder = nullptr;
    void put(unsigned slot, unsigned pushed) { recorder->put(slot, pushed); }
  };

  void begin() { events_.clear(); }
  /// The next event is that of the node at this place.
  void at(PushedPlace place) { place_ = place; }
  /// The event recorded last.
  std::uint32_t last() const { return static_cast<std::uint32_t>(events_.size()) - 1; }

  void pop() {}
  Children open(std::uint32_t address) {
    add({traces::EventKind::visit_internal, address, 0, 0, 0});
    return {this};
  }
  void internal(const Children&, std::uint32_t, unsigned pushed, unsigned checkpoints) {
    events_.back().fields.detail = pushed;
    events_.back().fields.checkpoints = checkpoints;
  }
  void event(traces::EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints,
             unsigned shifts = 0) {
    add({kind, address, detail, checkpoints, shifts});
  }

  /// Gives the round's events to `recorder`, depth first.
  template <typename Recorder>
  void replay(Recorder& recorder) {
    unvisited_.assign(1, 0);
    while (!unvisited_.empty()) {
      const Recorded& e = events_[unvisited_.back()];
      unvisited_.pop_back();
      recorder.pop();
      if (e.fields.kind != traces::EventKind::visit_internal) {
        recorder.event(e.fields.kind, e.fields.address, e.fields.detail, e.fields.checkpoints, e.fields.shifts);
        continue;
      }
      typename Recorder::Children children = recorder.open(e.fields.address);
      for (unsigned i = 0; i < e.puts; ++i) children.put(e.put[i].slot, e.put[i].pushed);
      recorder.internal(children, e.fields.address, e.fields.detail, e.fields.checkpoints);
      for (unsigned i = 0; i < e.pushed; ++i) unvisited_.push_back(e.child[i]);
    }
  }

 private:
  struct Fields {
    traces::EventKind kind;
    std::uint32_t address;
    unsigned detail, checkpoints, shifts;
  };
  struct Put {
    std::uint8_t slot = 0, pushed = 0;
  };
  struct Recorded {
    Fields fields;
    unsigned puts = 0, pushed = 0;
    std::array<Put, traces::kMaxWidth + 1> put{};          ///< a child that is followed at once is put twice
    std::array<std::uint32_t, traces::kMaxWidth> child{};  ///< events of the pushed children
  };
  void add(const Fields& fields) {
    if (place_.parent != PushedPlace::kRoot) {
      events_[place_.parent].child[place_.child] = static_cast<std::uint32_t>(events_.size());
    }
    events_.push_back({fields, 0, 0, {}, {}});
  }
  void put(unsigned slot, unsigned pushed) {
    Recorded& e = events_.back();
    e.put[e.puts++] = {static_cast<std::uint8_t>(slot), static_cast<std::uint8_t>(pushed)};
    e.pushed += pushed;
  }

  std::vector<Recorded> events_;          ///< in the order in which they were handled
  std::vector<std::uint32_t> unvisited_;  ///< stack of replay(): events that are still to be given
  PushedPlace place_;                     ///< of the next event
};

}  // namespace grtx::frontend
