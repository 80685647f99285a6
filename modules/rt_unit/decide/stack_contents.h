// What lies on a lane's traversal stack at any time of a round. A trace has no stack, but each entry is taken by one
// event, visited or culled: that event stands for it. Without time: who reads stacks ahead asks here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

class StackContents {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  /// The lane begins a round of a ray of `group` with these events. traffic must outlive the round.
  void begin(const traces::RayGroup& group, std::span<const traces::Event> events, const NodeTraffic& traffic);

  std::size_t events() const { return events_.size(); }
  const traces::Event& event(std::size_t number) const { return events_[number]; }
  /// The entry on top once event `number` has moved the stack; kNone: there is none.
  std::uint32_t top_after(std::size_t number) const {
    const std::size_t next = number + 1;
    return next < events_.size() && EventEffect(events_[next]).takes_top() ? static_cast<std::uint32_t>(next) : kNone;
  }
  /// The entry that lies under `entry`, which an event takes; kNone: there is none.
  std::uint32_t below(std::uint32_t entry) const { return entries_[entry].below; }
  /// Whoever fetches the entry's node ahead marks it.
  bool marked(std::uint32_t entry) const { return entries_[entry].marked; }
  void mark(std::uint32_t entry) { entries_[entry].marked = true; }
  /// The node that the entry names. Of a culled one the visit that pushed it says the kind.
  NodeVisit node(std::uint32_t entry) const;
  /// False: its event visits a node that is not there, for which the trace will be refused.
  bool known(std::uint32_t entry) const { return culled(entry) || node_visit(events_[entry], *group_, *traffic_); }
  /// For counting only: who fetches ahead does not know it.
  bool culled(std::uint32_t entry) const { return events_[entry].kind() == traces::EventKind::cull; }
  const traces::RayGroup& group() const { return *group_; }

 private:
  struct Entry {
    std::uint32_t below = kNone;
    traces::NodeKind kind{};  ///< of a culled one
    bool marked = false;
  };
  const traces::RayGroup* group_ = nullptr;
  const NodeTraffic* traffic_ = nullptr;
  std::span<const traces::Event> events_;
  std::vector<Entry> entries_;  ///< by the number of the event that takes it
};

}  // namespace grtx::modules
