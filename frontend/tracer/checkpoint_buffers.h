// SPDX-License-Identifier: Apache-2.0
// A ray leaves these for its next round: two checkpoint buffers, where a round reads the source and writes the
// destination; or bins of distance, where it reads the near ones and may write to all.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/traversal_stack.h"
#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/orders/checkpoint_order.h"
#include "grtx/traces/rules/checkpoint_lists.h"

namespace grtx::frontend {

class CheckpointBuffers {
 public:
  explicit CheckpointBuffers(const TracerOptions& options)
      : enabled_(options.checkpoint),
        order_(options.checkpoint_order),
        lists_(options.checkpoint_order, options.checkpoint ? options.checkpoint_bins : 0,
               options.checkpoint_capacity) {}

  bool enabled() const { return enabled_; }
  bool has_bins() const { return lists_.has_bins(); }
  void begin_ray() {
    lists_.begin_ray();
    bins_.clear();
    reached_ = far_from_ = 0;  // reset even without entries: the trace records how a round reads
  }
  /// Sets the t at which the ray enters the scene, from which bins count distances: no entry has a lower t.
  void measure_from(float t) { scene_enter_ = t; }
  void begin_round(bool replays) {
    overflow_ = false;
    lists_.begin_round(replays, bin_order());
  }
  /// Ends the round, whose entries all lie beyond t_max.
  void end_round(float t_max) { reached_ = number_of(t_max); }

  /// Keeps an entry, which lies beyond t_max, for the next round. False: dropped (checkpointing off, or no room).
  bool write(const StackEntry& entry, float t_max) {
    if (!enabled_ || overflow_) return false;
    if (has_bins()) {
      overflow_ = !write_to_bin(entry, t_max);
    } else {
      overflow_ = lists_.full();
      if (!overflow_) lists_.write(entry);
    }
    return !overflow_;
  }
  bool overflow() const { return overflow_; }  ///< an entry of this round found no room
  /// Entries that the next round may read.
  std::size_t held() const { return lists_.held(); }
  /// Entries of this round, in the order of their writes.
  const std::vector<StackEntry>& written() const { return lists_.written(); }
  /// The bin of each entry that the ray has written.
  const std::vector<std::uint8_t>& bins() const { return bins_; }
  void drop_written() { lists_.drop_written(); }

  // Two buffers.
  /// Begins to read the source.
  void begin_reading() {
    traces::with_checkpoint_order(order_, [this](auto policy) { policy.arrange(lists_.source()); });
  }
  bool more() { return lists_.more(); }
  /// Valid until another is read.
  const StackEntry& read() { return lists_.read(); }

  // Bins.
  /// The order in which the next round reads: no entry lies before the last round's t_max.
  traces::BinOrder bin_order() const {
    if (!has_bins()) return {};
    const std::uint32_t near = lists_.bins().near();
    const std::uint32_t ahead = far_from_ - std::min(far_from_, reached_);
    return {static_cast<std::uint8_t>(reached_ % near), static_cast<std::uint8_t>(std::min(ahead, near))};
  }
  /// Whether the round must read more. Once false it stays false: t_max only falls, and farther bins come later.
  bool must_read(float t_max) {
    if (!lists_.more()) return false;
    const traces::CheckpointBins& places = lists_.bins();
    return (places.next_is_far() ? far_from_ : reached_ + places.near_before()) <= number_of(t_max);
  }

 private:
  /// Near bins begin at t_max. If a bin is full, the entry goes to the one before it, which is merely read sooner.
  bool write_to_bin(const StackEntry& entry, float t_max) {
    const traces::CheckpointBins& places = lists_.bins();
    const std::uint32_t nearest = number_of(t_max), behind = nearest + places.near();
    std::uint32_t number = std::min(number_of(entry.t), behind);
    if (number == behind && !places.full(places.far_bin())) {
      far_from_ = places.empty(places.far_bin()) ? behind : std::min(far_from_, behind);
      write_to(places.far_bin(), entry);
      return true;
    }
    if (number == behind) --number;
    while (places.full(number % places.near())) {
      if (number-- == nearest) return false;
    }
    write_to(number % places.near(), entry);
    return true;
  }
  std::uint32_t number_of(float t) const { return traces::number_of_bin(std::max(t - scene_enter_, 0.0f)); }
  void write_to(unsigned bin, const StackEntry& entry) {
    lists_.write(entry, bin);
    bins_.push_back(static_cast<std::uint8_t>(bin));
  }

  const bool enabled_;
  const CheckpointOrder order_;
  bool overflow_ = false;
  traces::CheckpointLists<StackEntry> lists_;
  float scene_enter_ = 0.0f;
  std::uint32_t reached_ = 0;   ///< bin of the last round's t_max
  std::uint32_t far_from_ = 0;  ///< lower bound on the bin numbers of the far bin's entries
  std::vector<std::uint8_t> bins_;
};

}  // namespace grtx::frontend
