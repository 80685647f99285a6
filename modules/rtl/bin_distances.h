// Distances that a trace with checkpoint bins does not hold: where a ray enters the scene, and t values that lead to
// the bins of its entries and to the order in which its rounds read them. With them a ray's lists, as the RTL of the
// checkpoint unit must keep them. docs/model/rtl_bridge.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// fp32, as bits.
struct EntryTimes {
  std::uint32_t t = 0, t_min = 0, t_max = 0;
};

/// Stretch in which t lies, of a ray that enters the scene at `enter`; both fp32 as bits. The tracer's arithmetic.
std::uint32_t stretch_of(std::uint32_t t, std::uint32_t enter);

inline constexpr int kNoBin = -1;
/// Bin of an entry `number` stretches from where the ray enters, with t_max in stretch `nearest`; kNoBin: all are full.
int bin_of(const traces::CheckpointBins& places, std::uint32_t nearest, std::uint32_t number);

class BinnedRay {
 public:
  using Entry = std::array<std::uint32_t, 2>;  ///< 8 B; the first word is t

  BinnedRay(unsigned near, std::uint64_t capacity) : near_(near), capacity_(capacity), lists_(near, capacity) {}

  /// Its first round begins. ray: outlives it. seed: of the distances. Throws Error when none lead to the trace's bins.
  void begin_ray(const traces::Ray& ray, std::uint64_t seed);
  void begin_round(std::uint32_t round);
  std::uint32_t enter() const { return enter_; }
  /// t_max at the end of the round before.
  std::uint32_t last_t_max() const { return last_t_max_; }

  /// An entry that is handed over: where it must go, and with which t.
  struct Offer {
    std::uint32_t bin = 0;
    std::uint32_t nearest = 0;  ///< stretch of its t_max
    EntryTimes times;
    Entry entry{};
  };
  /// Entries are offered in order: after offer_from_here() the next one that is not taken, then those behind it.
  void offer_from_here();
  Offer offer();
  /// The first one that is offered now.
  void take(const Offer& offer);
  /// An entry of any t, for the lists as they are: the bin is bin_of()'s, or kNoBin.
  struct Probe {
    EntryTimes times;
    int bin;
  };
  Probe probe(std::uint64_t seed) const;

  /// Whether the round may read on.
  bool more() { return lists_.more(); }
  /// If there is more(): a t_max that the next entry does not lie beyond, and one that it does (0: there is none).
  std::uint32_t reaching_t_max() const;
  std::uint32_t falling_short() const;
  Entry read() { return lists_.read(); }
  const traces::CheckpointBins& places() const { return lists_.places(); }

 private:
  void plan(std::uint64_t seed);
  std::uint32_t t_in(std::uint32_t number, std::uint64_t seed) const;
  std::uint32_t next_number() const;

  unsigned near_;
  std::uint64_t capacity_;
  traces::BinnedEntries<Entry> lists_;
  traces::CheckpointBins ahead_;  ///< with what has been offered
  const traces::Ray* ray_ = nullptr;
  std::uint64_t seed_ = 0;
  std::uint32_t enter_ = 0, base_ = 0;
  std::uint32_t last_t_max_ = 0;
  std::vector<std::uint32_t> reached_;    ///< by round: stretch of the t_max at the end of the one before
  std::vector<std::uint32_t> far_bound_;  ///< by entry, of those in the far bin: its lowest stretch from then on
  std::size_t taken_ = 0, offered_ = 0;   ///< entries of the ray
  std::uint32_t reads_from_ = 0;          ///< reached_ of this round
  std::uint32_t far_from_ = 0;
};

}  // namespace grtx::modules
