// SPDX-License-Identifier: Apache-2.0
// Records a round whose nodes are handled in another order than depth first (TracerOptions::ahead), and gives its
// events to a recorder in that order, as traces have them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/traces/event.h"
#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

/// A pushed child: the event that pushed it, and which of its pushed children it is, 0 the first to be pushed.
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
    events_.back().what.detail = pushed;
    events_.back().what.checkpoints = checkpoints;
  }
  void event(traces::EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints,
             unsigned shifts = 0) {
    add({kind, address, detail, checkpoints, shifts});
  }

  /// Gives the round's events to `recorder`, depth first.
  template <typename Recorder>
  void replay(Recorder& recorder) {
    to_do_.assign(1, 0);
    while (!to_do_.empty()) {
      const Recorded& e = events_[to_do_.back()];
      to_do_.pop_back();
      recorder.pop();
      if (e.what.kind != traces::EventKind::visit_internal) {
        recorder.event(e.what.kind, e.what.address, e.what.detail, e.what.checkpoints, e.what.shifts);
        continue;
      }
      typename Recorder::Children children = recorder.open(e.what.address);
      for (unsigned i = 0; i < e.puts; ++i) children.put(e.put[i].slot, e.put[i].pushed);
      recorder.internal(children, e.what.address, e.what.detail, e.what.checkpoints);
      for (unsigned i = 0; i < e.pushed; ++i) to_do_.push_back(e.child[i]);
    }
  }

 private:
  struct What {
    traces::EventKind kind;
    std::uint32_t address;
    unsigned detail, checkpoints, shifts;
  };
  struct Put {
    std::uint8_t slot = 0, pushed = 0;
  };
  struct Recorded {
    What what;
    unsigned puts = 0, pushed = 0;
    std::array<Put, traces::kMaxWidth + 1> put{};          ///< a child that is followed at once is put twice
    std::array<std::uint32_t, traces::kMaxWidth> child{};  ///< events of the pushed children
  };
  void add(const What& what) {
    if (place_.parent != PushedPlace::kRoot) {
      events_[place_.parent].child[place_.child] = static_cast<std::uint32_t>(events_.size());
    }
    events_.push_back({what, 0, 0, {}, {}});
  }
  void put(unsigned slot, unsigned pushed) {
    Recorded& e = events_.back();
    e.put[e.puts++] = {static_cast<std::uint8_t>(slot), static_cast<std::uint8_t>(pushed)};
    e.pushed += pushed;
  }

  std::vector<Recorded> events_;
  std::vector<std::uint32_t> to_do_;
  PushedPlace place_;
};

}  // namespace grtx::frontend
