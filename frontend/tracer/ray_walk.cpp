#include "grtx/frontend/tracer/ray_walk.h"

#include <bit>
#include <cassert>
#include <cmath>

namespace grtx::frontend {

/// For the children pushed last: their parent is the node opened last.
void RayWalk::place_guards(float bound) {
  for (std::uint32_t rest = walk_.sticking_out; rest != 0; rest &= rest - 1) {
    const std::uint32_t place = walk_.pushed_at + static_cast<std::uint32_t>(std::countr_zero(rest));
    push_guarded(place, static_cast<std::uint32_t>(guards_.size()));
    guards_.push_back({bound, opened_ - 1, 0, WalkList::kOpen, 0});
  }
}

void RayWalk::push_guarded(std::uint32_t place, std::uint32_t guard) {
  pending_.push_back({place, guard});
  pending_place_ = place;
}

/// Takes the guard of the node popped last, which stands at the end of `next`.
void RayWalk::take_guard() {
  guard_ = pending_.back().guard;
  pending_.pop_back();
  pending_place_ = pending_.empty() ? kNowhere : pending_.back().place;
  guards_[guard_].what = address_;
  walk_.next.state[at_] = WalkList::kGuarded;
  walk_.next.what[at_] = (address_ & WalkList::kLeaf) | guard_;
}

/// The element of `known` that scan() stopped at. False: nothing to do but to go on.
bool RayWalk::attend(Stop& stop) {
  WalkList& known = walk_.known;
  const std::uint32_t element = walk_.position++;
  const float enter = known.enter[element], exit = known.exit[element];
  float state = known.state[element];
  std::uint32_t what = known.what[element];
  std::uint32_t guard = kNoGuard;
  if (state == WalkList::kGuarded) {
    guard = what & ~WalkList::kLeaf;
    state = guards_[guard].state;
    what = guards_[guard].what;
    const bool visited = guards_[guard].bound <= walk_.t_max || was_visited(guards_[guard].parent);
    if (!visited) {
      walk_.next.append(enter, exit, known.state[element], known.what[element]);
      return false;
    }
  }
  if (state == WalkList::kOpen) {
    walk_.stack.enter[0] = enter;
    walk_.stack.exit[0] = exit;
    walk_.stack.what[0] = what;
    walk_.stack.size = 1;
    if (guard != kNoGuard) push_guarded(0, guard);
    reserve();
    return false;
  }
  walk_.next.append(enter, exit, known.state[element], known.what[element]);
  ++((what & WalkList::kLeaf) != 0 ? walk_.repeated_leaves : walk_.repeated_internal);
  if (!(state >= walk_.t_last && state <= walk_.t_max)) return false;
  hit_ = what & ~WalkList::kLeaf;
  stop = Stop::hit;
  return true;
}

/// Whether this round has visited the internal node with this number. It lies in `next`: nothing below a node that
/// ended before t_min is left.
bool RayWalk::was_visited(std::uint32_t number) const {
  const WalkList& next = walk_.next;
  for (std::uint32_t i = next.size; i-- > 0;) {
    if ((next.what[i] & WalkList::kLeaf) != 0) continue;
    if (std::isnan(next.state[i]) && next.what[i] == number) return next.enter[i] <= t_max_at(i);
    if (next.state[i] != WalkList::kGuarded) continue;
    const WalkGuard& guard = guards_[next.what[i]];
    if (!std::isnan(guard.state) || guard.number != number) continue;
    const float t_max = t_max_at(i);
    return next.enter[i] <= t_max && (guard.bound <= t_max || was_visited(guard.parent));
  }
  assert(false);
  return false;
}

float RayWalk::t_max_at(std::uint32_t element) const {
  std::size_t change = changes_.size() - 1;
  while (changes_[change].from > element) --change;
  return changes_[change].t_max;
}

}  // namespace grtx::frontend
