#include "frontend/ray_recorder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

namespace grtx::frontend {

void GroupRecorder::begin_group(std::uint32_t index, traces::RayKind kind, std::size_t rays) {
  group_.index = index;
  group_.kind = kind;
  first_number_ += static_cast<std::uint32_t>(group_.nodes.size());  // frees all slots
  if (first_number_ > 0x80000000u) {
    std::fill(slots_.begin(), slots_.end(), Slot{});
    first_number_ = 1;
  }
  group_.nodes.clear();
  group_.rays.resize(rays);
  for (traces::Ray& ray : group_.rays) {
    ray.rounds.clear();
    ray.events.clear();
    ray.processed.clear();
  }
}

void GroupRecorder::begin_ray(std::size_t lane, std::uint32_t pixel) {
  ray_ = &group_.rays[lane];
  ray_->pixel = pixel;
}

std::uint32_t GroupRecorder::add(Slot& slot, const std::uint8_t* node, std::uint32_t address) {
  const auto index = static_cast<std::uint32_t>(group_.nodes.size());
  slot = {address, first_number_ + index};
  traces::NodeDefinition definition;
  definition.address = address;
  std::int32_t offset = 0;
  std::memcpy(&offset, node + 12, 4);
  definition.child_base = address + static_cast<std::uint32_t>(offset);
  const std::uint8_t* children = node + image_.layout().child_info;
  while (definition.child_count < image_.layout().slots && (children[definition.child_count] & 3u) != 0) {
    definition.child_kinds[definition.child_count] =
        static_cast<traces::NodeKind>(children[definition.child_count] >> 2);
    ++definition.child_count;
  }
  group_.nodes.push_back(definition);
  if (2 * group_.nodes.size() > slots_.size()) grow();
  return index;
}

void GroupRecorder::grow() {
  slots_.assign(2 * slots_.size(), Slot{});
  --shift_;
  first_number_ = 1;
  for (std::uint32_t i = 0; i < group_.nodes.size(); ++i) {
    std::size_t at = place_of(group_.nodes[i].address);
    while (slots_[at].number != 0) at = (at + 1) & (slots_.size() - 1);
    slots_[at] = {group_.nodes[i].address, first_number_ + i};
  }
}

// By the lower half's eleven bits first: a radix sort in three passes.
void GroupRecorder::sort_by_address() {
  constexpr unsigned kBits = 11, kPasses = 3;
  if (order_.size() < 256) return std::sort(order_.begin(), order_.end());
  sorting_.resize(order_.size());
  for (unsigned pass = 0; pass < kPasses; ++pass) {
    const unsigned shift = 32 + kBits * pass;
    std::array<std::uint32_t, (1u << kBits) + 1> starts{};
    for (const std::uint64_t key : order_) ++starts[(key >> shift & ((1u << kBits) - 1)) + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    for (const std::uint64_t key : order_) sorting_[starts[key >> shift & ((1u << kBits) - 1)]++] = key;
    order_.swap(sorting_);
  }
}

const traces::RayGroup& GroupRecorder::end_group() {
  auto& nodes = group_.nodes;
  order_.resize(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) order_[i] = std::uint64_t{nodes[i].address} << 32 | i;
  sort_by_address();
  rank_.resize(nodes.size() + 1);  // never empty
  sorted_.resize(nodes.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) {
    const auto index = static_cast<std::uint32_t>(order_[i]);
    rank_[index] = i;
    sorted_[i] = nodes[index];
  }
  nodes.swap(sorted_);
  for (traces::Ray& ray : group_.rays) {
    for (traces::Event& event : ray.events) {
      const bool internal = event.kind() == traces::EventKind::visit_internal;
      const std::uint32_t rank = rank_[internal ? event.node : 0];
      event.node = internal ? rank : event.node;
    }
  }
  return group_;
}

}  // namespace grtx::frontend
