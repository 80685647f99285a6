// A ray's two checkpoint buffers: a round resumes from the source, and leaves to the next what it wrote into the
// destination.
#pragma once

#include <cstddef>
#include <vector>

#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/traversal_stack.h"
#include "grtx/traces/orders/checkpoint_order.h"

namespace grtx::frontend {

class CheckpointBuffers {
 public:
  explicit CheckpointBuffers(const TracerOptions& options)
      : enabled_(options.checkpoint),
        capacity_(options.checkpoint_capacity),
        order_(options.checkpoint_order),
        read_order_(options.checkpoint_order) {}

  bool enabled() const { return enabled_; }
  void begin_ray() { source_.clear(); }
  void begin_round() {
    destination_.clear();
    overflow_ = false;
  }

  /// false: the entry is dropped, because checkpointing is off or the destination is full.
  bool write(const StackEntry& entry) {
    if (!enabled_ || overflow_) return false;
    if (destination_.size() == capacity_) {
      overflow_ = true;
      return false;
    }
    destination_.push_back(entry);
    return true;
  }
  bool overflow() const { return overflow_; }  ///< the destination ran full in this round
  std::size_t written() const { return destination_.size(); }
  const std::vector<StackEntry>& destination() const { return destination_; }
  void drop_written() { destination_.clear(); }

  /// What was written last becomes what is read next.
  void swap() { source_.swap(destination_); }
  /// Begins to read the source; returns how many entries it holds.
  std::size_t begin_reading() {
    traces::with_checkpoint_order(order_, [this](auto policy) { policy.arrange(source_); });
    return source_.size();
  }
  /// The next of them, after `read` others.
  const StackEntry& entry(std::size_t read) const { return source_[read_order_.position(read, source_.size())]; }

 private:
  const bool enabled_;
  const std::size_t capacity_;
  const CheckpointOrder order_;
  const traces::ReadOrder read_order_;
  bool overflow_ = false;
  std::vector<StackEntry> source_;
  std::vector<StackEntry> destination_;
};

}  // namespace grtx::frontend
