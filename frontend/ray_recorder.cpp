#include "frontend/ray_recorder.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace grtx::frontend {

void GroupRecorder::begin_group(std::uint32_t index, traces::RayKind kind, std::size_t rays) {
  group_.index = index;
  group_.kind = kind;
  group_.nodes.clear();
  group_.rays.resize(rays);
  for (traces::Ray& ray : group_.rays) {
    ray.rounds.clear();
    ray.events.clear();
    ray.processed.clear();
  }
  ++stamp_;
}

void GroupRecorder::begin_ray(std::size_t lane, std::uint32_t pixel) {
  ray_ = &group_.rays[lane];
  ray_->pixel = pixel;
}

std::uint32_t GroupRecorder::add(Slot& slot, const std::uint8_t* node, std::uint32_t address) {
  const auto index = static_cast<std::uint32_t>(group_.nodes.size());
  slot = {address, index, stamp_};
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
  stamp_ = 1;
  for (std::uint32_t i = 0; i < group_.nodes.size(); ++i) {
    std::size_t at = (group_.nodes[i].address * 0x9E3779B1u) >> shift_;
    while (slots_[at].stamp == stamp_) at = (at + 1) & (slots_.size() - 1);
    slots_[at] = {group_.nodes[i].address, i, stamp_};
  }
}

const traces::RayGroup& GroupRecorder::end_group() {
  auto& nodes = group_.nodes;
  order_.resize(nodes.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::sort(order_.begin(), order_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return nodes[a].address < nodes[b].address; });
  rank_.resize(nodes.size());
  sorted_.resize(nodes.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) {
    rank_[order_[i]] = i;
    sorted_[i] = nodes[order_[i]];
  }
  nodes.swap(sorted_);
  for (traces::Ray& ray : group_.rays) {
    for (traces::Event& event : ray.events) {
      if (event.kind() == traces::EventKind::visit_internal) event.node = rank_[event.node];
    }
  }
  return group_;
}

}  // namespace grtx::frontend
