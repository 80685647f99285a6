// In which order a replay round reads the source buffer: a policy, one file each in this folder. Tracer, trace codec
// and hardware model ask the same classes. They are chosen at compile time: an entry's place is a line of arithmetic,
// asked for in the inner loops of the codec.
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

/// kName: its name. kByPlace: the entries' places tell the order, so a trace need not hold it. kBackwards: the next
/// entry lies before the last one. arrange(source): puts a buffer of entries with a member t as position() wants it.
/// position(read, size): place of the next entry in a buffer of `size` of which `read` have been read.
template <typename Policy>
concept CheckpointOrderPolicy = requires(std::size_t count) {
  { Policy::kName } -> std::convertible_to<CheckpointOrder>;
  { Policy::kByPlace } -> std::convertible_to<bool>;
  { Policy::kBackwards } -> std::convertible_to<bool>;
  { Policy::position(count, count) } -> std::same_as<std::size_t>;
};
static_assert(CheckpointOrderPolicy<Fifo> && CheckpointOrderPolicy<Lifo> && CheckpointOrderPolicy<Nearest>);

/// Calls f with the policy of that name.
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

/// A policy where it is asked too seldom to be worth a template.
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
