// SPDX-License-Identifier: Apache-2.0
// A trace small enough to follow by hand: one root with two triangle leaves, k = 2, every ray the same.
//
//   round 0: root (both leaves pushed), leaf 2 inserted, leaf 3 inserted, two entries blended, ray terminated
#pragma once

#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/writer.h"

namespace grtx::sim::test {

struct TinyTrace {
  unsigned groups = 4;
  unsigned lanes = 32;
};

inline traces::Header tiny_header(const TinyTrace& tiny) {
  traces::Header header;
  header.accel = traces::AccelKind::tri20;
  header.k = 2;
  header.width = tiny.lanes;
  header.height = tiny.groups;
  header.warp_mapping = traces::WarpMapping::linear;
  header.groups = tiny.groups;
  header.node_image_bytes = 4 * traces::kNodeUnit;
  header.root = traces::kNodeUnit;
  header.gaussians = 2;
  header.inputs = {{"scene", "tiny"}};
  return header;
}

inline traces::RayGroup tiny_group(const TinyTrace& tiny, unsigned index) {
  using traces::Event;
  using traces::EventKind;
  using traces::NodeKind;
  traces::RayGroup group;
  group.index = index;
  traces::NodeDefinition root{.address = 1, .child_base = 2, .child_count = 2};
  root.child_kinds[0] = root.child_kinds[1] = NodeKind::triangle;
  group.nodes = {root};
  const auto inserted = static_cast<std::uint8_t>(traces::LeafOutcome::inserted);
  for (unsigned lane = 0; lane < tiny.lanes; ++lane) {
    traces::Ray ray;
    ray.pixel = index * tiny.lanes + lane;
    ray.events = {{0, 0b11, 0, Event::pack(EventKind::visit_internal)},
                  {2, inserted, 0, Event::pack(EventKind::visit_leaf)},
                  {3, inserted, 0, Event::pack(EventKind::visit_leaf, 1)}};
    traces::Round round;
    round.event_count = 3;
    round.k_count = round.processed_count = 2;
    round.terminated = true;
    ray.rounds = {round};
    ray.processed.resize(2);
    ray.processed[0].gaussian = 0;
    ray.processed[0].blended = 1;
    ray.processed[1].gaussian = 1;
    ray.processed[1].blended = 1;
    group.rays.push_back(ray);
  }
  return group;
}

inline void write_tiny_trace(const std::string& path, const TinyTrace& tiny = {}) {
  traces::Writer writer(path, tiny_header(tiny));
  for (unsigned i = 0; i < tiny.groups; ++i) writer.append(tiny_group(tiny, i));
  writer.finish();
}

}  // namespace grtx::sim::test
