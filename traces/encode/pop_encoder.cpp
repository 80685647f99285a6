// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/encode/pop_encoder.h"

#include <algorithm>

#include "grtx/base/hash.h"
#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/codec/predicted_pops.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::traces {

void PopEncoder::begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root,
                       const NodeSource& nodes) {
  header_ = &header;
  place_ = GroupPlace{};
  place_.group = index;
  kind_ = kind;
  root_ = root;
  nearest_ = !ReadOrder(header.checkpoint_order).by_place();
  bins_ = header.checkpoint_bins != 0;
  hides_ = header.opacity_bound == OpacityBound::on;
  reached_ = false;
  last_pixel_ = 0;
  rays_ = 0;
  events_ = 0;
  totals_ = Totals{};
  columns_.clear();
  inner_run_ = leaf_run_ = 0;
  dictionary_.begin(nodes);
  processed_.clear();
  place_.require(index < header.groups, "the index must be below the header's groups");
  place_.require(kind <= RayKind::mirror, "the ray kind must be known");
  model_.begin(header, root);
}

void PopEncoder::begin_ray() {
  place_.lane = rays_++;
  place_.require(rays_ <= header_->warp_size, "a group holds at most warp_size rays");
  in_eviction_buffer_ = 0;
  for (Symbols& symbols : symbols_) symbols.end = symbols.bytes.data();
}

// A varint takes at most 10 bytes, one of 12 bits at most 2.
void PopEncoder::reserve(std::size_t pops) {
  for (const Column column : {Column::hits, Column::checkpoints, Column::replay_op}) columns_.reserve(column, pops + 1);
  columns_.reserve(Column::shifts, (hides_ ? 4 : 2) * pops);
  if (nearest_) columns_.reserve(Column::replay_entry, 10 * pops);
  if (bins_) columns_.reserve(Column::bin, kMaxWidth * pops);
  for (Symbols& symbols : symbols_) {
    const auto used = static_cast<std::size_t>(symbols.end - symbols.bytes.data());
    if (symbols.bytes.size() - used >= pops) continue;
    symbols.bytes.resize(2 * (used + pops));
    symbols.end = symbols.bytes.data() + used;
  }
}

void PopEncoder::end_round(const Round& round) {
  events_ += counts_.internal + counts_.instances + counts_.culls + counts_.read;
  for (const std::uint64_t leaves : counts_.leaves) events_ += leaves;
  place_.require(events_ <= kMaxPops, "a group has at most 2^30 events");
  columns_.reserve(Column::round_flags, 1);
  columns_.put(Column::round_flags, (round.replay ? kRoundReplay : 0) | (round.overflow ? kRoundOverflow : 0) |
                                        (round.terminated ? kRoundTerminated : 0));
  const auto put = [&](Column column, std::uint64_t value) {
    columns_.reserve(column, 10);
    columns_.put_varint(column, value);
  };
  put(Column::preloaded, round.preloaded);
  put(Column::k_count, round.k_count);
  put(Column::processed_count, zigzag(static_cast<std::int64_t>(round.k_count) - round.processed_count));
  if (round.overflow) put(Column::eviction_dropped, round.eviction_dropped);
  count_round(*header_, round, counts_, in_eviction_buffer_, totals_);
}

void PopEncoder::end_ray(std::uint32_t pixel, std::size_t rounds, std::span<const Processed> processed) {
  columns_.reserve(Column::ray, 20);
  columns_.put_varint(Column::ray, zigzag(static_cast<std::int64_t>(pixel) - last_pixel_));
  columns_.put_varint(Column::ray, rounds);
  last_pixel_ = pixel;
  put_pops(Column::inner_gap, Column::inner, symbols_[kInner], inner_run_);
  put_pops(Column::leaf_gap, Column::leaf, symbols_[kLeaves], leaf_run_);
  ++totals_.rays;
  totals_.processed += processed.size();
  for (const Processed& entry : processed) totals_.blended += entry.blended;
  processed_.add(processed);
  place_.lane = GroupPlace::kNowhere;
}

// A separate loop, so that its state fits in registers.
void PopEncoder::put_pops(Column gaps, Column symbols, Symbols& pops, unsigned& run) {
  const std::uint8_t* const begin = pops.bytes.data();
  const auto count = static_cast<std::size_t>(pops.end - begin);
  columns_.reserve(gaps, count + 2);
  columns_.reserve(symbols, count + 2);
  PopColumns out{columns_.end(gaps), columns_.end(symbols), run};
  for (std::size_t i = 0; i < count; ++i) out.put(begin[i]);
  columns_.end(gaps) = out.gap;
  columns_.end(symbols) = out.symbols;
  run = out.run;
}

std::uint32_t PopEncoder::reach_first(ChildPlace at, std::uint32_t address) {
  reached_ = true;
  place_.require(model_.size() < ChildPlace::kMaxNodes, "a group visits fewer than 2^25 distinct internal nodes");
  return dictionary_.reach(at.parent(), at.slot(), address);
}

void PopEncoder::pop_all(std::span<ChildPlace> stack) {
  unsigned remaining = 0;
  for (const ChildPlace place : stack) remaining |= 1U << place.slot();
  for (std::size_t i = stack.size(); i-- > 0;) {
    const unsigned slot = stack[i].slot();
    stack[i] = pop(stack[i].parent(), remaining, slot);
    remaining ^= 1U << slot;
  }
}

void PopEncoder::end_gap(Column column, unsigned run) {
  columns_.reserve(column, 1);
  if (run > 0) columns_.put(column, run);
}

void PopEncoder::finish(EncodedGroup& group) {
  const unsigned flags = dictionary_.put(columns_);
  const std::size_t gaussians = processed_.put(columns_);
  end_gap(Column::inner_gap, inner_run_);
  end_gap(Column::leaf_gap, leaf_run_);
  columns_.reserve(Column::group, 64);
  columns_.put_varint(Column::group, place_.group);
  columns_.put(Column::group, static_cast<unsigned>(kind_));
  columns_.put(Column::group, static_cast<unsigned>(root_));
  columns_.put_varint(Column::group, dictionary_.size());
  columns_.put_varint(Column::group, rays_);
  columns_.put(Column::group, flags);
  columns_.put_varint(Column::group, gaussians);
  if (columns_.bytes() > kMaxGroupBytes) place_.fail("takes more than 1 GiB before compression");
  std::array<ColumnView, kColumnCount> views;
  for (std::size_t i = 0; i < kColumnCount; ++i) views[i] = columns_.view(static_cast<Column>(i));
  group.index = place_.group;
  group.totals = totals_;
  group.chunk.assign(kChunkPreambleBytes, 0);
  pack_columns(std::span(views).first(bins_ ? kColumnCount : kColumnsWithoutBins), group.chunk);
  const std::size_t payload = group.chunk.size() - kChunkPreambleBytes;
  Bytes preamble;
  put_u32(preamble, static_cast<std::uint32_t>(payload));
  put_u64(preamble, xxh3(group.chunk.data() + kChunkPreambleBytes, payload));
  std::copy(preamble.begin(), preamble.end(), group.chunk.begin());
}

}  // namespace grtx::traces
