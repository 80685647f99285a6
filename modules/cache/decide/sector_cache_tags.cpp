// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/decide/sector_cache_tags.h"

#include <bit>
#include <cassert>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/wrong_answer.h"

namespace grtx::modules {
namespace {

const SectorCacheTags::Geometry& checked(const SectorCacheTags::Geometry& g) {
  const auto require = [&](bool holds, const std::string& rule) {
    if (!holds) throw Error("configuration", "cache geometry", rule);
  };
  require(std::has_single_bit(g.line_bytes), "line size must be a power of two, is " + std::to_string(g.line_bytes));
  require(g.sector_bytes > 0 && std::has_single_bit(g.sector_bytes) && g.line_bytes % g.sector_bytes == 0,
          "sector size must be a power of two that divides the line size, is " + std::to_string(g.sector_bytes));
  require(g.sectors() <= 8, "a line has at most 8 sectors, not " + std::to_string(g.sectors()));
  require(g.ways < 0xFFFF, "ways must be below 65535, not " + std::to_string(g.ways));
  require(g.ways >= 1 && g.sets() >= 1,
          std::to_string(g.bytes) + " bytes hold no set of " + std::to_string(g.ways) + " ways");
  return g;
}

}  // namespace

SectorCacheTags::SectorCacheTags(const Geometry& geometry)
    : geometry_(checked(geometry)),
      large_(geometry.ways > kSmallWays),
      set_count_(geometry.sets()),
      small_(large_ ? 0 : set_count_),
      lines_(large_ ? set_count_ * geometry.ways : 0),
      sets_(large_ ? set_count_ : 0),
      index_(large_ ? lines_.size() : 1),
      line_shift_(static_cast<unsigned>(std::countr_zero(geometry.line_bytes))),
      sector_shift_(static_cast<unsigned>(std::countr_zero(geometry.sector_bytes))),
      way_shift_(std::has_single_bit(geometry.ways) ? static_cast<unsigned>(std::countr_zero(geometry.ways)) : 0),
      set_mask_(std::has_single_bit(set_count_) ? set_count_ - 1 : 0),
      policy_(make_cache_replacement(geometry.replacement, set_count_, geometry.ways)),
      filled_(policy_ != nullptr ? set_count_ : 0) {
  for (SmallSet& set : small_) {
    for (unsigned way = 0; way < kSmallWays; ++way) set.number[way] = kNoLine;
    for (unsigned way = 0; way < geometry_.ways; ++way) set.order |= std::uint64_t{way} << 4 * way;
  }
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    for (unsigned way = 0; way < geometry_.ways; ++way) {
      Line& line = lines_[set * geometry_.ways + way];
      line.newer = way == 0 ? kNoWay : static_cast<Way>(way - 1);
      line.older = way + 1 == geometry_.ways ? kNoWay : static_cast<Way>(way + 1);
    }
    sets_[set] = {0, static_cast<Way>(geometry_.ways - 1)};
  }
}

SectorCacheTags::Victim SectorCacheTags::preload(std::uint64_t address, const MemoryRequest& access) {
  Victim gone;
  Slot slot = find(address);
  if (slot == kNone) {
    slot = victim(address, access).dirty == 0 ? victim_slot(address, access) : clean_victim(address, access);
    if (slot == kNone) return gone;
    slot = insert_at(slot, address, access, &gone);
  }
  set_valid(slot, sector_bit(address));
  touch(slot, [&] { return access; });
  return gone;
}

void SectorCacheTags::restart(bool keep_lines) {
  if (!keep_lines) {
    *this = SectorCacheTags(Geometry(geometry_));
    return;
  }
  for (SmallSet& set : small_) {
    for (State& s : set.state) s.unused_prefetch = 0;
  }
  for (Line& line : lines_) line.state.unused_prefetch = 0;
}

