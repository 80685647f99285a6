// Which nodes a lane's source entries name, ahead of their being read. The hardware sees them in the entries, with
// their t; here the events of the round say both, and whether an entry will be taken. Without time: the RT scheduler,
// fast mode and functional warming ask here.
#pragma once

#include <cstdint>
#include <span>

#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

class SourceNodes {
 public:
  SourceNodes() = default;
  /// events: of the round.
  explicit SourceNodes(std::span<const traces::Event> events)
      : next_(events.data()), end_(events.data() + events.size()) {}

  /// f(kind, address in bytes) for those of the entries `first` to `first + count` - 1, in the order in which they are
  /// read, that will be taken. Entries before those of an earlier call are passed over. Of a node inside the BLAS it is
  /// the instance leaf: every L1 holds the shared BLAS, and the leaves of a scene TLAS.
  template <typename F>
  void for_each_taken(std::uint32_t first, std::uint32_t count, const traces::RayGroup& group,
                      const NodeTraffic& traffic, F&& f) {
    for (; next_ != end_ && entry_ < first + count; ++next_) {
      if (!EventEffect(*next_).replays()) continue;
      if (entry_++ < first || next_->kind() != traces::EventKind::replay_take) continue;
      const unsigned first_own = traffic.levels().is_object(next_->node) ? 2 : 1;  // behind the scene leaf's visit
      if (end_ - next_ <= first_own) continue;
      if (const auto node = node_visit(next_[first_own], group, traffic)) f(node->kind, node->address);
    }
  }

 private:
  const traces::Event* next_ = nullptr;
  const traces::Event* end_ = nullptr;
  std::uint32_t entry_ = 0;  ///< of next_, or the first behind it
};

}  // namespace grtx::modules
