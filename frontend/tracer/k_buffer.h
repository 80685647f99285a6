// SPDX-License-Identifier: Apache-2.0
// The hits of a round: the k closest, ordered by (t, id); or all of them in order of arrival, as long as they fit.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

namespace grtx::frontend {

struct KEntry {
  float t = 0.0f;
  std::uint32_t id = 0;
  float d2 = 0.0f;  ///< squared distance at peak response, kernel radius = 1; recomputed by the shader in hardware
  friend bool operator<(const KEntry& a, const KEntry& b) { return a.t < b.t || (a.t == b.t && a.id < b.id); }
};

class KBuffer {
 public:
  explicit KBuffer(unsigned k) : k_(k) { entries_.reserve(k); }

  unsigned size() const { return static_cast<unsigned>(entries_.size()); }
  unsigned capacity() const { return k_; }
  bool full() const { return size() == k_; }
  void clear() { entries_.clear(); }
  const KEntry& back() const { return entries_.back(); }
  const std::vector<KEntry>& entries() const { return entries_; }
  void append_sorted(const KEntry& e) { entries_.push_back(e); }  ///< e must not precede the last entry

  /// Insertion sort from the back into a buffer with room; returns how many entries moved.
  unsigned insert(const KEntry& e) {
    assert(!full());
    entries_.push_back(e);
    return sink();
  }
  /// Replaces the last entry of a full buffer by a smaller one; returns how many entries moved.
  unsigned displace(const KEntry& e) {
    assert(full() && e < back());
    entries_.back() = e;
    return sink();
  }

  /// Appends to a buffer with room, unsorted. The entry that fills it makes it a heap, so that the largest entry is
  /// known; returns how many entries that moved, at most k - 1.
  unsigned append(const KEntry& e) {
    assert(!full());
    entries_.push_back(e);
    unsigned moved = 0;
    if (full()) {
      for (std::size_t i = entries_.size() / 2; i-- > 0;) moved += sift_down(i);
    }
    return moved;
  }
  /// The largest entry of a full buffer filled by append().
  const KEntry& largest() const { return entries_.front(); }
  /// Replaces largest() by a smaller entry; returns how many entries moved, at most log2(k).
  unsigned replace_largest(const KEntry& e) {
    assert(full() && e < largest());
    entries_.front() = e;
    return sift_down(0);
  }
  /// After append(): sorts by (t, id).
  void sort() { std::sort(entries_.begin(), entries_.end()); }

 private:
  unsigned sift_down(std::size_t i) {
    const KEntry e = entries_[i];
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
    const KEntry e = entries_[i];
    while (i > 0 && e < entries_[i - 1]) {
      entries_[i] = entries_[i - 1];
      --i;
    }
    entries_[i] = e;
    return static_cast<unsigned>(entries_.size() - 1 - i);
  }

  unsigned k_;
  std::vector<KEntry> entries_;
};

}  // namespace grtx::frontend
