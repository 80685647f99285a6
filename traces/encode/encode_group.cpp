// SPDX-License-Identifier: Apache-2.0
// Encodes a group whose rays are all in memory.
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/wide_leaves.h"
#include "grtx/traces/encode/group_encoder.h"

namespace grtx::traces {
namespace {

/// Used if the dictionary is complete before the first event.
class NoOtherNodes : public NodeSource {
 public:
  NodeDefinition define(std::uint32_t) const override { throw std::logic_error("all nodes are listed"); }
};

// The first event of a round from the root gives the root's kind; a root that is only culled is taken as internal.
NodeKind root_kind(const RayGroup& group) {
  for (const Ray& ray : group.rays) {
    std::size_t first = 0;
    for (const Round& round : ray.rounds) {
      if (!round.replay && round.event_count > 0 && first < ray.events.size()) {
        const EventKind kind = ray.events[first].kind();
        if (kind == EventKind::visit_internal) return NodeKind::internal;
        if (kind == EventKind::visit_instance) return NodeKind::instance;
        if (kind == EventKind::visit_leaf) return NodeKind::triangle;
      }
      first += round.event_count;
    }
  }
  return NodeKind::internal;
}

}  // namespace

void encode_group(const Header& header, const RayGroup& group, EncodedGroup& out) {
  thread_local GroupEncoder encoder;
  thread_local std::vector<Event> events;
  thread_local WideLeaves wide;
  wide.take(group.nodes, header.node_sizes());
  const NoOtherNodes nodes;
  encoder.begin(header, group.index, group.kind, root_kind(group), nodes);
  encoder.list(group.nodes);
  for (const Ray& ray : group.rays) {
    events = ray.events;
    for (Event& event : events) {
      const bool leaf = event.kind() == EventKind::visit_leaf || event.kind() == EventKind::visit_instance;
      if (event.wide() != (leaf && wide.contains(event.node))) {  // not stored: it follows from the dictionary
        throw std::logic_error("trace group " + std::to_string(group.index) +
                               ": a leaf is not as wide as its parent says");
      }
      if (event.kind() != EventKind::visit_internal) continue;
      if (event.node >= group.nodes.size()) {
        throw std::logic_error("trace group " + std::to_string(group.index) + ": a node index exceeds the dictionary");
      }
      event.node = group.nodes[event.node].address;
    }
    encoder.add({ray.pixel, ray.rounds, events, ray.processed, ray.bins});
  }
  encoder.finish(out);
}

void encode_group(const Header& header, const RayGroup& group, Bytes& out) {
  EncodedGroup encoded;
  encode_group(header, group, encoded);
  out.insert(out.end(), encoded.chunk.begin() + kChunkPreambleBytes, encoded.chunk.end());
}

}  // namespace grtx::traces