// The ways of a set, most recently used first.
std::vector<unsigned> SectorCacheTags::newest_first(std::uint64_t set) const {
  std::vector<unsigned> ways;
  if (large_) {
    const Line* lines = &lines_[set * geometry_.ways];
    for (Way way = sets_[set].newest; way != kNoWay; way = lines[way].older) ways.push_back(way);
  } else {
    for (unsigned i = 0; i < geometry_.ways; ++i) ways.push_back(small_[set].order >> 4 * i & 0xF);
  }
  return ways;
}

void SectorCacheTags::order(std::uint64_t set, const std::vector<unsigned>& newest_first) {
  if (!large_) {
    small_[set].order = 0;
    for (std::size_t i = 0; i < newest_first.size(); ++i) small_[set].order |= std::uint64_t{newest_first[i]} << 4 * i;
    return;
  }
  Line* lines = &lines_[set * geometry_.ways];
  const auto way_at = [&](std::size_t i) {
    return i < newest_first.size() ? static_cast<Way>(newest_first[i]) : kNoWay;  // also for i = -1
  };
  for (std::size_t i = 0; i < newest_first.size(); ++i) {
    lines[newest_first[i]].newer = way_at(i - 1);
    lines[newest_first[i]].older = way_at(i + 1);
  }
  sets_[set] = {way_at(0), way_at(newest_first.size() - 1)};
}

void SectorCacheTags::save(StateWriter& out) const {
  for (std::uint64_t set = 0; set < set_count_; ++set) {
    for (unsigned way = 0; way < geometry_.ways; ++way) {
      const auto slot = static_cast<Slot>(set * stride() + way);
      out.put(number(slot));
      if (number(slot) == kNoLine) continue;
      out.put(state(slot).valid);
      out.put(state(slot).dirty);
    }
    if (policy_ != nullptr) continue;
    for (const unsigned way : newest_first(set)) out.put(static_cast<Way>(way));
  }
  if (policy_ != nullptr && !policy_->save(out)) {
    throw Error("state", "replacement " + geometry_.replacement, "does not say what it keeps");
  }
}

void SectorCacheTags::load(StateReader& in) {
  assert(lines_valid_ == 0);
  for (std::uint64_t set = 0; set < set_count_; ++set) {
    for (unsigned way = 0; way < geometry_.ways; ++way) {
      const auto slot = static_cast<Slot>(set * stride() + way);
      const auto line = in.get<std::uint32_t>();
      if (line == kNoLine) continue;
      in.require(set_of(line) == set && find(std::uint64_t{line} << line_shift_) == kNone,
                 "a line is in a wrong place");
      number(slot) = line;
      if (large_) index_.insert(line, slot);
      state(slot).valid = in.get<std::uint8_t>();
      state(slot).dirty = in.get<std::uint8_t>();
      ++lines_valid_;
      if (policy_ == nullptr) continue;
      in.require(filled_[set] == way, "a line is in a wrong place");
      ++filled_[set];
    }
    if (policy_ != nullptr) continue;
    std::vector<unsigned> ways;
    std::vector<bool> taken(geometry_.ways);
    for (unsigned i = 0; i < geometry_.ways; ++i) {
      ways.push_back(in.get(static_cast<Way>(geometry_.ways - 1)));
      in.require(!taken[ways.back()], "a way is twice in its set's order");
      taken[ways.back()] = true;
    }
    order(set, ways);
  }
  if (policy_ != nullptr) policy_->load(in);
}

SectorCacheTags::Victim SectorCacheTags::victim_in(Slot slot) const {
  const std::uint32_t line = number(slot);
  if (line == kNoLine) return {};
  const State& s = state(slot);
  return {true, std::uint64_t{line} << line_shift_, s.dirty, s.unused_prefetch};
}

SectorCacheTags::Slot SectorCacheTags::chosen_by_policy(std::uint64_t address, const MemoryRequest& access) const {
  const std::uint64_t set = set_of(line_number(address));
  const unsigned way = filled_[set] < geometry_.ways ? filled_[set] : policy_->victim(set, access);
  if (way >= geometry_.ways) {
    throw WrongAnswer("the cache replacement " + geometry_.replacement + " chose way " + std::to_string(way) + " of " +
                      std::to_string(geometry_.ways));
  }
  return static_cast<Slot>(set * stride() + way);
}

