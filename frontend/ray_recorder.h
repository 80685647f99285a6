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
  std::uint32_t internal(const std::uint8_t*, std::uint32_t, std::uint32_t, unsigned, unsigned) { return 0; }
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
  /// known: what an earlier call for the same node and group returned, or 0.
  std::uint32_t internal(const std::uint8_t* node, std::uint32_t address, std::uint32_t known, unsigned pushed,
                         unsigned checkpoints) {
    const std::uint32_t index = known != 0 ? known - 1 : index_of(node, address);
    ray_->events.push_back({index, static_cast<std::uint8_t>(pushed), static_cast<std::uint8_t>(checkpoints),
                            traces::Event::pack(traces::EventKind::visit_internal)});
    return index + 1;
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
  /// Holds a node of this group if number - first_number_ is below the number of its nodes; otherwise it is free.
  struct Slot {
    std::uint32_t address = 0;
    std::uint32_t number = 0;
  };
  std::size_t place_of(std::uint32_t address) const { return (address * 0x9E3779B1u) >> shift_; }
  std::uint32_t index_of(const std::uint8_t* node, std::uint32_t address) {
    for (std::size_t at = place_of(address);; at = (at + 1) & (slots_.size() - 1)) {
      Slot& slot = slots_[at];
      const std::uint32_t index = slot.number - first_number_;
      if (index >= group_.nodes.size()) return add(slot, node, address);
      if (slot.address == address) return index;
    }
  }
  std::uint32_t add(Slot& slot, const std::uint8_t* node, std::uint32_t address);
  void grow();
  void sort_by_address();

  const NodeImage& image_;
  traces::RayGroup group_;
  traces::Ray* ray_ = nullptr;
  std::size_t round_start_ = 0;
  std::vector<Slot> slots_;  ///< open-addressing hash of node addresses
  unsigned shift_ = 32 - 12;
  std::uint32_t first_number_ = 1;
  std::vector<std::uint64_t> order_;  ///< address, index
  std::vector<std::uint64_t> sorting_;
  std::vector<std::uint32_t> rank_;
  std::vector<traces::NodeDefinition> sorted_;
};

}  // namespace grtx::frontend
