// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_layout.h"

#include <algorithm>
#include <cassert>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_entry.h"

namespace grtx::modules {

CheckpointLayout::CheckpointLayout(const CheckpointConfig& config, const traces::Header& header)
    : order_(header.checkpoint_order),
      capacity_(header.checkpoint_capacity),
      entry_bytes_(config.entry_bytes),
      charged_(config.traffic == TrafficCharging::charged),
      open_sectors_(config.write_combine ? config.open_sectors : 0),
      read_buffer_(config.read_buffer),
      bin_count_(header.checkpoint_bins) {
  require_entry_fits(config.entry_bytes, header);
  if (bin_count_ == 0) return;
  if (config.entry_bytes != 8) {
    throw Error("configuration", "rt.checkpoint.entry_bytes",
                "must be 8 for a trace with checkpoint bins, whose entries end with their sector");
  }
}

CheckpointLayout::Lane CheckpointLayout::begin(const MemoryMap& map, unsigned sm, unsigned slot, unsigned lane_of_warp,
                                               std::uint32_t round, bool replays, std::uint32_t source_entries,
                                               const traces::Ray& ray) {
  assert(map.checkpoint_entry_bytes() == entry_bytes_);
  const std::uint64_t at = map.ray_slot(sm, slot, lane_of_warp);
  Lane lane;
  lane.source_entries = source_entries;
  if (bin_count_ == 0) {
    lane.destination = map.checkpoint_entry(at, round & 1, 0);
    lane.source = map.checkpoint_entry(at, (round & 1) ^ 1, 0);
    return lane;
  }
  lane.source = map.checkpoint_bin(at, 0);
  bin_stride_ = map.checkpoint_bin(at, 1) - lane.source;
  lane.ray = std::size_t{slot} * kMaxLanes + lane_of_warp;
  if (lane.ray >= rays_.size())
    rays_.resize(lane.ray + 1, {traces::CheckpointBins(bin_count_, capacity_), nullptr, nullptr, {}});
  Ray& of = rays_[lane.ray];
  if (round == 0) {
    of.next = ray.bins.data();
    of.end = of.next + ray.bins.size();
  }
  assert(of.open.empty());
  of.places.begin_round(replays, ray.rounds[round].bins);
  return lane;
}

// The entry that ends at a sector boundary completes the sector. If no open sector is free, the least recently used one
// is written.
CheckpointLayout::Sectors CheckpointLayout::append_to_bin(Lane& lane) {
  Ray& ray = rays_[lane.ray];
  if (ray.next == ray.end || *ray.next >= ray.places.count() || ray.places.full(*ray.next)) refuse("writes");
  const traces::BinPlace place = ray.places.write(*ray.next++);
  ++lane.appended;
  if (!charged_) return {};
  const std::uint64_t end = lane.source + place.bin * bin_stride_ + (place.position + 1) * entry_bytes_;
  const std::uint64_t sector = (end - 1) / kSectorBytes;
  Sectors sectors;
  const auto open = std::find(ray.open.begin(), ray.open.end(), sector);
  if (open_sectors_ == 0 || end % kSectorBytes == 0) {
    if (open != ray.open.end()) ray.open.erase(open);
    sectors.number[sectors.count++] = sector;
    return sectors;
  }
  if (open != ray.open.end()) {
    std::rotate(ray.open.begin(), open, open + 1);
    return sectors;
  }
  if (ray.open.size() == open_sectors_) {
    sectors.number[sectors.count++] = ray.open.back();
    ray.open.pop_back();
  }
  ray.open.insert(ray.open.begin(), sector);
  return sectors;
}

bool CheckpointLayout::has_open_sector(const Lane& lane) const {
  if (!charged_ || open_sectors_ == 0) return false;
  if (bin_count_ != 0) return !rays_[lane.ray].open.empty();
  return !lane.closed && lane.appended > 0 && (lane.destination + lane.appended * entry_bytes_) % kSectorBytes != 0;
}

std::uint64_t CheckpointLayout::close_sector(Lane& lane) {
  if (!has_open_sector(lane)) return kNoSector;
  if (bin_count_ == 0) {
    lane.closed = true;
    return (lane.destination + lane.appended * entry_bytes_) / kSectorBytes;
  }
  std::vector<std::uint64_t>& open = rays_[lane.ray].open;
  const std::uint64_t sector = open.back();
  open.pop_back();
  return sector;
}

CheckpointLayout::Sectors CheckpointLayout::read(Lane& lane) {
  if (bin_count_ != 0) {
    traces::CheckpointBins& places = rays_[lane.ray].places;
    if (!places.more()) refuse("reads");
    const traces::BinPlace place = places.read();
    ++lane.read;
    return read_at(lane, lane.source + place.bin * bin_stride_ + place.position * entry_bytes_, false);
  }
  const std::uint64_t index = order_.position(lane.read, lane.source_entries);
  if (index >= capacity_) refuse("reads");
  ++lane.read;
  return read_at(lane, lane.source + index * entry_bytes_, order_.backwards());
}

void CheckpointLayout::refuse(const char* does) {
  throw Error("trace", "checkpoint buffer",
              std::string("a ray ") + does + " more entries than the header's checkpoint_capacity");
}

}  // namespace grtx::modules
