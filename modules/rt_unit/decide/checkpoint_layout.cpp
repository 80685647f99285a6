#include "grtx/modules/rt_unit/decide/checkpoint_layout.h"

#include <algorithm>
#include <cassert>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/decide/checkpoint_entry.h"

namespace grtx::modules {

CheckpointLayout::CheckpointLayout(const CheckpointConfig& config, const traces::Header& header)
    : order_(header.checkpoint_order),
      logs_entries_(config.forward == CheckpointForward::reference),
      capacity_(header.checkpoint_capacity),
      entry_bytes_(config.entry_bytes),
      charged_(config.traffic == TrafficCharging::charged),
      write_combine_(config.write_combine),
      read_buffer_(config.read_buffer),
      store_entries_(config.store.entries),
      read_ahead_(config.read_ahead),
      prefetch_nodes_(config.prefetch_nodes) {
  assert(config.allows_store() && config.allows_traffic());
  require_entry_fits(config.entry_bytes, header);
  if (logs_entries_ && header.checkpoint_order == traces::CheckpointOrder::nearest) {
    throw Error("configuration", "rt.checkpoint.forward",
                "reference needs a trace with checkpoint order fifo or lifo: what is sorted has no runs");
  }
}

CheckpointLayout::Lane CheckpointLayout::begin(const MemoryMap& map, unsigned sm, unsigned slot, unsigned lane_of_warp,
                                               std::uint32_t round, bool replays, std::uint32_t source_entries) {
  assert(map.checkpoint_entry_bytes() == entry_bytes_ && (map.checkpoint_log_entries() != 0) == logs_entries_);
  const std::uint64_t ray = map.ray_slot(sm, slot, lane_of_warp);
  Lane lane;
  lane.source_entries = source_entries;
  if (!logs_entries_) {
    lane.destination = map.checkpoint_entry(ray, round & 1, 0);
    lane.source = map.checkpoint_entry(ray, (round & 1) ^ 1, 0);
    return lane;
  }
  log_entries_ = map.checkpoint_log_entries();
  lane.source = lane.destination = map.checkpoint_log(ray);
  const std::size_t number = std::size_t{slot} * kMaxLanes + lane_of_warp;
  if (number >= logs_.size()) logs_.resize(number + 1);
  logs_[number].begin(round == 0, replays, capacity_, order_.backwards());
  lane.log = number;
  return lane;
}

// Places count without end, and a log ends on a sector boundary: so do their sectors.
CheckpointLayout::SectorRange CheckpointLayout::sectors_of(std::uint64_t place) const {
  const std::uint64_t begin = place * entry_bytes_;
  return {static_cast<std::int64_t>(begin / kSectorBytes),
          static_cast<std::int64_t>((begin + entry_bytes_ - 1) / kSectorBytes)};
}

CheckpointLayout::Rest CheckpointLayout::rest_of(const Lane& lane) const {
  if (logs_entries_) {
    const CheckpointLog::Unread unread = logs_[lane.log].unread();
    return {unread.place, unread.places, unread.until_run, unread.begun};
  }
  const std::uint64_t places = lane.source_entries > lane.read ? lane.source_entries - lane.read : 0;
  return {order_.backwards() ? places - 1 : lane.read, places, places, lane.read > 0};
}

std::uint64_t CheckpointLayout::next_ahead(Lane& lane) const {
  const Rest rest = rest_of(lane);
  if (rest.places == 0) return kNoSector;
  // Sectors by numbers that grow in the order of reading. An entry is entered in one and left in the same or the next.
  const auto entered = [&](std::uint64_t place) {
    return order_.backwards() ? -sectors_of(place).last : sectors_of(place).first;
  };
  const auto left = [&](std::uint64_t place) {
    return order_.backwards() ? -sectors_of(place).first : sectors_of(place).last;
  };
  const std::uint64_t before = order_.backwards() ? rest.place + 1 : rest.place - 1;
  const std::uint64_t last = order_.backwards() ? rest.place - (rest.places - 1) : rest.place + (rest.places - 1);
  const std::int64_t current = rest.begun ? left(before) : entered(rest.place) - 1;
  lane.ahead = std::max(lane.ahead, current + 1);
  if (lane.ahead > std::min(left(last), current + read_ahead_)) return kNoSector;
  const std::int64_t number = lane.ahead++;
  const auto sector = static_cast<std::uint64_t>(order_.backwards() ? -number : number);
  const std::uint64_t of_log = log_entries_ * entry_bytes_ / kSectorBytes;
  return lane.source / kSectorBytes + (logs_entries_ ? sector % of_log : sector);
}

CheckpointLayout::Entries CheckpointLayout::arrived(Lane& lane, std::uint64_t number) const {
  const Rest rest = rest_of(lane);
  lane.named = std::max(lane.named, lane.read);
  // No sector comes earlier than this before its first entry is read.
  const std::uint64_t most = std::min(rest.until_run, (read_ahead_ + 2) * (kSectorBytes / entry_bytes_ + 1));
  Entries entries{lane.named, 0};
  for (std::uint64_t i = lane.named - lane.read; i < most; ++i) {
    const std::uint64_t begin = address_of(lane, order_.backwards() ? rest.place - i : rest.place + i);
    if (begin / kSectorBytes == number && (begin + entry_bytes_ - 1) / kSectorBytes == number) {
      if (entries.count++ == 0) entries.first = lane.read + static_cast<std::uint32_t>(i);
    } else if (entries.count > 0) {
      break;
    }
  }
  if (entries.count > 0) lane.named = entries.first + entries.count;
  return entries;
}

CheckpointLayout::Sectors CheckpointLayout::read_log(Lane& lane) {
  CheckpointLog& log = logs_[lane.log];
  if (!log.has_more()) refuse("reads");
  const CheckpointLog::Read item = log.read();
  if (!item.run) ++lane.read;
  Sectors sectors = read_at(lane, lane.source + item.position % log_entries_ * entry_bytes_, item.down);
  sectors.run = item.run;
  return sectors;
}

CheckpointLog::Counters CheckpointLayout::runs() const {
  CheckpointLog::Counters all;
  for (const CheckpointLog& log : logs_) log.count(all);
  return all;
}

void CheckpointLayout::refuse(const char* does) {
  throw Error("trace", "checkpoint buffer",
              std::string("a ray ") + does + " more entries than the header's checkpoint_capacity");
}

}  // namespace grtx::modules
