// SPDX-License-Identifier: Apache-2.0
// How the events of a round hang together: what each pushed, and, with several nodes under way (Header::ahead), the
// order in which the ray came to them, which a trace lists depth first. docs/model/tracer.md, "Nodes under way", has
// the rules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/traces/event.h"

namespace grtx::report {

/// [event] The events of what it pushed, the topmost first. events: of a round whose stack ends empty, as
/// traces::check_group() proves.
std::vector<std::vector<std::uint32_t>> children_of(std::span<const traces::Event> events);

struct HandledOrder {
  std::vector<std::size_t> events;  ///< index of the event that came first, second, …
  /// [i] events whose nodes are started when the first i events are over
  std::vector<std::vector<std::uint32_t>> started;
};

/// events: as for children_of(), of a round that started at the root. One level.
HandledOrder handled_order(std::span<const traces::Event> events, unsigned ahead);

}  // namespace grtx::report
