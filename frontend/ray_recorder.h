// Turns what one ray does into trace events. NullRecorder costs nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "frontend/node_image.h"
#include "traces/event.h"

namespace grtx::frontend {

class NullRecorder {
 public:
  static constexpr bool kEnabled = false;
  void begin_round() {}
  void internal(const std::uint8_t*, std::uint32_t, unsigned, unsigned) {}
  void event(traces::EventKind, std::uint32_t, unsigned, unsigned, unsigned = 0) {}
  void processed(std::uint32_t, bool) {}
  void end_round(traces::Round) {}
};

/// Records the rays of one group at a time into a traces::RayGroup. One recorder a thread.
class GroupRecorder {
 public:
  static constexpr bool kEnabled = true;

  explicit GroupRecorder(const NodeImage& image) : image_(image), slots_(1u << 12) {}

  void begin_group(std::uint32_t index, traces::RayKind kind, std::size_t rays);
  void begin_ray(std::size_t lane, std::uint32_t pixel);
  /// Sorts the node dictionary by address and renumbers the events.
  const traces::RayGroup& end_group();

  void begin_round() { round_start_ = ray_->events.size(); }
  void internal(const std::uint8_t* node, std::uint32_t address, unsigned pushed, unsigned checkpoints) {
    ray_->events.push_back({index_of(node, address), static_cast<std::uint8_t>(pushed),
                            static_cast<std::uint8_t>(checkpoints),
                            traces::Event::pack(traces::EventKind::visit_internal)});
  }
  void event(traces::EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints,
             unsigned shifts = 0) {
    ray_->events.push_back({address, static_cast<std::uint8_t>(detail), static_cast<std::uint8_t>(checkpoints),
                            traces::Event::pack(kind, shifts)});
  }
  void processed(std::uint32_t gaussian, bool blended) {
    traces::Processed entry;
    entry.gaussian = gaussian & 0x7FFFFFFFu;
    entry.blended = blended ? 1u : 0u;
    ray_->processed.push_back(entry);
  }
  void end_round(traces::Round round) {
    round.event_count = static_cast<std::uint32_t>(ray_->events.size() - round_start_);
    ray_->rounds.push_back(round);
  }

 private:
  struct Slot {
    std::uint32_t address = 0;
    std::uint32_t index = 0;
    std::uint32_t stamp = 0;
  };
  std::uint32_t index_of(const std::uint8_t* node, std::uint32_t address) {
    std::size_t at = (address * 0x9E3779B1u) >> shift_;
    for (;; at = (at + 1) & (slots_.size() - 1)) {
      Slot& slot = slots_[at];
      if (slot.stamp != stamp_) return add(slot, node, address);
      if (slot.address == address) return slot.index;
    }
  }
  std::uint32_t add(Slot& slot, const std::uint8_t* node, std::uint32_t address);
  void grow();

  const NodeImage& image_;
  traces::RayGroup group_;
  traces::Ray* ray_ = nullptr;
  std::size_t round_start_ = 0;
  std::vector<Slot> slots_;  ///< open-addressing hash of node addresses, valid where stamp == stamp_
  unsigned shift_ = 32 - 12;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> rank_;
  std::vector<traces::NodeDefinition> sorted_;
};

}  // namespace grtx::frontend
