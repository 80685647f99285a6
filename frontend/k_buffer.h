// The k closest hits of a round, ordered by (t, id).
#pragma once

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

 private:
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
