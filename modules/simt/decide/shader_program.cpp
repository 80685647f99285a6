// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/simt/decide/shader_program.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::modules {
namespace {

constexpr unsigned kUnpackPerCoefficient = 3;  // fp16 to fp32, a channel each (assumed: one conversion per instruction)
// With colour = frame. Taken: the frame's number compared, three conversions. Made: 10 of a direction (3 differences, 3
// of their squares, a root's reciprocal, 3 products), three conversions.
constexpr unsigned kTakeColour = 4, kMakeColour = 13;

// The lanes whose loop runs beyond `iteration`.
template <typename Counts>
LaneMask running(LaneMask lanes, const Counts& counts, std::uint32_t iteration) {
  LaneMask still = 0;
  for_each_bit(lanes, [&](unsigned lane) {
    if (counts[lane] > iteration) still |= bit(lane);
  });
  return still;
}

// Most distinct sectors of one warp instruction, when every lane reads a different record.
std::size_t most_sectors(const traces::Header& header) {
  const std::uint64_t bytes =
      std::max({header.gaussian_record_bytes, header.sh_record_bytes, MemoryMap::kPixelBytes, MemoryMap::kShapeBytes});
  return static_cast<std::size_t>(kMaxLanes * (bytes / kSectorBytes + 2));
}

}  // namespace

ShaderProgram::ShaderProgram(const traces::Header& header, const MemoryMap& map, const ShaderCosts& costs, unsigned sm,
                             unsigned resident_warps, const HitHeap& heap)
    : map_(map),
      costs_(costs),
      heap_(heap),
      sm_(sm),
      k_(header.k),
      checkpoint_(header.checkpoint),
      single_(header.tracing == traces::Tracing::single),
      list_(header.tracing == traces::Tracing::list),
      closest_(header.tracing == traces::Tracing::closest),
      boxes_(traces::has_box_leaves(header.accel)),
      sends_end_(header.opacity_bound == traces::OpacityBound::on),
      bounded_(header.opacity_bound == traces::OpacityBound::on && !heap.enabled),
      delayed_(header.any_hit == traces::AnyHit::delayed && !heap.enabled),
      two_level_(header.two_level),
      colour_table_(header.colour == traces::ColourPer::frame),
      sh_instructions_(
          (costs.sh_per_coefficient + (header.layout == traces::NodeLayout::quantised ? kUnpackPerCoefficient : 0)) *
          (header.sh_degree + 1) * (header.sh_degree + 1)),
      gaussian_bytes_(header.gaussian_record_bytes),
      sh_bytes_(header.sh_record_bytes),
      warps_(resident_warps),
      coalescer_(most_sectors(header)) {
  if (header.warp_size == 0 || header.warp_size > kMaxLanes) {
    throw Error("trace header", "warp_size", "must be 1 to " + std::to_string(kMaxLanes) + " for the hardware model");
  }
  if (!heap.enabled) return;
  if (header.tracing != traces::Tracing::multi) {
    throw Error("configuration", "rt.any_hit_unit.enabled", "has heaps of k hits, for traces of tracing multi alone");
  }
  if (boxes_) {
    throw Error("configuration", "rt.any_hit_unit.enabled",
                "takes hits from a unit; those of boxes come from a shader");
  }
  if (header.opacity_bound == traces::OpacityBound::on && !heap.alpha) {
    throw Error(
        "configuration", "rt.any_hit_unit.enabled",
        "needs the alpha of each hit for a trace with opacity_bound on: a Gaussian unit's, on leaves of spheres");
  }
}

void ShaderProgram::find_active(Warp& warp) {
  LaneMask active = 0;
  for (unsigned lane = 0; lane < warp.group->rays.size(); ++lane) {
    if (warp.group->rays[lane].rounds.size() > warp.round) active |= bit(lane);
  }
  warp.active = active;
}

void ShaderProgram::load(Region region, ShaderPhase& phase) {
  coalescer_.begin(region, phase.loads);
  ++counters_.load_instructions;
}

