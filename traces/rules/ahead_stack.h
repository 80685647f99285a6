// SPDX-License-Identifier: Apache-2.0
// The stack of a ray with several nodes under way at once (Header::ahead): the topmost nodes that wait are started as
// long as there is room. A node under way keeps its place, and what it pushes comes there. docs/model/tracer.md, "Nodes
// under way".
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace grtx::traces {

template <typename Node>
class AheadStack {
 public:
  explicit AheadStack(unsigned ahead = 1) : ahead_(ahead) {}

  void begin(const Node& root) {
    stack_.assign(1, {root});
    started_ = under_way_ = 0;
  }
  bool empty() const { return stack_.empty(); }

  /// Starts nodes from the top. starts(node): whether it does; false: the node lies beyond t_max now and leaves the
  /// stack.
  template <typename Starts>
  void start(const Starts& starts) {
    for (std::size_t i = stack_.size(); i-- > 0 && under_way_ < ahead_;) {
      if (stack_[i].started != 0) continue;
      if (starts(stack_[i].node)) {
        stack_[i].started = ++started_;
        ++under_way_;
      } else {
        stack_.erase(at(i));
      }
    }
  }
  /// Takes the node that is done next: each takes as long as the others, so it is the one started first.
  Node take() {
    assert(under_way_ != 0);
    std::size_t first = stack_.size();
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      if (stack_[i].started != 0 && (first == stack_.size() || stack_[i].started < stack_[first].started)) first = i;
    }
    const Node node = stack_[first].node;
    stack_.erase(at(first));
    --under_way_;
    place_ = first;
    return node;
  }
  /// Pushes a child of the node taken last; the topmost child comes first.
  void push(const Node& child) { stack_.insert(at(place_), {child}); }

 private:
  struct Entry {
    Node node;
    std::uint64_t started = 0;  ///< its number among those started; 0: it waits
  };
  auto at(std::size_t place) { return stack_.begin() + static_cast<std::ptrdiff_t>(place); }

  unsigned ahead_;
  std::vector<Entry> stack_;  ///< the topmost last
  std::uint64_t started_ = 0;
  unsigned under_way_ = 0;
  std::size_t place_ = 0;  ///< of the node taken last
};

}  // namespace grtx::traces
