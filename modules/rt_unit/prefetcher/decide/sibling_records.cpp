// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/prefetcher/decide/sibling_records.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "grtx/base/error.h"

namespace grtx::modules {

using traces::NodeDefinition;
using traces::NodeKind;

namespace {

/// The kinds of a node's children, processed in parallel as bytes of one word.
class ChildKinds {
 public:
  explicit ChildKinds(const NodeDefinition& node) {
    static_assert(sizeof(node.child_kinds) == sizeof(bytes_));
    std::memcpy(&bytes_, node.child_kinds.data(), sizeof(bytes_));
  }
  /// Mask of the slots whose child is not an internal node.
  unsigned leaves() const { return ~mask_of(NodeKind::internal) & 0xFF; }
  /// Sum of of_kind[kind] over the first `children` slots; the remaining slots have kind internal.
  std::uint32_t total(const std::array<std::uint32_t, 8>& of_kind, unsigned children) const {
    std::uint32_t sum = 0;
    unsigned internal = children;
    for (const NodeKind kind : {NodeKind::instance, NodeKind::procedural, NodeKind::triangle, NodeKind::wide_instance,
                                NodeKind::wide_procedural}) {
      const auto count = static_cast<unsigned>(std::popcount(mask_of(kind)));
      internal -= count;
      sum += count * of_kind[static_cast<std::size_t>(kind)];
    }
    return sum + internal * of_kind[static_cast<std::size_t>(NodeKind::internal)];
  }

 private:
  // Kinds are below 128: adding 127 to a byte that is not zero sets its highest bit.
  unsigned mask_of(NodeKind kind) const {
    constexpr std::uint64_t kOnes = 0x0101010101010101u;
    const std::uint64_t differs = bytes_ ^ kOnes * static_cast<std::uint64_t>(kind);
    const std::uint64_t equal = ~(differs + kOnes * 127) >> 7 & kOnes;
    return static_cast<unsigned>(equal * 0x0102040810204080u >> 56);
  }
  std::uint64_t bytes_ = 0;
};

}  // namespace

SiblingRecords::SiblingRecords(std::size_t lanes, unsigned records, bool replayed, const NodeTraffic& traffic)
    : a_lane_(records),
      records_(lanes * records),
      newest_(lanes),
      replayed_(replayed),
      shared_from_(traffic.two_level() ? static_cast<std::uint32_t>(traffic.blas_header() / traffic.address(1))
                                       : ~std::uint32_t{0}),
      replayed_of_(lanes),
      ray_of_(lanes) {
  if (records < 1 || records > kMaxRecords)
    throw Error("configuration", "rt.prefetch.records", "must be 1.." + std::to_string(kMaxRecords));
  for (const NodeKind kind : {NodeKind::internal, NodeKind::instance, NodeKind::triangle, NodeKind::procedural,
                              NodeKind::wide_instance, NodeKind::wide_procedural}) {
    units_[static_cast<std::size_t>(kind)] = traffic.stored_units(kind);
  }
}

void SiblingRecords::begin(std::size_t lane, std::size_t ray, bool replays) {
  std::fill_n(&records_[lane * a_lane_], a_lane_, Record{});
  newest_[lane] = 0;
  if (!replayed_) return;
  replayed_of_[lane] = 0;
  ray_of_[lane] = ray;
  if (ray >= checkpointed_.size()) checkpointed_.resize(ray + 1);
  if (!replays) checkpointed_[ray].clear();
}

void SiblingRecords::remember(std::size_t lane, const Record& record) {
  std::uint8_t& newest = newest_[lane];
  newest = newest + 1u == a_lane_ ? std::uint8_t{0} : static_cast<std::uint8_t>(newest + 1);
  records_[lane * a_lane_ + newest] = record;
}

void SiblingRecords::note(std::size_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
                          unsigned checkpointed) {
  if (!replayed_) checkpointed = 0;
  // A single child has no siblings.
  const bool pushed = (hit & (hit - 1)) != 0, written = (checkpointed & (checkpointed - 1)) != 0;
  if (!pushed && !written) return;
  const NodeDefinition& node = group.nodes[definition];
  const ChildKinds kinds(node);
  const std::uint32_t end = node.child_base + kinds.total(units_, node.child_count);
  if (pushed && (kinds.leaves() & hit) != 0) {
    remember(lane, {node.child_base, end, definition, static_cast<std::uint8_t>(hit), true});
  }
  if (written && (kinds.leaves() & checkpointed) != 0 && node.address < shared_from_) {
    checkpointed_[ray_of_[lane]].push_back({node.child_base, end, definition, static_cast<std::uint8_t>(checkpointed)});
  }
}

Siblings SiblingRecords::take(std::size_t lane, const traces::RayGroup& group, std::uint32_t address) {
  Record* const records = &records_[lane * a_lane_];
  std::uint32_t within = 0, armed = 0;
  for (unsigned i = 0; i < a_lane_; ++i) {
    within |= std::uint32_t{address - records[i].begin < records[i].end - records[i].begin} << i;
    armed |= std::uint32_t{records[i].armed} << i;
  }
  if ((within & armed) == 0 && !replayed_) return {};
  // From the newest record to the oldest: from newest_ down, then from the highest index down.
  const std::uint32_t recent = (2u << newest_[lane]) - 1;
  while (within != 0) {
    const std::uint32_t now = (within & recent) != 0 ? within & recent : within;
    const auto i = static_cast<unsigned>(std::bit_width(now)) - 1;
    within &= ~(1u << i);
    Record& record = records[i];
    const unsigned slot = slot_of(group.nodes[record.definition], address);
    if (slot == traces::kMaxWidth || (record.hit >> slot & 1) == 0) continue;  // hit by another visit of the node
    if (!record.armed) return {};
    record.armed = false;
    return {record.definition, record.hit & ~(1u << slot)};
  }
  return replayed_ && replayed_of_[lane] == address ? take_replayed(lane, group, address) : Siblings{};
}

// Prefetches the siblings with which the entry was written. A disarmed record keeps the other siblings from doing so
// again in this round, as long as the record exists.
Siblings SiblingRecords::take_replayed(std::size_t lane, const traces::RayGroup& group, std::uint32_t address) {
  const std::vector<Checkpointed>& visits = checkpointed_[ray_of_[lane]];
  for (auto visit = visits.rbegin(); visit != visits.rend(); ++visit) {
    if (address - visit->begin >= visit->end - visit->begin) continue;
    const unsigned slot = slot_of(group.nodes[visit->definition], address);
    if (slot == traces::kMaxWidth || (visit->mask >> slot & 1) == 0) continue;
    remember(lane, {visit->begin, visit->end, visit->definition, visit->mask, false});
    return {visit->definition, visit->mask & ~(1u << slot), true};
  }
  return {};
}

unsigned SiblingRecords::slot_of(const NodeDefinition& node, std::uint32_t address) const {
  return child_slot(node, address, [this](NodeKind kind) { return units_[static_cast<std::size_t>(kind)]; });
}

}  // namespace grtx::modules
