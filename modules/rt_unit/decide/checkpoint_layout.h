// Where a lane's checkpoint entries lie, which sectors each of them takes to write or to read, and in which order they
// are replayed. Without time: the checkpoint unit sends these sectors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/decide/checkpoint_config.h"
#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::modules {

class CheckpointLayout {
 public:
  static constexpr std::uint64_t kNoSector = ~std::uint64_t{0};

  /// A lane's place in its two buffers, or bins.
  struct Lane {
    std::uint64_t source = 0;        ///< address of source entry 0; of the bins
    std::uint64_t destination = 0;   ///< address of destination entry 0
    std::uint64_t held = kNoSector;  ///< sector in the lane's read buffer
    std::uint32_t source_entries = 0;
    std::uint32_t read = 0;      ///< entries
    std::uint32_t written = 0;   ///< entries, those included that are not appended yet
    std::uint32_t appended = 0;  ///< entries
    bool closed = false;         ///< its open sector has been written: the round is over
    std::size_t ray = 0;         ///< bins: number of the ray's
  };
  /// By number: address / kSectorBytes.
  struct Sectors {
    std::array<std::uint64_t, 2> number{};
    unsigned count = 0;
    bool straddles = false;  ///< the entry lies in two sectors
  };

  /// header: of the trace, whose checkpoint_order, checkpoint_bins and checkpoint_capacity hold. Throws Error when
  /// entries cannot name its nodes, or bins do not go with the configuration.
  CheckpointLayout(const CheckpointConfig& config, const traces::Header& header);

  /// Whether a lane's source_entries must be known when it begins.
  bool needs_source_entries() const { return order_.backwards(); }
  /// Most sectors that an entry sends to be written: without write_combine all that it touches.
  unsigned most_sectors() const {
    if (!charged_) return 0;
    return open_sectors_ > 0 || kSectorBytes % entry_bytes_ == 0 ? 1 : 2;
  }

  /// Round `round` of the ray in warp slot `slot` of SM `sm` begins. It writes one of its two buffers and, if it
  /// replays, reads the other; or it reads and writes its bins, which `ray` names.
  Lane begin(const MemoryMap& map, unsigned sm, unsigned slot, unsigned lane, std::uint32_t round, bool replays,
             std::uint32_t source_entries, const traces::Ray& ray);
  /// The lane has `entries` more entries to write: append() has to be called as often. Throws Error when the buffer is
  /// full.
  void submit(Lane& lane, unsigned entries) const {
    lane.written += entries;
    if (bin_count_ == 0 && lane.written > capacity_) refuse("writes");
  }
  /// The lane's next entry goes to its destination: the sectors that are to be written with it.
  Sectors append(Lane& lane);
  /// Closes a sector that the lane's entries have begun and not completed: it is to be written. kNoSector: there is
  /// none. To be called when the round is over, until there is none.
  std::uint64_t close_sector(Lane& lane);
  /// Whether close_sector() would find one.
  bool has_open_sector(const Lane& lane) const;
  /// The lane's next source entry: the sectors to read for it, in this order. Throws Error when it lies outside.
  Sectors read(Lane& lane);

  /// Throws Error: a ray `does` ("reads", "writes") more entries than its buffer has.
  [[noreturn]] static void refuse(const char* does);

 private:
  /// The bins of a ray, from round to round.
  struct Ray {
    traces::CheckpointBins places;
    const std::uint8_t* next = nullptr;  ///< bin of the entry that is appended next
    const std::uint8_t* end = nullptr;
    std::vector<std::uint64_t> open;  ///< sectors begun and not completed, the one used last in front
  };
  Sectors append_at(std::uint64_t begin) const;
  Sectors append_to_bin(Lane& lane);
  Sectors read_at(Lane& lane, std::uint64_t begin, bool down) const;

  traces::ReadOrder order_;
  std::uint64_t capacity_;
  std::uint64_t entry_bytes_;
  bool charged_;           ///< else no entry has sectors
  unsigned open_sectors_;  ///< of a lane; 0: entries are not combined
  bool read_buffer_;
  unsigned bin_count_;  ///< 0: there are two buffers
  std::uint64_t bin_stride_ = 0;
  std::vector<Ray> rays_;  ///< by warp slot and lane
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
  // The sector that the next entry shares is read last and stays.
  const std::uint64_t shared = down ? first : last;
  const std::uint64_t other = down ? last : first;
  if (sectors.straddles && other != lane.held) sectors.number[sectors.count++] = other;
  if (shared != lane.held) sectors.number[sectors.count++] = shared;
  if (read_buffer_) lane.held = shared;
  return sectors;
}

}  // namespace grtx::modules
