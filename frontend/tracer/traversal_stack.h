// SPDX-License-Identifier: Apache-2.0
// The traversal stack. Its entries are also what checkpoint buffers hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

/// Numbers of nodes are indices into the ray's WalkMemory; 0 is the root.
struct StackEntry {
  float t = 0.0f;  ///< conservative entry t, or t_hit of a leaf beyond t_max
  std::uint32_t node = 0;
  std::uint32_t packed = 0;    ///< the node's kind, slot and link, as they were when it was pushed
  std::uint32_t instance = 0;  ///< TLAS leaf; 0 for nodes outside the BLAS
  std::uint32_t object = 0;    ///< leaf of the scene TLAS; 0 in that TLAS and in scenes of one object

  bool in_blas() const { return instance != 0; }
};

/// Grows before a node's children are pushed, so that a push needs no check.
class TraversalStack {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  void clear() { size_ = 0; }
  /// Entry i from the top; 0: the next to be popped.
  const StackEntry& from_top(std::size_t i) const { return entries_[size_ - 1 - i]; }
  StackEntry pop() { return entries_[--size_]; }
  void push(const StackEntry& e) {
    *top() = e;
    ++size_;
  }
  /// Address of the next entries, with room for eight; set_top() then takes the address behind the last one written.
  StackEntry* top() {
    if (size_ + traces::kMaxWidth > entries_.size()) grow();
    return entries_.data() + size_;
  }
  void set_top(const StackEntry* end) { size_ = static_cast<std::size_t>(end - entries_.data()); }

 private:
  /// Separate, so that top() is small enough to be inlined.
  [[gnu::noinline]] void grow() { entries_.resize(2 * entries_.size()); }

  std::vector<StackEntry> entries_ = std::vector<StackEntry>(512);
  std::size_t size_ = 0;
};

}  // namespace grtx::frontend
