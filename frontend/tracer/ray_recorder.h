// SPDX-License-Identifier: Apache-2.0
// Turns the actions of a ray into trace events. NullRecorder records nothing and costs nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/frontend/accel/node_image.h"
#include "grtx/traces/encode/group_encoder.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/node_source.h"

namespace grtx::frontend {

/// Trace entry of a hit that a ray's shader has processed when blending.
inline traces::Processed processed_entry(std::uint32_t gaussian, bool blended) {
  traces::Processed entry;
  entry.gaussian = gaussian & 0x7FFFFFFFu;
  entry.blended = blended ? 1u : 0u;
  return entry;
}

class NullRecorder {
 public:
  static constexpr bool kEnabled = false;
  static constexpr bool kDepthFirst = false;  ///< whether it needs a round's events depth first, as traces have them
  /// The children that a visited node pushes, from the last to be popped to the first.
  struct Children {
    void put(unsigned /*slot*/, unsigned /*pushed*/) {}
  };

  /// The bins of the checkpoint entries written so far; an entry's bin is there before the event that writes it.
  void bins(const std::vector<std::uint8_t>&) {}
  /// order: of the round's reads, if it replays from bins.
  void begin_round(bool /*replay*/, traces::BinOrder /*order*/ = {}) {}
  /// With several nodes under way: the place of the next event's node, and the number of the last event.
  template <typename Place>
  void at(const Place&) {}
  std::uint32_t last() const { return 0; }
  void pop() {}
  Children open(std::uint32_t /*address*/) { return {}; }
  void internal(const Children&, std::uint32_t, unsigned, unsigned) {}
  void event(traces::EventKind, std::uint32_t, unsigned, unsigned, unsigned = 0) {}
  void processed(std::uint32_t, bool) {}
  void end_round(traces::Round) {}
};

/// Reads internal nodes out of the node image.
class ImageNodes : public traces::NodeSource {
 public:
  explicit ImageNodes(const NodeImage& image) : image_(image) {}
  traces::NodeDefinition define(std::uint32_t address) const override;

 private:
  const NodeImage& image_;
};

/// Records the events of one ray at a time and encodes them when the ray is done: for what EncodingRecorder cannot
/// record, and for callers that need a ray, not a file. One recorder per thread.
class GroupRecorder {
 public:
  static constexpr bool kEnabled = true;
  static constexpr bool kDepthFirst = true;
  using Children = NullRecorder::Children;

  /// Without a header nothing is encoded: only the last ray is recorded. The header must outlive the recorder.
  explicit GroupRecorder(const NodeImage& image, const traces::Header* header = nullptr)
      : nodes_(image), header_(header) {}

  void begin_group(std::uint32_t index, traces::RayKind kind);
  /// Rays begin in lane order.
  void begin_ray(std::uint32_t pixel);
  /// The group for Writer::append(). Needs a header.
  traces::EncodedGroup end_group();
  /// The hits that the last ray has processed when blending.
  const std::vector<traces::Processed>& processed() const { return processed_; }

  void bins(const std::vector<std::uint8_t>& of_ray) { bins_ = &of_ray; }
  void begin_round(bool /*replay*/, traces::BinOrder /*order*/ = {}) { round_start_ = events_; }
  void pop() {}
  Children open(std::uint32_t /*address*/) { return {}; }
  void internal(const Children&, std::uint32_t address, unsigned pushed, unsigned checkpoints) {
    event(traces::EventKind::visit_internal, address, pushed, checkpoints);
  }
  void event(traces::EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints,
             unsigned shifts = 0) {
    if (events_ == store_.size()) grow();
    store_[events_++] = {address, static_cast<std::uint8_t>(detail), static_cast<std::uint8_t>(checkpoints),
                         traces::Event::pack(kind, shifts)};
  }
  void processed(std::uint32_t gaussian, bool blended) { processed_.push_back(processed_entry(gaussian, blended)); }
  void end_round(traces::Round round) {
    round.event_count = static_cast<std::uint32_t>(events_ - round_start_);
    rounds_.push_back(round);
  }

 private:
  void encode_ray();
  void grow();

  ImageNodes nodes_;  ///< outlives each group
  const traces::Header* header_;
  traces::GroupEncoder encoder_;
  bool begun_ = false;  ///< a ray is not encoded yet
  std::uint32_t pixel_ = 0;
  const std::vector<std::uint8_t>* bins_ = nullptr;  ///< of the last ray, once it is traced
  std::vector<traces::Round> rounds_;
  std::vector<traces::Event> store_ = std::vector<traces::Event>(1024);
  std::size_t events_ = 0;  ///< events in store_
  std::vector<traces::Processed> processed_;
  std::size_t round_start_ = 0;
};

}  // namespace grtx::frontend
