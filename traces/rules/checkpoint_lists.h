// SPDX-License-Identifier: Apache-2.0
// The checkpoint entries of a ray: the source, which its round reads, and the destination, which the round writes for
// the next one; with bins of distance those in place of both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/header.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::traces {

template <typename Entry>
class CheckpointLists {
 public:
  /// near: number of near bins; 0: two lists. capacity: of a list, or of a bin.
  CheckpointLists(CheckpointOrder order, unsigned near, std::uint64_t capacity)
      : has_bins_(near != 0), capacity_(capacity), order_(order), binned_(near, capacity) {}
  CheckpointLists() : CheckpointLists(CheckpointOrder::fifo, 0, 0) {}
  explicit CheckpointLists(const Header& header)
      : CheckpointLists(header.checkpoint_order, header.checkpoint_bins, header.checkpoint_capacity) {}

  bool has_bins() const { return has_bins_; }
  const CheckpointBins& bins() const { return binned_.places(); }
  /// Without bins: the entries to read, all of them, as they were written.
  const std::vector<Entry>& source() const { return source_; }
  std::vector<Entry>& source() { return source_; }
  /// The entries written in this round.
  const std::vector<Entry>& written() const { return written_; }
  /// Entries left for the next round.
  std::size_t held() const { return has_bins_ ? binned_.places().size() : written_.size(); }

  void begin_ray() {
    source_.clear();
    written_.clear();
  }
  /// replays: the round reads what is there, with bins in this order; else that is dropped.
  void begin_round(bool replays, const BinOrder& order) {
    source_.clear();
    if (replays) source_.swap(written_);
    written_.clear();
    read_ = 0;
    if (has_bins_) binned_.begin_round(replays, order);
  }
  /// An overflow drops what the round has written.
  void drop_written() { written_.clear(); }

  /// Whether an entry for this bin (without bins: any entry) finds no room.
  bool full(unsigned bin = 0) const { return has_bins_ ? binned_.places().full(bin) : written_.size() >= capacity_; }
  void write(const Entry& entry, unsigned bin = 0) {
    if (has_bins_) binned_.write(bin, entry);
    written_.push_back(entry);
  }
  bool more() { return has_bins_ ? binned_.more() : read_ < source_.size(); }
  /// Number of entries read in this round.
  std::size_t reads() const { return read_; }
  /// Without bins: place in the source of the next entry, if the order of places is the order of reads.
  std::size_t next_place() const { return order_.position(read_, source_.size()); }
  /// The next entry, valid until another is read. Requires more().
  const Entry& read() { return read_from(next_place()); }
  /// The same, where the order of reads does not follow from places (ReadOrder::by_place()).
  const Entry& read_from(std::size_t place) {
    ++read_;
    if (!has_bins_) return source_[place];
    binned_.more();  // goes on to the bin of the next entry
    from_bin_ = binned_.read();
    return from_bin_;
  }
  const ReadOrder& order() const { return order_; }

 private:
  bool has_bins_;
  std::uint64_t capacity_;
  ReadOrder order_;
  std::vector<Entry> source_, written_;
  BinnedEntries<Entry> binned_;
  Entry from_bin_{};  ///< read last: its place may be written to
  std::size_t read_ = 0;
};

}  // namespace grtx::traces
