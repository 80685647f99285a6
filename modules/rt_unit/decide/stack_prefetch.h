// Which nodes of a lane's traversal stack are fetched ahead: those below the top, whose turn comes once the subtrees
// above them are done. After TTP (Tozlu, Naithani and Zhou, arXiv 2605.16253), which GRTX does not have. Without time:
// the prefetcher and fast mode ask here.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/stack_contents.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// When a lane's stack is looked at. pop: events in succession took an entry each and pushed none: the walk goes up.
/// push: a visit pushed several children: the walk goes down one of them.
enum class StackTrigger : std::uint8_t { pop, push };
constexpr auto enum_names(StackTrigger) { return names_in_order<StackTrigger>({"pop", "push"}); }

struct StackPrefetchConfig {
  static constexpr unsigned kMaxDepth = 64;
  unsigned depth = 0;  ///< 0: off
  StackTrigger trigger = StackTrigger::pop;
  unsigned pops = 2;
  void parameters(ParameterList& list) {
    list.add("depth", depth, {0, kMaxDepth}, "entries",
             "of a lane's traversal stack, from the top, whose nodes are prefetched; 0: off", kOurs)
        .came_later();
    list.add("trigger", trigger,
             "pop: they are after pops in succession, push: after a visit that pushes several children",
             from_public("TTP, arXiv 2605.16253: consecutive pops"))
        .came_later();
    list.add("pops", pops, {1, 64}, "events", "in succession that take an entry and push none, for trigger pop",
             assumed("this project: TTP says consecutive, and no number"))
        .came_later();
  }
};

class StackPrefetch {
 public:
  using Config = StackPrefetchConfig;
  /// A node whose address lies on the stack.
  struct Node {
    traces::NodeKind kind;
    std::uint64_t address;  ///< bytes
    bool culled;            ///< for counting only: its entry will be culled, and nobody will fetch it
  };

  /// lanes: of the warp buffer. traffic must outlive it.
  StackPrefetch(std::size_t lanes, const Config& config, const NodeTraffic& traffic);

  bool enabled() const { return config_.depth > 0; }
  const Config& config() const { return config_; }

  /// The lane begins a round of a ray of `group` with these events.
  void begin(std::size_t lane, const traces::RayGroup& group, std::span<const traces::Event> events);
  /// An event of the lane has moved its stack. left: events of the round that are left, this one among them. on_chip:
  /// entries at the top that the warp buffer holds. Calls f(node) for each of these that is to be prefetched, from the
  /// top, at most `depth`; once f returns true (the prefetch is on its way), the entry is passed over. Returns whether
  /// the stack was looked at.
  template <typename F>
  bool moved(std::size_t lane, std::size_t left, std::uint32_t on_chip, F&& f) {
    Lane& l = lanes_[lane];
    StackContents& stack = l.stack;
    assert(left > 0 && left <= stack.events());
    const std::size_t event = stack.events() - left;
    const EventEffect effect(stack.event(event));
    if (!triggered(l, effect)) return false;
    std::uint32_t at = stack.top_after(event);
    // The next event fetches the top, unless the shader runs before.
    for (unsigned skip = effect.calls_any_hit() ? 0 : 1, seen = 0;
         at != StackContents::kNone && seen < on_chip && seen < config_.depth + skip; ++seen, at = stack.below(at)) {
      if (seen < skip || stack.marked(at)) continue;
      const NodeVisit node = stack.node(at);
      if (f(Node{node.kind, node.address, stack.culled(at)})) stack.mark(at);
    }
    return true;
  }

 private:
  struct Lane {
    StackContents stack;
    unsigned pops = 0;  ///< in succession
  };
  bool triggered(Lane& lane, const EventEffect& effect) const;

  Config config_;
  const NodeTraffic& traffic_;
  std::vector<Lane> lanes_;
};

}  // namespace grtx::modules
