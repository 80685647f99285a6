// Which of a module's many input links hold something: a module that is called in a busy cycle looks at few of them.
#pragma once

#include "grtx/modules/kernel/index_set.h"
#include "grtx/modules/kernel/link_access.h"

namespace grtx::modules {

class WaitingLinks {
 public:
  explicit WaitingLinks(unsigned links) : numbers_(links), silent_(links) {}

  /// Link number `i` of this module, the consumer. Neither is to move afterwards. A link that does not announce what it
  /// holds always counts as waiting.
  template <typename T>
  void watch(unsigned i, const LinkReader<T>& link) {
    if (link.announce(numbers_.word_of(i), i % 64)) return;
    silent_.insert(i);
    numbers_.insert(i);
  }
  /// To be called when something was taken from link number `i`.
  template <typename T>
  void popped(unsigned i, const LinkReader<T>& link) {
    if (link.next_visible() == kNever && !silent_.contains(i)) numbers_.erase(i);
  }

  /// f(number) for each that may hold something, lowest first. f may take from the link.
  template <typename F>
  void for_each(F&& f) const {
    numbers_.for_each(f);
  }
  /// The same, beginning with number `first` and going once around.
  template <typename F>
  void for_each_from(unsigned first, F&& f) const {
    numbers_.for_each_from(first, f);
  }

 private:
  IndexSet numbers_;
  IndexSet silent_;  ///< links that do not announce
};

}  // namespace grtx::modules
