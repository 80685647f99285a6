// A ray's checkpoint entries in bins of distance: so many near ones around a circle, and a far one for all that lies
// beyond them. Each bin is a ring that is only appended to. A round reads the near bins from that on in which the last
// round's t_max lay, and in between or behind them the far one; in each what was there when the round began. It may
// stop at any entry, and what it has not read stays where it is. Tracer, trace codec, checker and hardware model ask
// here which entry comes next and where it lies.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace grtx::traces {

inline constexpr unsigned kMaxCheckpointBins = 32;

/// Of a distance as fp32 the leading bits behind the sign are the number of its bin: three of the mantissa stay, which
/// makes eight stretches an octave.
inline constexpr unsigned kBinNumberBits = 11;

/// The bin of a distance that is not negative, of all that there could be. Never falls with growing distance, so what
/// lies up to t_max has no larger number than t_max.
inline std::uint32_t number_of_bin(float distance) {
  return std::bit_cast<std::uint32_t>(distance) >> (31 - kBinNumberBits);
}

/// Where an entry lies: in which ring, and where in it.
struct BinPlace {
  std::uint32_t bin = 0;
  std::uint32_t position = 0;
};

/// The order in which a round reads: from near bin `first` on, the far one after `before_far` near ones.
struct BinOrder {
  std::uint8_t first = 0;
  std::uint8_t before_far = 0;
  friend bool operator==(const BinOrder&, const BinOrder&) = default;
};

/// The places.
class CheckpointBins {
 public:
  /// near: bins, besides the far one; 0: there is none. capacity: places of a ring.
  explicit CheckpointBins(unsigned near = 0, std::uint64_t capacity = 0)
      : near_(near), rings_(rings_of(near)), capacity_(static_cast<std::uint32_t>(capacity)) {}

  /// Rings that so many near bins need.
  static constexpr unsigned rings_of(unsigned near) { return near != 0 ? near + 1 : 0; }
  unsigned near() const { return near_; }
  unsigned count() const { return static_cast<unsigned>(rings_.size()); }
  unsigned far_bin() const { return near_; }
  bool allows(const BinOrder& order) const { return order.first < near_ && order.before_far <= near_; }

  /// replays: the round may read what there is, in this order. Else all is forgotten.
  void begin_round(bool replays, const BinOrder& order) {
    if (!replays) rings_.assign(rings_.size(), Ring{});
    for (Ring& ring : rings_) {
      if (ring.read == ring.written) ring = {};  // few lines of memory are touched when rings begin anew
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
  /// If there is more(): whether its bin is the far one, and how many near ones come before it.
  bool next_is_far() const { return step_ == order_.before_far; }
  unsigned near_before() const { return step_ <= order_.before_far ? step_ : step_ - 1; }
  BinPlace read() {
    const unsigned bin = reading();
    return {bin, rings_[bin].read++ % capacity_};
  }
  /// Entries that are held.
  std::uint64_t size() const {
    std::uint64_t sum = 0;
    for (const Ring& ring : rings_) sum += ring.written - ring.read;
    return sum;
  }

 private:
  /// Counted since the ring was empty; places are these modulo the capacity.
  struct Ring {
    std::uint32_t read = 0, written = 0;
    std::uint32_t limit = 0;  ///< of what the round may read
  };
  unsigned reading() const { return next_is_far() ? near_ : (order_.first + near_before()) % near_; }

  unsigned near_ = 0;
  std::vector<Ring> rings_;
  std::uint32_t capacity_ = 0;
  BinOrder order_;
  unsigned step_ = 0;  ///< bins of which nothing is left to this round
};

/// The same with the entries.
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
