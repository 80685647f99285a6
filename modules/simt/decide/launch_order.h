// SPDX-License-Identifier: Apache-2.0
// The order of launches: the groups of a launch start when all groups of the previous launch have ended. The primary
// rays of a frame are one launch, its secondary rays another.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct LaunchSpan {
  std::uint32_t frame = 0;
  bool secondary = false;
  Cycle end = 0;  ///< cycle in which the end of its last group was seen; the next launch begins then
  friend bool operator==(const LaunchSpan&, const LaunchSpan&) = default;
};

class LaunchOrder {
 public:
  /// Whether `group` must wait because groups of the previous launch are running. If not, it counts as launched.
  bool holds_back(const traces::RayGroup& group, bool running, Cycle now) {
    const LaunchSpan next{group.frame, group.kind != traces::RayKind::primary, 0};
    if (begun_ && next == current_) return false;
    if (begun_ && running) return true;
    if (begun_) end_launch(now);
    begun_ = true;
    current_ = next;
    return false;
  }
  /// The last group has ended.
  void finish(Cycle now) { end_launch(now); }
  /// The finished launches, in order. A launch begins at the end of the previous one.
  const std::vector<LaunchSpan>& spans() const { return spans_; }

 private:
  void end_launch(Cycle now) { spans_.push_back({current_.frame, current_.secondary, now}); }

  bool begun_ = false;
  LaunchSpan current_;
  std::vector<LaunchSpan> spans_;
};

/// Total cycles of all launches of one kind.
inline Cycle cycles_of_kind(const std::vector<LaunchSpan>& spans, bool secondary) {
  Cycle sum = 0;
  Cycle start = 0;
  for (const LaunchSpan& span : spans) {
    if (span.secondary == secondary) sum += span.end - start;
    start = span.end;
  }
  return sum;
}

}  // namespace grtx::modules
