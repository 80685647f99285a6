// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/ray_recorder.h"

#include <bit>
#include <cstring>
#include <span>

namespace grtx::frontend {

traces::NodeDefinition ImageNodes::define(std::uint32_t address) const {
  const std::uint8_t* node = image_.node_at(address);
  traces::NodeDefinition definition;
  definition.address = address;
  std::int32_t offset = 0;
  std::memcpy(&offset, node + 12, 4);
  definition.child_base = address + static_cast<std::uint32_t>(offset);
  // Eight child bytes at once: a child's low two bits are not zero, its kind stands above them.
  const std::uint64_t children = child_bytes(image_.layout(), node);
  constexpr std::uint64_t kOnes = 0x0101010101010101;
  const std::uint64_t used = (children | children >> 1) & kOnes;
  const unsigned end = static_cast<unsigned>(std::countr_one(used | ~kOnes)) / 8;  // used slots come first
  const std::uint64_t kinds = (children >> 2 & 0x3F * kOnes) & (end < 8 ? (std::uint64_t{1} << 8 * end) - 1 : ~0ull);
  static_assert(sizeof definition.child_kinds == sizeof kinds);
  std::memcpy(definition.child_kinds.data(), &kinds, sizeof kinds);
  definition.child_count = static_cast<std::uint8_t>(end);
  return definition;
}

void GroupRecorder::begin_group(std::uint32_t index, traces::RayKind kind) {
  begun_ = false;
  if (header_ != nullptr) encoder_.begin(*header_, index, kind, traces::NodeKind::internal, nodes_);
}

void GroupRecorder::begin_ray(std::uint32_t pixel) {
  encode_ray();
  begun_ = true;
  pixel_ = pixel;
  bins_ = nullptr;
  rounds_.clear();
  events_ = 0;
  processed_.clear();
}

void GroupRecorder::encode_ray() {
  if (begun_ && header_ != nullptr) {
    const std::span<const std::uint8_t> bins = bins_ != nullptr ? std::span(*bins_) : std::span<const std::uint8_t>();
    encoder_.add({pixel_, rounds_, {store_.data(), events_}, processed_, bins});
  }
  begun_ = false;
}

void GroupRecorder::grow() { store_.resize(2 * store_.size()); }

traces::EncodedGroup GroupRecorder::end_group() {
  encode_ray();
  traces::EncodedGroup group;
  encoder_.finish(group);
  return group;
}

}  // namespace grtx::frontend
