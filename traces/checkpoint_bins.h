// SPDX-License-Identifier: Apache-2.0
// A ray's checkpoint entries sorted into bins by distance: near bins, used cyclically, and one far bin for everything
// beyond them. Each bin is a ring buffer. A replay round reads the near bins starting with the one that contains the
// last round's t_max, and the far bin between or after them; in each bin only the entries present when the round began.
// It may stop at any entry; unread entries stay. Tracer, trace codec, checker and hardware model all use this class for
// the next entry and its place.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace grtx::traces {

inline constexpr unsigned kMaxCheckpointBins = 32;

/// Bits of a bin number: the leading bits of an fp32 distance after its sign. Includes three bits of the mantissa,
/// hence eight bins per octave.
inline constexpr unsigned kBinNumberBits = 11;

/// The bin number of a non-negative distance. It never falls with growing distance, so entries up to t_max have no
/// higher number than t_max.
inline std::uint32_t number_of_bin(float distance) {
  return std::bit_cast<std::uint32_t>(distance) >> (31 - kBinNumberBits);
}

/// Place of an entry: bin, and position in its ring.
struct BinPlace {
  std::uint32_t bin = 0;
  std::uint32_t position = 0;
};

/// Read order of a round: from near bin `first` on, with the far bin after `before_far` near bins.
struct BinOrder {
  std::uint8_t first = 0;
  std::uint8_t before_far = 0;
  friend bool operator==(const BinOrder&, const BinOrder&) = default;
};

/// The places of the entries, without the entries themselves.
class CheckpointBins {
 public:
  /// near: number of near bins; 0: no bins at all, not even the far one. capacity: entries per ring.
  explicit CheckpointBins(unsigned near = 0, std::uint64_t capacity = 0)
      : near_(near), rings_(rings_of(near)), capacity_(static_cast<std::uint32_t>(capacity)) {}

  /// Number of rings for `near` near bins, including the far one.
  static constexpr unsigned rings_of(unsigned near) { return near != 0 ? near + 1 : 0; }
  unsigned near() const { return near_; }
  unsigned count() const { return static_cast<unsigned>(rings_.size()); }
  unsigned far_bin() const { return near_; }
  bool allows(const BinOrder& order) const { return order.first < near_ && order.before_far <= near_; }

  /// Begins a round. replays: it may read the present entries, in this order; otherwise all entries are discarded.
  void begin_round(bool replays, const BinOrder& order) {
    if (!replays) rings_.assign(rings_.size(), Ring{});
    for (Ring& ring : rings_) {
      if (ring.read == ring.written) ring = {};  // restarting empty rings touches fewer lines of memory
      ring.limit = ring.written;
    }
    order_ = order;
    step_ = 0;
  }
  bool empty(unsigned bin) const { return rings_[bin].written == rings_[bin].read; }
  bool full(unsigned bin) const { return rings_[bin].written - rings_[bin].read == capacity_; }
  /// The bin must not be full.
  BinPlace write(unsigned bin) {
    assert(!full(bin));
    return {bin, rings_[bin].written++ % capacity_};
  }
  /// Whether the round may read another entry.
  bool more() {
    for (; step_ < count(); ++step_) {
      const Ring& ring = rings_[reading()];
      if (ring.read != ring.limit) return true;
    }
    return false;
  }
  /// Requires more(): whether the next entry is in the far bin, and how many near bins come before its bin.
  bool next_is_far() const { return step_ == order_.before_far; }
  unsigned near_before() const { return step_ <= order_.before_far ? step_ : step_ - 1; }
  BinPlace read() {
    const unsigned bin = reading();
    return {bin, rings_[bin].read++ % capacity_};
  }
  /// Number of unread entries.
  std::uint64_t size() const {
    std::uint64_t sum = 0;
    for (const Ring& ring : rings_) sum += ring.written - ring.read;
    return sum;
  }

 private:
  /// Running counts since the ring was reset; positions are these modulo the capacity.
  struct Ring {
    std::uint32_t read = 0, written = 0;
    std::uint32_t limit = 0;  ///< the round may read up to this count
  };
  unsigned reading() const { return next_is_far() ? near_ : (order_.first + near_before()) % near_; }

  unsigned near_ = 0;
  std::vector<Ring> rings_;
  std::uint32_t capacity_ = 0;
  BinOrder order_;
  unsigned step_ = 0;  ///< bins that the round has finished reading
};

/// CheckpointBins together with the entries.
template <typename Entry>
class BinnedEntries {
 public:
  explicit BinnedEntries(unsigned near = 0, std::uint64_t capacity = 0)
      : places_(near, capacity), entries_(places_.count()) {}

  const CheckpointBins& places() const { return places_; }
  void begin_round(bool replays, const BinOrder& order) { places_.begin_round(replays, order); }
  bool more() { return places_.more(); }
  void write(unsigned bin, const Entry& entry) {
    const BinPlace place = places_.write(bin);
    std::vector<Entry>& ring = entries_[bin];
    if (place.position >= ring.size()) ring.resize(place.position + std::size_t{1});
    ring[place.position] = entry;
  }
  Entry read() {
    const BinPlace place = places_.read();
    return entries_[place.bin][place.position];
  }

 private:
  CheckpointBins places_;
  std::vector<std::vector<Entry>> entries_;
};

}  // namespace grtx::traces
