// SPDX-License-Identifier: Apache-2.0
// Addresses of a lane's checkpoint entries, the sectors that each one writes or reads, and the order of replay.
// Untimed: the checkpoint unit sends these sectors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_config.h"
#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::modules {

class CheckpointLayout {
 public:
  static constexpr std::uint64_t kNoSector = ~std::uint64_t{0};

  /// A lane's position in its two buffers, or in its bins.
  struct Lane {
    std::uint64_t source = 0;        ///< address of source entry 0, or of bin 0
    std::uint64_t destination = 0;   ///< address of destination entry 0; unused with bins
    std::uint64_t held = kNoSector;  ///< sector in the lane's read buffer
    std::uint32_t source_entries = 0;
    std::uint32_t read = 0;      ///< entries
    std::uint32_t written = 0;   ///< entries submitted
    std::uint32_t appended = 0;  ///< entries appended, at most `written`
    bool closed = false;         ///< the open sector has been written at the end of the round
    std::size_t ray = 0;         ///< with bins: index in rays_
  };
  /// Sector numbers: address / kSectorBytes.
  struct Sectors {
    std::array<std::uint64_t, 2> number{};
    unsigned count = 0;
    bool straddles = false;  ///< the entry spans two sectors
  };

  /// header: of the trace; checkpoint_order, checkpoint_bins and checkpoint_capacity are used. Throws Error if entries
  /// cannot name its nodes, or if bins are used with entries that are not 8 B.
  CheckpointLayout(const CheckpointConfig& config, const traces::Header& header);

  /// Whether begin() needs the lane's number of source entries.
  bool needs_source_entries() const { return order_.backwards(); }
  /// Most sectors that an entry causes to be written: one with write_combine, else all that it touches.
  unsigned most_sectors() const {
    if (!charged_) return 0;
    return open_sectors_ > 0 || kSectorBytes % entry_bytes_ == 0 ? 1 : 2;
  }

  /// Begins round `round` of the ray in warp slot `slot` of SM `sm`. The round writes one of the ray's two buffers and,
  /// if it replays, reads the other; or it reads and writes the bins given in `ray`.
  Lane begin(const MemoryMap& map, unsigned sm, unsigned slot, unsigned lane, std::uint32_t round, bool replays,
             std::uint32_t source_entries, const traces::Ray& ray);
  /// Adds `entries` entries to write; append() must be called once for each. Throws Error if the buffer overflows.
  void submit(Lane& lane, unsigned entries) const {
    lane.written += entries;
    if (bin_count_ == 0 && lane.written > capacity_) refuse("writes");
  }
  /// Appends the lane's next entry. Returns the sectors to write because of it.
  Sectors append(Lane& lane);
  /// Closes one partly filled sector and returns its number, to be written; kNoSector if there is none. Call at the end
  /// of a round until there is none.
  std::uint64_t close_sector(Lane& lane);
  /// Whether close_sector() would return a sector.
  bool has_open_sector(const Lane& lane) const;
  /// Moves to the lane's next source entry. Returns the sectors to read for it, in this order. Throws Error if there is
  /// no further entry.
  Sectors read(Lane& lane);

  /// Throws Error: a ray reads or writes more entries than its buffer has. does: "reads" or "writes".
  [[noreturn]] static void refuse(const char* does);

 private:
  /// State of a ray's bins, kept across rounds.
  struct Ray {
    traces::CheckpointBins places;
    const std::uint8_t* next = nullptr;  ///< bin of the next entry to append
    const std::uint8_t* end = nullptr;
    std::vector<std::uint64_t> open;  ///< partly filled sectors, most recently used first
  };
  Sectors append_at(std::uint64_t begin) const;
  Sectors append_to_bin(Lane& lane);
  Sectors read_at(Lane& lane, std::uint64_t begin, bool down) const;

  traces::ReadOrder order_;
  std::uint64_t capacity_;
  std::uint64_t entry_bytes_;
  bool charged_;           ///< false: entries cause no traffic
  unsigned open_sectors_;  ///< per lane; 0: entries are not combined
  bool read_buffer_;
  unsigned bin_count_;  ///< 0: two buffers instead of bins
  std::uint64_t bin_stride_ = 0;
  std::vector<Ray> rays_;  ///< [warp slot * kMaxLanes + lane], with bins
};

inline CheckpointLayout::Sectors CheckpointLayout::append_at(std::uint64_t begin) const {
  if (!charged_) return {};
  const std::uint64_t end = begin + entry_bytes_;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t last = (end - 1) / kSectorBytes;
  Sectors sectors;
  sectors.straddles = first != last;
  const bool combines = open_sectors_ > 0;
  if (!combines || sectors.straddles || end % kSectorBytes == 0) sectors.number[sectors.count++] = first;
  if (!combines && sectors.straddles) sectors.number[sectors.count++] = last;
  return sectors;
}

inline CheckpointLayout::Sectors CheckpointLayout::append(Lane& lane) {
  if (bin_count_ != 0) return append_to_bin(lane);
  return append_at(lane.destination + lane.appended++ * entry_bytes_);
}

inline CheckpointLayout::Sectors CheckpointLayout::read_at(Lane& lane, std::uint64_t begin, bool down) const {
  if (!charged_) return {};
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t last = (begin + entry_bytes_ - 1) / kSectorBytes;
  Sectors sectors;
  sectors.straddles = first != last;
  // The sector shared with the next entry is read last, so that it stays in the read buffer.
  const std::uint64_t shared = down ? first : last;
  const std::uint64_t other = down ? last : first;
  if (sectors.straddles && other != lane.held) sectors.number[sectors.count++] = other;
  if (shared != lane.held) sectors.number[sectors.count++] = shared;
  if (read_buffer_) lane.held = shared;
  return sectors;
}

}  // namespace grtx::modules
