// Where a lane's checkpoint entries lie, which sectors each of them takes to write or to read, in which order they are
// replayed, and which of those that are forwarded are written again. Without time: the checkpoint unit sends these
// sectors, fast mode reserves for them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/decide/checkpoint_config.h"
#include "grtx/modules/rt_unit/decide/checkpoint_log.h"
#include "grtx/traces/header.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::modules {

class CheckpointLayout {
 public:
  static constexpr std::uint64_t kNoSector = ~std::uint64_t{0};

  /// A lane's place in its two buffers.
  struct Lane {
    std::uint64_t source = 0;        ///< address of source entry 0; forward = reference: of the log
    std::uint64_t destination = 0;   ///< address of destination entry 0; forward = reference: of the log
    std::uint64_t held = kNoSector;  ///< sector in the lane's read buffer
    std::uint32_t source_entries = 0;
    std::uint32_t read = 0;      ///< entries
    std::uint32_t written = 0;   ///< entries, those included that a run entry names
    std::uint32_t appended = 0;  ///< items
    std::uint32_t named = 0;     ///< entries before it have come, or been read; read_ahead or prefetch_nodes
    std::int64_t ahead = std::numeric_limits<std::int64_t>::min();  ///< next sector to be read ahead, at the earliest
    std::size_t log = 0;                                            ///< forward = reference: number of the ray's
  };
  /// By number: address / kSectorBytes.
  struct Sectors {
    std::array<std::uint64_t, 2> number{};
    unsigned count = 0;
    bool straddles = false;  ///< the entry lies in two sectors
    bool run = false;        ///< a run entry; when reading, the entry itself is still to be read
    bool stored = false;     ///< the entry lies in the store, not in memory
  };

  /// header: of the trace, whose checkpoint_order and checkpoint_capacity hold. Throws Error when entries cannot name
  /// its nodes, or cannot be forwarded as asked.
  CheckpointLayout(const CheckpointConfig& config, const traces::Header& header);

  /// Whether a lane's source_entries must be known when it begins.
  bool needs_source_entries() const {
    return (order_.backwards() || read_ahead_ > 0 || prefetch_nodes_) && !logs_entries_;
  }
  bool reads_ahead() const { return read_ahead_ > 0; }
  bool names_nodes() const { return prefetch_nodes_; }
  /// Whether the lane's next item goes to the store.
  bool next_is_stored(const Lane& lane) const { return lane.appended < store_entries_; }
  /// Most sectors that an item sends to be written: without write_combine all that it touches.
  unsigned most_sectors() const {
    if (!charged_) return 0;
    return write_combine_ || kSectorBytes % entry_bytes_ == 0 ? 1 : 2;
  }

  /// Round `round` of the ray in warp slot `slot` of SM `sm` begins: it writes one of its buffers and, if it replays,
  /// reads the other.
  Lane begin(const MemoryMap& map, unsigned sm, unsigned slot, unsigned lane, std::uint32_t round, bool replays,
             std::uint32_t source_entries);
  /// The lane has `entries` more entries for its destination. forwarded: it is one, which it has read last. last: it
  /// has no further event in the round. Returns how many items append() has to be called for. Throws Error when the
  /// buffer is full.
  unsigned submit(Lane& lane, unsigned entries, bool forwarded, bool last);
  /// The lane's next item goes to its destination: the sectors that are complete with it.
  Sectors append(Lane& lane);
  /// The sector that the lane's last item has begun and not completed; kNoSector: none.
  std::uint64_t open_sector(const Lane& lane) const;
  /// The lane's next source entry: the sectors to read for it, in this order. Sectors::run: it is known when these are
  /// there, by the next call. Throws Error when it lies outside.
  Sectors read(Lane& lane);

  /// The next sector of the lane's source list that is to be read ahead; kNoSector: none for now. The list is read
  /// read_ahead sectors ahead of that in which the entry lies that was read last.
  std::uint64_t next_ahead(Lane& lane) const;
  /// Entries by their number in the order of reading.
  struct Entries {
    std::uint32_t first = 0, count = 0;
  };
  /// Sector `number` of the lane's source has come: which entries lie in it as a whole, that have not been read and
  /// have not come before. Up to the next run entry, and none while a run is read.
  Entries arrived(Lane& lane, std::uint64_t number) const;