void ShaderProgram::store(Region region, ShaderPhase& phase) {
  coalescer_.begin(region, phase.stores);
  ++counters_.store_instructions;
}

void ShaderProgram::begin(unsigned slot, const traces::RayGroup& group) {
  assert(group.rays.size() <= kMaxLanes);
  Warp& warp = warps_[slot];
  warp.group = &group;
  warp.round = 0;
  warp.sort_pass = warp.batch = 0;
  warp.fill.fill(0);
  warp.evictions.fill(0);
  warp.listed.fill(0);
  warp.first_processed.fill(0);
  if (group.frame != std::exchange(frame_, group.frame)) coloured_.clear();
  find_active(warp);
}

void ShaderProgram::prologue(unsigned, ShaderPhase& phase) { phase.reset(PhaseKind::prologue, costs_.raygen_prologue); }

void ShaderProgram::evict_move(unsigned slot, ShaderPhase& phase) {
  Warp& warp = warps_[slot];
  const std::uint64_t warp_slot = map_.warp_slot(sm_, slot);
  LaneCounts preloaded{};
  LaneCounts remaining{};
  LaneMask moving = 0;  // lanes that rewrite the rest of their eviction buffer
  std::uint32_t most_entries = 0;
  for_each_bit(warp.active, [&](unsigned lane) {
    most_entries = std::max(most_entries, warp.evictions[lane]);
    preloaded[lane] = std::min<std::uint32_t>(round_of(warp, lane).preloaded, k_);
    // trace-check rejects a trace that moves more than was evicted; here the access must only stay inside the buffer.
    remaining[lane] = warp.evictions[lane] - std::min(warp.evictions[lane], preloaded[lane]);
    if (preloaded[lane] > 0) moving |= bit(lane);
  });
  phase.reset(PhaseKind::evict_move,
              costs_.evict_move_fixed + std::uint64_t{costs_.evict_move_per_entry} * most_entries);

  for (std::uint32_t i = 0; i < most_entries; ++i) {
    access_evictions(
        slot, running(warp.active, warp.evictions, i), [i](unsigned) { return i; }, false, phase);
  }
  for (std::uint32_t i = 0;; ++i) {
    const LaneMask lanes = running(warp.active, preloaded, i);
    if (lanes == 0) break;
    access_k_buffer(
        warp_slot, lanes, [i](unsigned) { return i; }, true, phase);
  }
  for (std::uint32_t i = 0;; ++i) {
    const LaneMask lanes = running(moving, remaining, i);
    if (lanes == 0) break;
    access_evictions(
        slot, lanes, [i](unsigned) { return i; }, true, phase);
  }
  for_each_bit(warp.active, [&](unsigned lane) {
    counters_.eviction_moves += preloaded[lane];
    warp.fill[lane] = static_cast<std::int32_t>(preloaded[lane]);
    warp.evictions[lane] = remaining[lane];
  });
}

void ShaderProgram::trace_call(unsigned slot, ShaderPhase& phase) {
  ++counters_.warp_rounds;
  counters_.ray_rounds += static_cast<std::uint64_t>(std::popcount(warps_[slot].active));
  phase.reset(PhaseKind::trace_call, costs_.trace_call + (sends_end_ ? costs_.any_hit_bound : 0));
}