[[gnu::noinline]] SectorCacheTags::Slot SectorCacheTags::clean_victim(std::uint64_t address,
                                                                      const MemoryRequest& access) const {
  const std::uint64_t set = set_of(line_number(address));
  const auto first = static_cast<Slot>(set * stride());
  const auto clean = [&](unsigned way) { return state(first + way).dirty == 0; };
  const unsigned ways = geometry_.ways;
  if (policy_ != nullptr) {
    const unsigned victim = way_number(replaced_by(address, access));
    for (unsigned i = 0; i < ways; ++i) {
      if (const unsigned way = (victim + i) % ways; clean(way)) return first + way;
    }
  } else if (large_) {
    for (Way way = sets_[set].oldest; way != kNoWay; way = lines_[first + way].newer) {
      if (clean(way)) return first + way;
    }
  } else {
    for (unsigned i = ways; i > 0; --i) {
      if (const unsigned way = small_[set].order >> 4 * (i - 1) & 0xF; clean(way)) return first + way;
    }
  }
  return kNone;
}

// insert_at() and touch_large() are noinline: inlined into the flattened tick() of the caches they cost more than the
// call.
[[gnu::noinline]] SectorCacheTags::Slot SectorCacheTags::insert_at(Slot slot, std::uint64_t address,
                                                                   const MemoryRequest& access, Victim* evicted) {
  *evicted = victim_in(slot);
  std::uint32_t& line = number(slot);
  if (line == kNoLine) {
    ++lines_valid_;
  } else if (large_) {
    index_.erase(line);
  }
  assert(line_number(address) < kNoLine);
  line = static_cast<std::uint32_t>(line_number(address));
  state(slot) = {};
  if (large_) index_.insert(line, slot);
  if (policy_ == nullptr) {
    touch_lru(slot);
    return slot;
  }
  unsigned& filled = filled_[set_number(slot)];
  if (filled < geometry_.ways) ++filled;
  policy_->filled(set_number(slot), way_number(slot), access);
  return slot;
}

[[gnu::noinline]] void SectorCacheTags::touch_large(Slot slot) {
  Line& line = lines_[slot];
  const std::size_t number = way_shift_ != 0 ? slot >> way_shift_ : slot / geometry_.ways;
  Set& set = sets_[number];
  Line* ways = &lines_[number * geometry_.ways];
  ways[line.newer].older = line.older;
  if (line.older != kNoWay) {
    ways[line.older].newer = line.newer;
  } else {
    set.oldest = line.newer;
  }
  const Way way = static_cast<Way>(&line - ways);
  line.newer = kNoWay;
  line.older = set.newest;
  ways[set.newest].newer = way;
  set.newest = way;
}

std::uint64_t SectorCacheTags::count_unused_prefetch() const {
  std::uint64_t count = 0;
  for_each_state([&](const State& s) { count += static_cast<std::uint64_t>(std::popcount(s.unused_prefetch)); });
  return count;
}

std::uint64_t SectorCacheTags::count_dirty() const {
  std::uint64_t count = 0;
  for_each_state([&](const State& s) { count += static_cast<std::uint64_t>(std::popcount(s.dirty)); });
  return count;
}

std::uint64_t SectorCacheTags::tag_bits(unsigned address_bits, bool with_dirty) const {
  const unsigned offset_bits = static_cast<unsigned>(std::countr_zero(geometry_.line_bytes));
  const unsigned set_bits = static_cast<unsigned>(std::bit_width(set_count_) - 1);
  // lru: the position in the recency order.
  const unsigned order_bits =
      policy_ != nullptr ? policy_->bits_per_line() : static_cast<unsigned>(std::bit_width(geometry_.ways - 1));
  const unsigned per_line =
      address_bits - offset_bits - set_bits + 1 + geometry_.sectors() * (with_dirty ? 2 : 1) + order_bits;
  return std::uint64_t{per_line} * set_count_ * geometry_.ways;
}

}  // namespace grtx::modules
