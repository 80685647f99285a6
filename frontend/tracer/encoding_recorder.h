// SPDX-License-Identifier: Apache-2.0
// Encodes a ray while it is traced: the tracer knows which child of which node it pops, so no event is stored, and no
// stack is rebuilt from events. Gives the same bytes as GroupRecorder.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/traces/encode/encoded_group.h"
#include "grtx/traces/encode/pop_encoder.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/orders/checkpoint_order.h"
#include "grtx/traces/rules/checkpoint_lists.h"

namespace grtx::frontend {

/// One per thread. Not for checkpoint buffers that are read nearest first, because the format's names for their entries
/// depend on later events. The tracer must make the hardware's visits: TracerOptions::walk_blas must be true.
class EncodingRecorder {
 public:
  static constexpr bool kEnabled = true;
  static constexpr bool kDepthFirst = true;

  /// The children that a visited node pushes, from the last to be popped to the first to be popped.
  class Children {
   public:
    /// Written without branches, which would be unpredictable.
    void put(unsigned slot, unsigned pushed) {
      // Each slot is in the order, so a bit is set; std::countr_zero() would also handle 0.
      const auto expected = static_cast<unsigned>(__builtin_ctzll(order_ & traces::NodeModel::bits_of(slot)));
      *end_ = {node_, slot};
      end_ += pushed;
      differ_ |= pushed & static_cast<unsigned>(expected > last_);
      last_ = pushed != 0 ? expected : last_;
    }

   private:
    friend class EncodingRecorder;
    Children(traces::ChildPlace* end, std::uint32_t node, std::uint64_t order)
        : end_(end), node_(node), order_(order) {}

    traces::ChildPlace* end_;
    std::uint32_t node_;   ///< index into the group's model
    std::uint64_t order_;  ///< expected (NodeModel::order)
    unsigned last_ = 64;   ///< place in this order of the child put last
    unsigned differ_ = 0;  ///< 1: the actual order differs
  };

  /// The header must outlive the recorder.
  EncodingRecorder(const NodeImage& image, const traces::Header& header);
  /// Whether it can record for this header.
  static bool can_record(const traces::Header& header) { return traces::ReadOrder(header.checkpoint_order).by_place(); }

  void begin_group(std::uint32_t index, traces::RayKind kind);
  /// Rays begin in lane order.
  void begin_ray(std::uint32_t pixel);
  /// The group for Writer::append().
  traces::EncodedGroup end_group();

  void bins(const std::vector<std::uint8_t>& of_ray) { bins_ = &of_ray; }
  void begin_round(bool replay, traces::BinOrder order = {});
  /// Pops the top of the stack, which the next event is about (unless that is a replay event).
  void pop() {
    at_ = stack_[--depth_];
    if (room_-- == 0) make_room();
  }
  Children open(std::uint32_t address) {
    if (depth_ + traces::kMaxWidth > stack_.size()) stack_.resize(2 * stack_.size());
    const std::uint32_t node = out_.reach(at_, address);
    return {stack_.data() + depth_, node, out_.order(node)};
  }
  void internal(const Children& children, std::uint32_t /*address*/, unsigned pushed, unsigned checkpoints) {
    out_.internal(at_, children.node_, pushed, checkpoints);
    if ((children.differ_ & learns_) != 0) out_.pop_all({stack_.data() + depth_, children.end_});
    depth_ = static_cast<std::size_t>(children.end_ - stack_.data());
    for (; checkpoints != 0; checkpoints &= checkpoints - 1) {
      write({children.node_, static_cast<unsigned>(std::countr_zero(checkpoints))});
    }
  }
  [[gnu::always_inline]] void event(traces::EventKind kind, std::uint32_t address, unsigned detail,
                                    unsigned checkpoints, unsigned shifts = 0) {
    using traces::EventKind;
    switch (kind) {
      case EventKind::visit_leaf:
        out_.leaf(at_, static_cast<traces::LeafOutcome>(detail), checkpoints, shifts);
        if (checkpoints != 0 && static_cast<traces::LeafOutcome>(detail) == traces::LeafOutcome::beyond) write(at_);
        break;
      case EventKind::cull:
        out_.cull(at_, checkpoints);
        if (checkpoints != 0) write(at_);
        break;
      case EventKind::visit_instance:
        if (detail != 0) return out_.instance_of_taken();
        out_.instance(at_);
        push({out_.model().levels().root_below(address), 0});
        break;
      case EventKind::replay_take:
        read_source();
        out_.take();
        push(at_);
        break;
      case EventKind::replay_forward:
        read_source();
        out_.forward(checkpoints);
        if (checkpoints != 0) write(at_);
        break;
      case EventKind::visit_internal:
        assert(false);  // internal() records these
        break;
    }
  }
  void processed(std::uint32_t gaussian, bool blended) { processed_.push_back(processed_entry(gaussian, blended)); }
  void end_round(const traces::Round& round);

 private:
  static constexpr std::size_t kRoom = 4096;

  void push(traces::ChildPlace place) {
    if (depth_ == stack_.size()) stack_.resize(2 * stack_.size());
    stack_[depth_++] = place;
  }
  void write(traces::ChildPlace place) {
    if (!checkpoints_.has_bins()) return checkpoints_.write(place);
    const unsigned bin = (*bins_)[written_++];
    out_.bin(bin);
    checkpoints_.write(place, bin);
  }
  /// An entry of a checkpoint buffer is read without siblings: it keeps no expected order.
  void read_source() {
    const traces::ChildPlace entry = checkpoints_.read();
    at_ = {entry.parent(), entry.slot()};
    if (room_-- == 0) make_room();
  }
  void make_room();
  void end_ray();

  ImageNodes nodes_;  ///< outlives each group
  const traces::Header& header_;
  const unsigned learns_;  ///< 1: the order of children does not follow from their slots: it is learnt
  bool begun_ = false;     ///< a ray has begun and not ended
  std::uint32_t pixel_ = 0;
  std::size_t rounds_ = 0;
  traces::ChildPlace at_;  ///< the place popped or read last
  std::size_t room_ = 0;   ///< pops and reads that the encoder has room for
  std::vector<traces::ChildPlace> stack_ = std::vector<traces::ChildPlace>(512);
  std::size_t depth_ = 0;
  traces::CheckpointLists<traces::ChildPlace> checkpoints_;
  const std::vector<std::uint8_t>* bins_ = nullptr;  ///< of the ray's entries
  std::size_t written_ = 0;                          ///< entries that the ray has written
  std::vector<traces::Processed> processed_;
  traces::PopEncoder out_;
};

}  // namespace grtx::frontend
