// SPDX-License-Identifier: Apache-2.0
// Encodes a group ray by ray from events. Rebuilds the traversal stack and checks that the events follow it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "grtx/traces/encode/encoded_group.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/node_source.h"

namespace grtx::traces {

/// The rounds and events of one ray. Unlike in a RayGroup, visit_internal events hold the node's address (in units).
struct TracedRay {
  std::uint32_t pixel = 0;
  std::span<const Round> rounds;
  std::span<const Event> events;
  std::span<const Processed> processed;
  std::span<const std::uint8_t> bins = {};  ///< as Ray::bins
};

/// Use one per thread; reuses its memory. Throws std::logic_error naming group, lane, round and event if the events do
/// not follow the stack, the source buffer or the nodes, which is a bug of the caller. Rules that do not affect the
/// encoding (k-buffer, evictions) are left to check().
class GroupEncoder {
 public:
  GroupEncoder();
  ~GroupEncoder();
  GroupEncoder(GroupEncoder&&) noexcept;
  GroupEncoder& operator=(GroupEncoder&&) noexcept;

  /// Begins a group whose root is of kind `root`. `header` and `nodes` must stay valid until finish().
  void begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root, const NodeSource& nodes);
  /// Adds the next ray, in lane order.
  void add(const TracedRay& ray);
  /// Ends the group and stores it in `group`.
  void finish(EncodedGroup& group);

 private:
  friend void encode_group(const Header& header, const RayGroup& group, EncodedGroup& out);
  /// Sets all nodes of the group, ascending by address, before its first ray; the NodeSource is then not used.
  void list(const std::vector<NodeDefinition>& nodes);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Encodes a whole group. Its working memory is thread-local.
void encode_group(const Header& header, const RayGroup& group, EncodedGroup& out);

}  // namespace grtx::traces