void ShaderProgram::any_hit(const AnyHitBatch& batch, ShaderPhase& phase) {
  Warp& warp = warps_[batch.slot];
  const std::uint64_t warp_slot = map_.warp_slot(sm_, batch.slot);
  ++counters_.any_hit_batches;
  counters_.any_hit_calls += static_cast<std::uint64_t>(std::popcount(batch.lanes));
  if (single_ || list_) return any_hit_single(batch, phase);

  const Insertions hits = insert_hits(warp, batch);
  phase.reset(PhaseKind::any_hit, any_hit_instructions(batch.lanes, hits.most_shifts));
  if (delayed_ && !boxes_) read_list(batch, phase);
  if (bounded_) {
    phase.instructions += hits.most_shifts;  // the third word
    if (hits.entering != 0) {
      phase.instructions += alpha_instructions() + costs_.any_hit_bound * (1 + std::uint64_t{hits.most_hidden});
      load_records(batch, hits.entering, phase);
    }
  }
  for_each_entry(
      warp_slot, batch.lanes, hits.reads, [&](unsigned lane, std::uint32_t i) { return hits.last_read[lane] - i; },
      false, phase, [this](std::uint32_t) { return costs_.dependent_loads; });
  close_steps(phase);
  for_each_entry(
      warp_slot, batch.lanes, hits.writes, [&](unsigned lane, std::uint32_t i) { return hits.last_written[lane] - i; },
      true, phase);
  if (hits.evicting != 0) evict(batch.slot, hits.evicting, phase);
}

void ShaderProgram::load_records(const AnyHitBatch& batch, LaneMask entering, ShaderPhase& phase) {
  load(Region::gaussian, phase);
  for_each_bit(entering,
               [&](unsigned lane) { coalescer_.touch(map_.record_of_hit(batch.leaf[lane]), gaussian_bytes_); });
}

void ShaderProgram::read_list(const AnyHitBatch& batch, ShaderPhase& phase) {
  Warp& warp = warps_[batch.slot];
  const auto next = [&](unsigned lane) { return warp.listed[lane]; };
  access_evictions(batch.slot, batch.lanes, next, true, phase);  // the RT unit's write, charged here
  access_evictions(batch.slot, batch.lanes, next, false, phase);
  for_each_bit(batch.lanes, [&](unsigned lane) { ++warp.listed[lane]; });
}

void ShaderProgram::store_evicted(const AnyHitBatch& batch, ShaderPhase& phase) {
  phase.reset(PhaseKind::any_hit, 0);
  evict(batch.slot, batch.lanes, phase);
}

void ShaderProgram::evict(unsigned slot, LaneMask lanes, ShaderPhase& phase) {
  Warp& warp = warps_[slot];
  access_evictions(
      slot, lanes, [&](unsigned lane) { return warp.evictions[lane]; }, true, phase);
  for_each_bit(lanes, [&](unsigned lane) { ++warp.evictions[lane]; });
  counters_.evictions += static_cast<std::uint64_t>(std::popcount(lanes));
}

// The insertion walks from the last entry to the front. It reads the entries that it moves, the one at which it stops
// and, if the buffer is full, the one that is evicted; it writes the moved ones and the new one. Entries that opacity
// hides were the last ones, whose alpha it holds or has just read.
ShaderProgram::Insertions ShaderProgram::insert_hits(Warp& warp, const AnyHitBatch& batch) const {
  Insertions hits;
  for_each_bit(batch.lanes, [&](unsigned lane) {
    const std::uint32_t fill = filled(warp, lane);
    const std::uint32_t shifts = std::min<std::uint32_t>(batch.shifts[lane], k_);
    const traces::LeafOutcome outcome = batch.outcome[lane];
    assert(traces::calls_any_hit(outcome));
    hits.most_shifts = std::max(hits.most_shifts, shifts);
    hits.last_read[lane] = fill == 0 ? 0 : fill - 1;
    if (outcome == traces::LeafOutcome::inserted || outcome == traces::LeafOutcome::displaced) {
      const std::uint32_t fill_after = std::min(fill + 1, k_);
      const std::uint32_t fallen_out = fill + 1 - fill_after;
      hits.reads[lane] = std::min(shifts + 1 + fallen_out, fill);
      hits.writes[lane] = std::min(shifts + 1, fill_after);
      hits.last_written[lane] = fill_after - 1;
      hits.entering |= bit(lane);
      hits.most_hidden = std::max<std::uint32_t>(hits.most_hidden, batch.hidden[lane]);
      warp.fill[lane] += (outcome == traces::LeafOutcome::inserted ? 1 : 0) - static_cast<int>(batch.hidden[lane]);
    } else {
      hits.reads[lane] = std::min(shifts + 1, fill);
    }
    if (checkpoint_ && traces::evicts(outcome)) hits.evicting |= bit(lane);
  });
  return hits;
}

