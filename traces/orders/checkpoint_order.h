// SPDX-License-Identifier: Apache-2.0
// Policies for the order in which a replay round reads the source buffer, one file each in this folder, shared by
// tracer, trace codec and hardware model. Templates, because the codec's inner loops compute an entry's place with a
// line of arithmetic.
#pragma once

#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include "grtx/traces/modes.h"
#include "grtx/traces/orders/fifo.h"
#include "grtx/traces/orders/lifo.h"
#include "grtx/traces/orders/nearest.h"

namespace grtx::traces {

/// kByPlace: the places of the entries determine the order, so a trace does not store it. kBackwards: each entry read
/// precedes the last one in the buffer. arrange(source): prepares a buffer of entries with a member t for position().
/// position(read, size): index of the next entry in a buffer of `size` entries, `read` of which have been read.
template <typename Policy>
concept CheckpointOrderPolicy = requires(std::size_t count) {
  { Policy::kName } -> std::convertible_to<CheckpointOrder>;
  { Policy::kByPlace } -> std::convertible_to<bool>;
  { Policy::kBackwards } -> std::convertible_to<bool>;
  { Policy::position(count, count) } -> std::same_as<std::size_t>;
};
static_assert(CheckpointOrderPolicy<Fifo> && CheckpointOrderPolicy<Lifo> && CheckpointOrderPolicy<Nearest>);

/// Calls f with an object of the policy for `order`.
template <typename F>
decltype(auto) with_checkpoint_order(CheckpointOrder order, F&& f) {
  switch (order) {
    case CheckpointOrder::lifo:
      return std::forward<F>(f)(Lifo{});
    case CheckpointOrder::nearest:
      return std::forward<F>(f)(Nearest{});
    case CheckpointOrder::fifo:
      break;
  }
  return std::forward<F>(f)(Fifo{});
}

/// Run-time wrapper of a policy, for uses too rare to be worth a template.
class ReadOrder {
 public:
  explicit ReadOrder(CheckpointOrder order = CheckpointOrder::fifo) {
    with_checkpoint_order(order, [this]<typename Policy>(Policy) {
      position_ = Policy::position;
      by_place_ = Policy::kByPlace;
      backwards_ = Policy::kBackwards;
    });
  }
  bool by_place() const { return by_place_; }
  bool backwards() const { return backwards_; }
  std::size_t position(std::size_t read, std::size_t size) const { return position_(read, size); }

 private:
  std::size_t (*position_)(std::size_t read, std::size_t size) = nullptr;
  bool by_place_ = true;
  bool backwards_ = false;
};

}  // namespace grtx::traces
