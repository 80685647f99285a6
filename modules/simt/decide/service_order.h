// SPDX-License-Identifier: Apache-2.0
// Which request of the RT unit a warp serves next. A warp has one program counter, so it serves one at a time.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// Requests that wait for their warps: any-hit shaders before node fetches, each kind in order of arrival.
class ServiceOrder {
 public:
  void reserve(std::size_t warps) { any_hits_.reserve(warps); }
  void add(const AnyHitBatch& batch) { any_hits_.push_back(batch); }
  void add(const NodeFetchBatch& batch) { node_fetches_.push_back(batch); }
  void clear() {
    any_hits_.clear();
    node_fetches_.clear();
  }

  /// Whether the warp in `slot` has a request.
  bool waits(unsigned slot) const { return find(any_hits_, slot) || find(node_fetches_, slot); }
  /// The warp's next request, if that is an any-hit shader; it waits no longer.
  std::optional<AnyHitBatch> take_any_hit(unsigned slot) { return take(any_hits_, slot); }
  /// The warp's next request if take_any_hit() has none; it waits no longer.
  std::optional<NodeFetchBatch> take_node_fetch(unsigned slot) {
    assert(!find(any_hits_, slot));
    return take(node_fetches_, slot);
  }

  bool empty() const { return any_hits_.empty() && node_fetches_.empty(); }
  std::size_t any_hits() const { return any_hits_.size(); }
  std::size_t node_fetches() const { return node_fetches_.size(); }

 private:
  /// Place of the first request of the warp in `slot`.
  template <typename Batch>
  static std::optional<std::ptrdiff_t> find(const std::vector<Batch>& waiting, unsigned slot) {
    const auto found = std::find_if(waiting.begin(), waiting.end(), [&](const Batch& b) { return b.slot == slot; });
    if (found == waiting.end()) return std::nullopt;
    return found - waiting.begin();
  }
  template <typename Batch>
  static std::optional<Batch> take(std::vector<Batch>& waiting, unsigned slot) {
    const auto place = find(waiting, slot);
    if (!place) return std::nullopt;
    const auto first = waiting.begin() + *place;
    std::optional<Batch> taken(std::move(*first));
    waiting.erase(first);
    return taken;
  }

  std::vector<AnyHitBatch> any_hits_;
  std::vector<NodeFetchBatch> node_fetches_;
};

}  // namespace grtx::modules
