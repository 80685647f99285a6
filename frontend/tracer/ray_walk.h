// The walk of one ray through a tree in which leaves are reached from the root alone (no instances), round after round.
//
// The order in which a ray meets nodes does not depend on t_max: depth first, near first. So what it knows of the tree
// is a list in that order, and a round goes through the list and visits what its interval [t_min, t_max] meets. Nodes
// that the ray has tested before cost one comparison, of many at once; where the list says that a node has not been
// opened yet, its children are tested and put in behind it. docs/model/tracer-speed.md.
//
// A child's stored box may stick out of its parent's: codes are rounded outwards in grids of their own. Such children
// are guarded: to be visited they need a visited parent besides an interval of their own.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "grtx/frontend/tracer/walk_kernels.h"

namespace grtx::frontend {

/// A node whose entry t is less than that of a node above it.
struct WalkGuard {
  float bound = 0.0f;        ///< the largest entry t of the nodes above it
  std::uint32_t parent = 0;  ///< number of the node above
  std::uint32_t number = 0;  ///< its own, once opened
  float state = WalkList::kOpen;
  std::uint32_t what = 0;
};

/// One ray at a time. begin_ray(), then for each round begin_round(), and step() until it says `end`.
class RayWalk {
 public:
  enum class Stop : std::uint8_t {
    node,  ///< an internal node is visited for the first time: open() it
    leaf,  ///< a leaf is visited for the first time: test it, and say what came out: leaf_done() or leaf_hit()
    hit,   ///< a known hit in [t_last, t_max] is visited again
    end,   ///< of the round
  };

  RayWalk(const NodeImage& image, const WalkKernels& kernels) : image_(image), kernels_(kernels) {}

  void begin_ray(std::uint32_t root) {
    walk_.known.size = 0;
    walk_.known.reserve(1);
    walk_.known.append(0.0f, std::numeric_limits<float>::infinity(), WalkList::kOpen, root);
    guards_.clear();
    opened_ = 0;
  }
  void begin_round(float t_min, float t_last, float t_max) {
    walk_.next.size = 0;
    walk_.next.reserve(walk_.known.size);
    walk_.position = 0;
    walk_.stack.size = 0;
    walk_.t_min = t_min;
    walk_.t_last = t_last;
    walk_.t_max = t_max;
    walk_.repeated_internal = 0;
    walk_.repeated_leaves = 0;
    pending_.clear();
    pending_place_ = kNowhere;
    changes_.clear();
    changes_.push_back({0, t_max});
  }

  Stop step();
  /// Address of the node or leaf of the last stop, units.
  std::uint32_t address() const { return address_; }
  /// Number of the hit of the last stop.
  std::uint32_t hit() const { return hit_; }

  void open(const SlabRay& ray);
  /// Address of the i-th of the nodes to come, i >= 1; of any node where there are fewer.
  std::uint32_t soon(std::uint32_t i) const {
    const WalkStack& stack = walk_.stack;
    return stack.what[stack.size >= i ? stack.size - i : 0] & ~WalkList::kLeaf;
  }
  void leaf_done() { settle(WalkList::kDone, WalkList::kLeaf); }
  void leaf_hit(float t, std::uint32_t number) { settle(t, WalkList::kLeaf | number); }
  /// t_max only falls within a round.
  void set_t_max(float t_max) {
    if (!(t_max < walk_.t_max)) return;
    walk_.t_max = t_max;
    changes_.push_back({walk_.next.size, t_max});
  }

  /// Visits in this round of nodes that an earlier one has tested.
  std::uint64_t repeated_internal() const { return walk_.repeated_internal; }
  std::uint64_t repeated_leaves() const { return walk_.repeated_leaves; }

 private:
  static constexpr std::uint32_t kNoGuard = ~std::uint32_t{0}, kNowhere = ~std::uint32_t{0};

  /// From the element at `from` on, this was t_max.
  struct Change {
    std::uint32_t from;
    float t_max;
  };
  /// A node on the stack that has a guard.
  struct Pending {
    std::uint32_t place;
    std::uint32_t guard;
  };

  /// What the node visited last has become.
  void settle(float state, std::uint32_t what) {
    if (guard_ != kNoGuard) {
      guards_[guard_].state = state;
      guards_[guard_].what = what;
      return;
    }
    walk_.next.state[at_] = state;
    walk_.next.what[at_] = what;
  }
  /// Room in `next` for all that is known and on the stack.
  void reserve() { walk_.next.reserve(walk_.next.size + walk_.stack.size + walk_.known.size - walk_.position); }
  void place_guards(float bound);
  void push_guarded(std::uint32_t place, std::uint32_t guard);
  void take_guard();
  bool pop();
  bool attend(Stop& stop);
  bool was_visited(std::uint32_t number) const;
  float t_max_at(std::uint32_t element) const;

  const NodeImage& image_;
  const WalkKernels kernels_;
  WalkState walk_;
  std::vector<WalkGuard> guards_;
  std::vector<Pending> pending_;
  std::uint32_t pending_place_ = kNowhere;  ///< of the last of them
  std::vector<Change> changes_;
  std::uint32_t opened_ = 0;  ///< internal nodes opened so far: the number of the next
  // The node visited last.
  std::uint32_t at_ = 0;  ///< in `next`
  std::uint32_t guard_ = kNoGuard;
  std::uint32_t address_ = 0;
  std::uint32_t hit_ = 0;
};

/// The next node of the stack, to `next`. False: it lies beyond t_max and stays open.
inline bool RayWalk::pop() {
  WalkStack& stack = walk_.stack;
  WalkList& next = walk_.next;
  const std::uint32_t place = --stack.size;
  const float enter = stack.enter[place];
  at_ = next.size;
  next.append(enter, stack.exit[place], WalkList::kOpen, stack.what[place]);
  guard_ = kNoGuard;
  address_ = stack.what[place];
  if (place == pending_place_) take_guard();
  return enter <= walk_.t_max;
}

inline RayWalk::Stop RayWalk::step() {
  for (;;) {
    while (walk_.stack.size > 0) {
      if (!pop()) continue;
      const bool leaf = (address_ & WalkList::kLeaf) != 0;
      address_ &= ~WalkList::kLeaf;
      return leaf ? Stop::leaf : Stop::node;
    }
    if (!kernels_.scan(walk_)) {
      std::swap(walk_.known, walk_.next);
      return Stop::end;
    }
    Stop stop = Stop::end;
    if (attend(stop)) return stop;
  }
}

inline void RayWalk::open(const SlabRay& ray) {
  const float enter = walk_.next.enter[at_];
  const float bound = guard_ == kNoGuard ? enter : guards_[guard_].bound;
  const std::uint32_t number = opened_++;
  if (guard_ != kNoGuard) guards_[guard_].number = number;
  settle(WalkList::kDone, number);
  walk_.stack.reserve_children();
  kernels_.open(walk_, image_, address_, ray, bound, walk_.next.exit[at_]);
  reserve();
  if (walk_.sticking_out != 0) place_guards(bound);
}

}  // namespace grtx::frontend
