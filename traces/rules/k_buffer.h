// SPDX-License-Identifier: Apache-2.0
// The hits of a round: the k nearest in their order; or all of them in order of arrival, as long as they fit.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

namespace grtx::traces {

/// Entries are ordered by operator<.
template <typename Entry>
class KBuffer {
 public:
  /// sorted: at all times. Otherwise entries are appended, and those of a full buffer are a heap.
  KBuffer(unsigned k, bool sorted) : k_(k), sorted_(sorted) { entries_.reserve(k); }

  unsigned size() const { return static_cast<unsigned>(entries_.size()); }
  unsigned capacity() const { return k_; }
  bool full() const { return size() == k_; }
  const std::vector<Entry>& entries() const { return entries_; }
  std::vector<Entry>& entries() { return entries_; }
  /// The last entry of a full buffer, in the order of entries.
  const Entry& last() const { return sorted_ ? entries_.back() : entries_.front(); }

  void clear() { entries_.clear(); }
  /// Appends an entry that does not precede the last one.
  void append_sorted(const Entry& e) { entries_.push_back(e); }
  /// Drops the last entries of a sorted buffer.
  void drop_last(unsigned count) { entries_.resize(entries_.size() - count); }
  /// Adds an entry to a buffer with room; returns how many entries moved. sorted: insertion from the back. Else the
  /// entry that fills the buffer makes it a heap, which moves at most k - 1.
  unsigned insert(const Entry& e) {
    assert(!full());
    entries_.push_back(e);
    if (sorted_) return sink();
    unsigned moved = 0;
    if (full()) {
      for (std::size_t i = entries_.size() / 2; i-- > 0;) moved += sift_down(i);
    }
    return moved;
  }
  /// Replaces last() by an entry that precedes it; returns how many entries moved: in a heap at most log2(k).
  unsigned replace_last(const Entry& e) {
    assert(full() && e < last());
    if (sorted_) {
      entries_.back() = e;
      return sink();
    }
    entries_.front() = e;
    return sift_down(0);
  }
  /// Sorts the entries of a round that is over.
  void sort() {
    if (!sorted_) std::sort(entries_.begin(), entries_.end());
  }

  // For readers of a trace, which does not say which entries precede others. They keep the order of arrival where
  // entries are not sorted.

  /// Place of an entry whose insertion shifted others; at most size() of them.
  std::size_t place(unsigned shifts) const { return entries_.size() - (sorted_ ? shifts : 0); }
  void put(std::size_t place, const Entry& e) { entries_.insert(at(place), e); }
  Entry take_out(std::size_t place) {
    const Entry e = entries_[place];
    entries_.erase(at(place));
    return e;
  }

 private:
  auto at(std::size_t place) { return entries_.begin() + static_cast<std::ptrdiff_t>(place); }

  unsigned sift_down(std::size_t i) {
    const Entry e = entries_[i];
    unsigned moved = 0;
    for (std::size_t child = 2 * i + 1; child < entries_.size(); child = 2 * i + 1) {
      if (child + 1 < entries_.size() && entries_[child] < entries_[child + 1]) ++child;
      if (!(e < entries_[child])) break;
      entries_[i] = entries_[child];
      i = child;
      ++moved;
    }
    entries_[i] = e;
    return moved;
  }

  unsigned sink() {
    std::size_t i = entries_.size() - 1;
    const Entry e = entries_[i];
    while (i > 0 && e < entries_[i - 1]) {
      entries_[i] = entries_[i - 1];
      --i;
    }
    entries_[i] = e;
    return static_cast<unsigned>(entries_.size() - 1 - i);
  }

  unsigned k_;
  bool sorted_;
  std::vector<Entry> entries_;
};

}  // namespace grtx::traces
