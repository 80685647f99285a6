// SPDX-License-Identifier: Apache-2.0
// Tracks which of a module's many input links hold something, so that the module polls only those.
#pragma once

#include "grtx/modules/kernel/index_set.h"
#include "grtx/modules/kernel/link_access.h"

namespace grtx::modules {

class WaitingLinks {
 public:
  explicit WaitingLinks(unsigned links) : numbers_(links), silent_(links) {}

  /// Registers input link number `i`. This object must not move afterwards. A link that does not support announce()
  /// always counts as waiting.
  template <typename T>
  void watch(unsigned i, const LinkReader<T>& link) {
    if (!link.announce(numbers_.word_of(i), i % 64)) always(i);
  }
  /// Number `i` always counts as waiting.
  void always(unsigned i) {
    silent_.insert(i);
    numbers_.insert(i);
  }
  /// Call after popping from link number `i`.
  template <typename T>
  void popped(unsigned i, const LinkReader<T>& link) {
    if (link.next_visible() == kNever && !silent_.contains(i)) numbers_.erase(i);
  }

  /// Calls f(number) for each link that may hold something, lowest first. f may pop from the link.
  template <typename F>
  void for_each(F&& f) const {
    numbers_.for_each(f);
  }
  /// The same, beginning with number `first` and going once around.
  template <typename F>
  [[gnu::always_inline]] void for_each_from(unsigned first, F&& f) const {
    numbers_.for_each_from(first, f);
  }

 private:
  IndexSet numbers_;
  IndexSet silent_;  ///< links that do not announce
};

}  // namespace grtx::modules
