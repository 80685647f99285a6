// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/encoding_recorder.h"

#include "grtx/traces/orders/child_order.h"

namespace grtx::frontend {

EncodingRecorder::EncodingRecorder(const NodeImage& image, const traces::Header& header)
    : nodes_(image),
      header_(header),
      learns_(traces::with_child_order(header.child_order, [](auto policy) { return policy.kBySlots; }) ? 0 : 1),
      checkpoints_(header) {}

void EncodingRecorder::begin_group(std::uint32_t index, traces::RayKind kind) {
  begun_ = false;
  out_.begin(header_, index, kind, traces::NodeKind::internal, nodes_);
}

void EncodingRecorder::begin_ray(std::uint32_t pixel) {
  end_ray();
  begun_ = true;
  pixel_ = pixel;
  rounds_ = 0;
  room_ = 0;
  processed_.clear();
  checkpoints_.begin_ray();
  written_ = 0;
  out_.begin_ray();
}

void EncodingRecorder::end_ray() {
  if (begun_) out_.end_ray(pixel_, rounds_, processed_);
  begun_ = false;
}

traces::EncodedGroup EncodingRecorder::end_group() {
  end_ray();
  traces::EncodedGroup group;
  out_.finish(group);
  return group;
}

void EncodingRecorder::begin_round(bool replay, traces::BinOrder order) {
  out_.begin_round();
  checkpoints_.begin_round(replay, order);
  if (checkpoints_.has_bins() && replay) {
    out_.reserve(1);
    out_.bin_order(order);
  }
  depth_ = 0;
  if (!replay) push({traces::GroupModel::kRootParent, 0});
}

void EncodingRecorder::end_round(const traces::Round& round) {
  ++rounds_;
  if (checkpoints_.has_bins() && checkpoints_.more()) {
    out_.reserve(1);
    out_.stop();
  }
  out_.end_round(round);
}

void EncodingRecorder::make_room() {
  out_.reserve(kRoom);
  room_ = kRoom - 1;  // less the one in progress
}

}  // namespace grtx::frontend