// Below an instance leaf the RT unit has already transformed the ray; in a monolithic BVH the shader transforms it.
void ShaderProgram::intersection(const AnyHitBatch& batch, ShaderPhase& phase) {
  ++counters_.intersection_batches;
  counters_.intersection_calls += static_cast<std::uint64_t>(std::popcount(batch.lanes));
  phase.reset(PhaseKind::intersection, costs_.call(std::popcount(batch.lanes)) + costs_.intersection_fixed);
  if (delayed_) read_list(batch, phase);
  if (two_level_) return;
  phase.instructions += costs_.intersection_transform;
  load(Region::gaussian, phase);
  for_each_bit(batch.lanes,
               [&](unsigned lane) { coalescer_.touch(map_.shape_record(batch.leaf[lane]), MemoryMap::kShapeBytes); });
}

AnyHitBatch ShaderProgram::hits_of(AnyHitBatch batch) {
  for_each_bit(batch.lanes, [&](unsigned lane) {
    if (!traces::calls_any_hit(batch.outcome[lane])) batch.lanes &= ~bit(lane);
  });
  return batch;
}

// The last step gets all remaining loads and instructions.
void ShaderProgram::close_steps(ShaderPhase& phase) const {
  const auto all = static_cast<std::uint32_t>(phase.loads.size());
  if (!phase.steps.empty() && phase.steps.back() != all) phase.steps.push_back(all);
  if (phase.steps.size() <= 1) return phase.steps.clear();
  phase.step_instructions = std::min<std::uint64_t>(costs_.any_hit_per_shift, phase.instructions / phase.steps.size());
}

void ShaderProgram::node_fetch(const NodeFetchBatch& batch, ShaderPhase& phase) {
  phase.reset(PhaseKind::node_fetch, costs_.node_fetch);
  phase.loads = batch.sectors;
  ++counters_.load_instructions;
}

void ShaderProgram::blend(unsigned slot, ShaderPhase& phase) {
  Warp& warp = warps_[slot];
  const std::uint64_t warp_slot = map_.warp_slot(sm_, slot);
  LaneCounts processed{};
  LaneCounts first{};  // [lane] index of its first sorted entry
  std::uint32_t most_entries = 0;
  const std::uint32_t before = warp.batch * costs_.list_batch;
  for_each_bit(warp.active, [&](unsigned lane) {
    const traces::Round& round = round_of(warp, lane);
    processed[lane] = round.processed_count;
    if (list_) processed[lane] = std::min(processed[lane] - std::min(processed[lane], before), costs_.list_batch);
    if (heap_.enabled) {
      most_entries = std::max(most_entries, processed[lane]);
      counters_.heap_cycles += heap_.drain(processed[lane]);
      return;
    }
    if (!closest_ && before == 0 && warp.fill[lane] != round.k_count) ++counters_.k_buffer_mismatches;
    if (sort_passes(filled(warp, lane)) % 2 != 0) first[lane] = k_;
  });
  phase.reset(PhaseKind::blend, costs_.blend_fixed + (closest_ ? costs_.call(std::popcount(warp.active)) : 0));
  phase.delay = heap_.enabled ? heap_.drain(most_entries) : 0;
  const bool has_alpha = heap_.alpha || bounded_;  // entries bring it

  for (std::uint32_t i = 0;; ++i) {
    const LaneMask lanes = running(warp.active, processed, i);
    if (lanes == 0) break;
    const auto entry = [&](unsigned lane) {
      return warp.group->rays[lane].processed[warp.first_processed[lane] + before + i];
    };
    if (!closest_ && !list_) {  // with closest and list the entry is in registers
      access_k_buffer(
          warp_slot, lanes, [&](unsigned lane) { return first[lane] + i; }, false, phase);
    }
    LaneMask blending = 0;
    if (!has_alpha) load(Region::gaussian, phase);
    for_each_bit(lanes, [&](unsigned lane) {
      const traces::Processed p = entry(lane);
      if (!has_alpha) coalescer_.touch(map_.gaussian_record(p.gaussian), gaussian_bytes_);
      if (p.blended != 0) blending |= bit(lane);
    });
    phase.instructions += has_alpha ? costs_.blend_with_alpha : costs_.blend_per_entry;
    counters_.entries_processed += static_cast<std::uint64_t>(std::popcount(lanes));
    if (blending == 0) continue;  // no lane evaluates the colour
    counters_.entries_blended += static_cast<std::uint64_t>(std::popcount(blending));
    if (colour_table_) {
      LaneCounts gaussian{};
      for_each_bit(blending, [&](unsigned lane) { gaussian[lane] = entry(lane).gaussian; });
      take_colours(warp, blending, gaussian, !has_alpha, phase);
      continue;
    }
    load(Region::sh, phase);
    for_each_bit(blending, [&](unsigned lane) { coalescer_.touch(map_.sh_record(entry(lane).gaussian), sh_bytes_); });
    phase.instructions += sh_instructions_;
  }

  if (list_ && has_batch(warp, warp.batch + 1)) {
    ++warp.batch;
    return;
  }
  end_round(warp);
}

