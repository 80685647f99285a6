// Encodes a group ray by ray from the events of each ray, which must follow a stack: it is rebuilt, and checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "grtx/traces/codec/encoded_group.h"
#include "grtx/traces/codec/node_source.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// What one ray did. Other than in a RayGroup, visit_internal events hold the address of their node (in units).
struct TracedRay {
  std::uint32_t pixel = 0;
  std::span<const Round> rounds;
  std::span<const Event> events;
  std::span<const Processed> processed;
  std::span<const std::uint8_t> bins = {};  ///< as Ray::bins
};

/// One a thread; keeps its memory. Throws std::logic_error naming group, lane, round and event when the events do not
/// follow the stack, the source buffer or the nodes, because then the program that made them is at fault. Rules that do
/// not decide the bytes (k-buffer, evictions) are left to check().
class GroupEncoder {
 public:
  GroupEncoder();
  ~GroupEncoder();
  GroupEncoder(GroupEncoder&&) noexcept;
  GroupEncoder& operator=(GroupEncoder&&) noexcept;

  /// Begins a group whose root is of kind `root`. Header and nodes must live until finish().
  void begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root, const NodeSource& nodes);
  /// The next ray in lane order.
  void add(const TracedRay& ray);
  /// Replaces `group`.
  void finish(EncodedGroup& group);

 private:
  friend void encode_group(const Header& header, const RayGroup& group, EncodedGroup& out);
  /// All nodes of the group, ascending by address, before its first ray: none is asked of the NodeSource.
  void list(const std::vector<NodeDefinition>& nodes);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All rays of a group. Keeps its working memory per calling thread.
void encode_group(const Header& header, const RayGroup& group, EncodedGroup& out);

}  // namespace grtx::traces
