// SPDX-License-Identifier: Apache-2.0
// Lines of a plain sectored cache with their replacement: docs/model/l1_cache.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rtl_tlm/plain/messages.h"

namespace grtx::sim::plain {

class CacheLines {
 public:
  struct Sector {
    bool valid = false, dirty = false;
    bool prefetched = false;  ///< and no demand access has come to it
  };
  struct Line {
    bool used = false;
    std::uint64_t address = 0;  ///< of its first byte
    std::uint64_t last_use = 0;
    Region writer = Region::tlas;  ///< who wrote it last
    std::vector<Sector> sectors;
  };
  struct Geometry {
    std::uint64_t bytes;
    unsigned line_bytes, ways;
    std::string replacement;
  };
  explicit CacheLines(const Geometry& g) : geometry_(g) {
    sets_.resize(g.bytes / (std::uint64_t{g.line_bytes} * g.ways));
    random_victim_.resize(sets_.size());
    first_placed_.resize(sets_.size());
    for (auto& set : sets_)
      set.assign(g.ways, Line{false, 0, 0, Region::tlas, std::vector<Sector>(g.line_bytes / kSector)});
  }

  /// The line of the address, nullptr when it is absent.
  Line* line(std::uint64_t address) {
    for (Line& line : set(address)) {
      if (line.used && line.address == base(address)) return &line;
    }
    return nullptr;
  }
  /// The sector, nullptr when it is absent.
  Sector* sector(std::uint64_t address) {
    Line* found = line(address);
    if (found == nullptr) return nullptr;
    Sector& sector = at(*found, address);
    return sector.valid ? &sector : nullptr;
  }
  Sector& at(Line& line, std::uint64_t address) { return line.sectors[(address - line.address) / kSector]; }
  /// An access has come to the address: its line, if it is there, was used, even where the sector is absent.
  void use(std::uint64_t address) {
    if (Line* found = line(address)) found->last_use = ++clock_;
  }
  std::vector<std::uint64_t> dirty_sectors(const Line& line) const {
    std::vector<std::uint64_t> all;
    for (std::size_t i = 0; i < line.sectors.size(); ++i) {
      if (line.used && line.sectors[i].dirty) all.push_back(line.address + i * kSector);
    }
    return all;
  }
  /// Where the line of the address would go: a free place, else the line that is to leave.
  Line& place(std::uint64_t address) {
    for (Line& line : set(address)) {
      if (!line.used) return line;
    }
    return *leaves_first(address, [](const Line&) { return true; });
  }
  /// The line of a full set that is to leave where dirty ones cannot; nullptr when all are dirty.
  Line* clean_place(std::uint64_t address) {
    return leaves_first(address, [this](const Line& line) { return dirty_sectors(line).empty(); });
  }
  void put(Line& line, std::uint64_t address) {
    line.used = true;
    line.address = base(address);
    line.last_use = ++clock_;
    first_placed_[set_of(address)] = static_cast<std::size_t>(&line - set(address).data() + 1) % geometry_.ways;
    line.sectors.assign(line.sectors.size(), {});
    random_ = random_ * 6364136223846793005U + 1442695040888963407U;
    random_victim_[set_of(address)] = (random_ >> 33) % geometry_.ways;
  }
  template <typename F>
  void for_each_sector(F&& f) const {
    for (const auto& set : sets_) {
      for (const Line& line : set) {
        for (const Sector& sector : line.sectors) {
          if (line.used && sector.valid) f(sector);
        }
      }
    }
  }

 private:
  std::uint64_t base(std::uint64_t address) const { return address / geometry_.line_bytes * geometry_.line_bytes; }
  std::uint64_t set_of(std::uint64_t address) const { return address / geometry_.line_bytes % sets_.size(); }
  std::vector<Line>& set(std::uint64_t address) { return sets_[set_of(address)]; }
  /// The line whose turn it is by the policy, among those that may leave.
  template <typename MayLeave>
  Line* leaves_first(std::uint64_t address, MayLeave&& may_leave) {
    std::vector<Line>& lines = set(address);
    if (geometry_.replacement == "lru") {
      Line* oldest = nullptr;
      for (Line& line : lines) {
        if (may_leave(line) && (oldest == nullptr || line.last_use < oldest->last_use)) oldest = &line;
      }
      return oldest;
    }
    const bool fifo = geometry_.replacement == "fifo";
    const std::size_t first = fifo ? first_placed_[set_of(address)] : random_victim_[set_of(address)];
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (Line& line = lines[(first + i) % lines.size()]; may_leave(line)) return &line;
    }
    return nullptr;
  }

  Geometry geometry_;
  std::vector<std::vector<Line>> sets_;
  std::uint64_t clock_ = 0;
  std::uint64_t random_ = 1;                  ///< state of the generator of `random`
  std::vector<std::uint64_t> random_victim_;  ///< by set: the way that goes next
  std::vector<std::size_t> first_placed_;     ///< by set: the way behind that which was filled last
};

}  // namespace grtx::sim::plain