  /// Throws Error: a ray `does` ("reads", "writes") more entries than its buffer has.
  [[noreturn]] static void refuse(const char* does);

  /// Runs of all rays so far; the lists that nobody has read are among what is left.
  CheckpointLog::Counters runs() const;

 private:
  Sectors append_at(std::uint64_t begin) const;
  Sectors read_at(Lane& lane, std::uint64_t begin, bool down) const;
  Sectors read_log(Lane& lane);
  /// The unread rest of the lane's source list: its next place, which way it goes on, and how far.
  struct Rest {
    std::uint64_t place = 0;
    std::uint64_t places = 0;
    std::uint64_t until_run = 0;  ///< places before the next run entry, 0 while a run is read
    bool begun = false;           ///< something of the list has been read
  };
  Rest rest_of(const Lane& lane) const;
  struct SectorRange {
    std::int64_t first = 0, last = 0;
  };
  SectorRange sectors_of(std::uint64_t place) const;
  std::uint64_t address_of(const Lane& lane, std::uint64_t place) const {
    return lane.source + (logs_entries_ ? place % log_entries_ : place) * entry_bytes_;
  }

  traces::ReadOrder order_;
  bool logs_entries_;  ///< forward = reference
  std::uint64_t capacity_;
  std::uint64_t entry_bytes_;
  bool charged_;  ///< else no entry has sectors
  bool write_combine_, read_buffer_;
  std::uint32_t store_entries_;  ///< of a buffer; 0 with a log
  unsigned read_ahead_;
  bool prefetch_nodes_;
  std::uint64_t log_entries_ = 0;    ///< places of a log
  std::vector<CheckpointLog> logs_;  ///< by warp slot and lane
};

inline unsigned CheckpointLayout::submit(Lane& lane, unsigned entries, bool forwarded, bool last) {
  lane.written += entries;
  if (lane.written > capacity_) refuse("writes");
  return logs_entries_ ? logs_[lane.log].submit(entries, forwarded, last) : entries;
}

inline CheckpointLayout::Sectors CheckpointLayout::append_at(std::uint64_t begin) const {
  if (!charged_) return {};
  const std::uint64_t end = begin + entry_bytes_;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t last = (end - 1) / kSectorBytes;
  Sectors sectors;
  sectors.straddles = first != last;
  if (!write_combine_ || sectors.straddles || end % kSectorBytes == 0) sectors.number[sectors.count++] = first;
  if (!write_combine_ && sectors.straddles) sectors.number[sectors.count++] = last;
  return sectors;
}

inline CheckpointLayout::Sectors CheckpointLayout::append(Lane& lane) {
  if (next_is_stored(lane)) {
    ++lane.appended;
    return {.stored = true};
  }
  if (!logs_entries_) return append_at(lane.destination + lane.appended++ * entry_bytes_);
  ++lane.appended;
  const CheckpointLog::Appended item = logs_[lane.log].append();
  Sectors sectors = append_at(lane.destination + item.position % log_entries_ * entry_bytes_);
  sectors.run = item.run;
  return sectors;
}

inline std::uint64_t CheckpointLayout::open_sector(const Lane& lane) const {
  if (!charged_ || !write_combine_ || lane.appended <= store_entries_) return kNoSector;
  const std::uint64_t places = logs_entries_ ? (logs_[lane.log].appended() - 1) % log_entries_ + 1 : lane.appended;
  const std::uint64_t end = lane.destination + places * entry_bytes_;
  return end % kSectorBytes != 0 ? end / kSectorBytes : kNoSector;
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

inline CheckpointLayout::Sectors CheckpointLayout::read(Lane& lane) {
  if (logs_entries_) return read_log(lane);
  const std::uint64_t index = order_.position(lane.read, lane.source_entries);
  if (index >= capacity_) refuse("reads");
  ++lane.read;
  if (index < store_entries_) return {.stored = true};
  return read_at(lane, lane.source + index * entry_bytes_, order_.backwards());
}

}  // namespace grtx::modules
