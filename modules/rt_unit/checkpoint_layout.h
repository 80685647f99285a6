// Where a lane's checkpoint entries lie, which sectors each of them takes to write or to read, and in which order they
// are replayed. Without time: the checkpoint unit sends these sectors, fast mode reserves for them.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/modes.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::modules {

class CheckpointLayout {
 public:
  static constexpr std::uint64_t kNoSector = ~std::uint64_t{0};

  /// A lane's place in its two buffers.
  struct Lane {
    std::uint64_t source = 0;        ///< address of source entry 0
    std::uint64_t destination = 0;   ///< address of destination entry 0
    std::uint64_t held = kNoSector;  ///< sector in the lane's read buffer
    std::uint32_t source_entries = 0;
    std::uint32_t read = 0;     ///< entries
    std::uint32_t written = 0;  ///< entries
  };
  /// By number: address / kSectorBytes.
  struct Sectors {
    std::array<std::uint64_t, 2> number{};
    unsigned count = 0;
    bool straddles = false;  ///< the entry lies in two sectors
  };

  /// order: the trace's checkpoint_order. capacity: entries of a buffer. write_combine: a lane's entries gather in its
  /// open sector; else each writes every sector it touches. read_buffer: a lane keeps the last sector it read.
  CheckpointLayout(traces::CheckpointOrder order, std::uint64_t capacity, bool write_combine, bool read_buffer)
      : order_(order), capacity_(capacity), write_combine_(write_combine), read_buffer_(read_buffer) {}

  /// Whether a lane's source_entries must be known when it begins.
  bool reads_backwards() const { return order_.backwards(); }
  /// Most sectors that an entry completes.
  unsigned most_sectors() const { return write_combine_ ? 1 : 2; }

  /// Round `round` of the ray in `ray_slot` begins: it writes one of its buffers and reads the other.
  Lane begin(const MemoryMap& map, std::uint64_t ray_slot, std::uint32_t round, std::uint32_t source_entries) const;
  /// The lane's next entry goes to its destination: the sectors that are complete with it. Throws Error when the buffer
  /// is full.
  Sectors write(Lane& lane) const;
  /// The sector that the lane's last entry has begun and not completed; kNoSector: none.
  std::uint64_t open_sector(const Lane& lane) const;
  /// The lane's next source entry: the sectors to read for it, in this order. Throws Error when it lies outside.
  Sectors read(Lane& lane) const;

 private:
  [[noreturn]] static void refuse(const char* does);

  traces::ReadOrder order_;
  std::uint64_t capacity_;
  bool write_combine_, read_buffer_;
};

inline CheckpointLayout::Sectors CheckpointLayout::write(Lane& lane) const {
  if (lane.written >= capacity_) refuse("writes");
  const std::uint64_t begin = lane.destination + lane.written * traces::kCheckpointEntryBytes;
  const std::uint64_t end = begin + traces::kCheckpointEntryBytes;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t last = (end - 1) / kSectorBytes;
  ++lane.written;
  Sectors sectors;
  sectors.straddles = first != last;
  if (!write_combine_ || sectors.straddles || end % kSectorBytes == 0) sectors.number[sectors.count++] = first;
  if (!write_combine_ && sectors.straddles) sectors.number[sectors.count++] = last;
  return sectors;
}

inline std::uint64_t CheckpointLayout::open_sector(const Lane& lane) const {
  const std::uint64_t end = lane.destination + lane.written * traces::kCheckpointEntryBytes;
  return write_combine_ && lane.written > 0 && end % kSectorBytes != 0 ? end / kSectorBytes : kNoSector;
}

inline CheckpointLayout::Sectors CheckpointLayout::read(Lane& lane) const {
  const std::uint64_t index = order_.position(lane.read, lane.source_entries);
  if (index >= capacity_) refuse("reads");
  ++lane.read;
  const std::uint64_t begin = lane.source + index * traces::kCheckpointEntryBytes;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t last = (begin + traces::kCheckpointEntryBytes - 1) / kSectorBytes;
  Sectors sectors;
  sectors.straddles = first != last;
  // The sector that the next entry shares is read last and stays.
  const std::uint64_t shared = order_.backwards() ? first : last;
  const std::uint64_t other = order_.backwards() ? last : first;
  if (sectors.straddles && other != lane.held) sectors.number[sectors.count++] = other;
  if (shared != lane.held) sectors.number[sectors.count++] = shared;
  if (read_buffer_) lane.held = shared;
  return sectors;
}

}  // namespace grtx::modules