// A colour is read from the SM's table. What is not there the lane makes, and writes.
void ShaderProgram::take_colours(Warp& warp, LaneMask lanes, const LaneCounts& gaussian, bool has_mean,
                                 ShaderPhase& phase) {
  const auto touch_colours = [&](LaneMask of) {
    for_each_bit(of, [&](unsigned lane) { coalescer_.touch(map_.colour(sm_, gaussian[lane]), traces::kColourBytes); });
  };
  LaneMask lacking = 0;
  for_each_bit(lanes, [&](unsigned lane) {
    if (!coloured_.contains(gaussian[lane]) && !warp.making.contains(gaussian[lane])) lacking |= bit(lane);
  });
  load(Region::sh, phase);
  touch_colours(lanes);
  phase.instructions += kTakeColour;
  if (lacking == 0) return;
  if (!has_mean) {
    load(Region::gaussian, phase);
    for_each_bit(lacking,
                 [&](unsigned lane) { coalescer_.touch(map_.gaussian_record(gaussian[lane]), MemoryMap::kMeanBytes); });
  }
  load(Region::sh, phase);
  for_each_bit(lacking, [&](unsigned lane) { coalescer_.touch(map_.sh_record(gaussian[lane]), sh_bytes_); });
  phase.instructions += kMakeColour + sh_instructions_;
  store(Region::sh, phase);
  touch_colours(lacking);
  for_each_bit(lacking, [&](unsigned lane) {
    if (warp.making.insert(gaussian[lane]).second) ++counters_.colours_made;
  });
}

void ShaderProgram::publish_colours(unsigned slot) {
  if (colour_table_) coloured_.merge(std::exchange(warps_[slot].making, {}));
}

void ShaderProgram::end_round(Warp& warp) {
  for_each_bit(warp.active, [&](unsigned lane) {
    const traces::Round& round = round_of(warp, lane);
    warp.first_processed[lane] += round.processed_count;
    warp.fill[lane] = 0;
    warp.evictions[lane] -= std::min(warp.evictions[lane], round.eviction_dropped);
  });
  warp.sort_pass = warp.batch = 0;
  warp.listed.fill(0);
  ++warp.round;
  find_active(warp);
}

void ShaderProgram::epilogue(unsigned slot, ShaderPhase& phase) {
  const Warp& warp = warps_[slot];
  phase.reset(PhaseKind::epilogue, costs_.epilogue);
  if (warp.group->rays.empty()) return;
  store(Region::ray, phase);
  for (const traces::Ray& ray : warp.group->rays) coalescer_.touch(map_.pixel(ray.pixel), MemoryMap::kPixelBytes);
}

}  // namespace grtx::modules
