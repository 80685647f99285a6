#include "frontend/ray_recorder.h"

#include <cstring>

namespace grtx::frontend {

traces::NodeDefinition ImageNodes::define(std::uint32_t address) const {
  const std::uint8_t* node = image_.node(static_cast<std::uint64_t>(address) * traces::kNodeUnit);
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
  return definition;
}

void GroupRecorder::begin_group(std::uint32_t index, traces::RayKind kind) {
  begun_ = false;
  if (header_ != nullptr) encoder_.begin(*header_, index, kind, traces::NodeKind::internal, nodes_);
}

void GroupRecorder::begin_ray(std::uint32_t pixel) {
  encode_ray();
  begun_ = true;
  ray_.pixel = pixel;
  ray_.rounds.clear();
  ray_.events.clear();
  ray_.processed.clear();
}

void GroupRecorder::encode_ray() {
  if (begun_ && header_ != nullptr) encoder_.add(ray_);
  begun_ = false;
}

traces::EncodedGroup GroupRecorder::end_group() {
  encode_ray();
  traces::EncodedGroup group;
  encoder_.finish(group);
  return group;
}

}  // namespace grtx::frontend
