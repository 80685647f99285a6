// SPDX-License-Identifier: Apache-2.0
// The hits of a ray: those of its round in the k-buffer, and the evicted ones that wait for a later round. They move by
// the rules of a round, for the tracer, which compares hits, and for readers of a trace, which know the outcomes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "grtx/traces/rules/k_buffer.h"
#include "grtx/traces/rules/opacity_sum.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::traces {

/// Entry: a hit with members t and, for the tracer, opacity (opacity_steps(), 0 without the bound), ordered by
/// operator<.
template <typename Entry>
class RoundHits {
 public:
  /// opacity: of the tracer; readers of a trace know what is hidden.
  explicit RoundHits(const RoundRules& rules, const OpacitySum& opacity = {OpacityBound::off, 0.0f})
      : rules_(rules), k_buffer_(rules.k(), rules.sorted()), opacity_(opacity) {}

  const RoundRules& rules() const { return rules_; }
  const KBuffer<Entry>& k_buffer() const { return k_buffer_; }
  const std::vector<Entry>& evictions() const { return evictions_; }

  void begin_ray() {
    k_buffer_.clear();
    evictions_.clear();
  }
  /// Fills the k-buffer with the nearest evicted hits, up to the end that opacity sets, which `end` then is; returns
  /// how many. transmittance: what the hits blended so far leave.
  std::size_t begin_round(float transmittance, float& end) {
    opacity_.begin_round(transmittance);
    k_buffer_.clear();
    if (evictions_.empty()) return 0;
    std::sort(evictions_.begin(), evictions_.end());
    std::size_t count = rules_.preloaded(evictions_.size());
    for (std::size_t i = 0; opacity_.on() && i < count; ++i) {
      opacity_.add(evictions_[i].opacity);
      if (!opacity_.ends()) continue;
      end = std::min(end, evictions_[i].t);
      count = i + 1;
    }
    preload(count);
    return count;
  }
  void end_round() { k_buffer_.sort(); }
  /// After a round whose checkpoints overflowed: later rounds meet these hits again.
  void drop_evictions() { evictions_.clear(); }

  struct Taken {
    LeafOutcome outcome;
    unsigned shifts = 0;  ///< entries of the k-buffer that moved
    unsigned hidden = 0;  ///< Event::hidden()
  };
  /// Takes a new hit up to t_max, and moves t_max and the end of the ray.
  Taken take(const Entry& hit, float& t_max, float& end) {
    const bool full = k_buffer_.full();
    Taken taken{rules_.outcome(full, full && hit < k_buffer_.last())};
    if (enters(taken.outcome)) {
      if (full && evicts(taken.outcome)) keep(k_buffer_.last());
      if (full && opacity_.on()) opacity_.subtract(k_buffer_.last().opacity);
      taken.shifts = full ? k_buffer_.replace_last(hit) : k_buffer_.insert(hit);
    } else if (evicts(taken.outcome)) {
      keep(hit);
    }
    const float last = k_buffer_.full() ? k_buffer_.last().t : std::numeric_limits<float>::infinity();
    t_max = rules_.t_max(taken.outcome, t_max, hit.t, last);
    if (opacity_.on() && enters(taken.outcome)) {
      opacity_.add(hit.opacity);
      taken.hidden = hide(end);
      t_max = std::min(t_max, end);
    }
    return taken;
  }

  // For readers of a trace.

  /// As begin_round() with so many hits.
  void begin_round(std::size_t preloaded) {
    std::sort(evictions_.begin(), evictions_.end());
    preload(preloaded);
  }
  /// The same where it is not known which of the evicted hits are nearest: `unknown` makes them anew.
  template <typename Unknown>
  void begin_round(std::size_t preloaded, const Unknown& unknown) {
    for (Entry& hit : evictions_) hit = unknown();
    preload(preloaded);
  }
  static constexpr std::size_t kNowhere = ~std::size_t{0};
  struct Places {
    std::size_t out = kNowhere;  ///< of the entry that was replaced
    std::size_t in = kNowhere;   ///< of the hit
  };
  /// As take(), of a hit with this outcome, which breaks no rule. last: place of the k-buffer's last entry.
  Places take(const Entry& hit, const Taken& recorded, std::size_t last) {
    Places places;
    if (!enters(recorded.outcome)) {
      if (evicts(recorded.outcome)) keep(hit);
      return places;
    }
    if (replaces(recorded.outcome) && k_buffer_.size() != 0) {
      places.out = last;
      const Entry out = k_buffer_.take_out(last);
      if (evicts(recorded.outcome)) keep(out);
    }
    places.in = k_buffer_.place(may_shift(recorded.outcome) ? recorded.shifts : 0);
    k_buffer_.put(places.in, hit);
    k_buffer_.drop_last(recorded.hidden);
    return places;
  }
  /// Makes all entries of the k-buffer anew, as none is known any more.
  template <typename Unknown>
  void forget(const Unknown& unknown) {
    for (Entry& hit : k_buffer_.entries()) hit = unknown();
  }

 private:
  void keep(const Entry& hit) {
    if (rules_.keeps_evictions()) evictions_.push_back(hit);
  }
  void preload(std::size_t count) {
    k_buffer_.clear();
    for (std::size_t i = 0; i < count; ++i) k_buffer_.append_sorted(evictions_[i]);
    evictions_.erase(evictions_.begin(), evictions_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  /// Moves the end to the last entry needed to end the ray, and drops those behind it; returns how many.
  unsigned hide(float& end) {
    if (!opacity_.ends()) return 0;
    unsigned hidden = 0;
    for (; hidden < kMostHidden && opacity_.ends_without(k_buffer_.last().opacity); ++hidden) {
      opacity_.subtract(k_buffer_.last().opacity);
      k_buffer_.drop_last(1);
    }
    end = std::min(end, k_buffer_.last().t);
    return hidden;
  }

  RoundRules rules_;
  KBuffer<Entry> k_buffer_;
  OpacitySum opacity_;
  std::vector<Entry> evictions_;
};

}  // namespace grtx::traces
