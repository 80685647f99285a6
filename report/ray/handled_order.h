// SPDX-License-Identifier: Apache-2.0
// The order in which a ray with several nodes under way (Header::ahead) came to the events of a round, which a trace
// lists depth first. docs/model/tracer.md, "Nodes under way", has the rules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/traces/event.h"

namespace grtx::report {

struct HandledOrder {
  std::vector<std::size_t> events;                   ///< index of the event that came first, second, …
  std::vector<std::vector<std::uint32_t>> children;  ///< [event] events of what it pushed, the topmost first
};

/// events: of a round that started at the root and whose stack ends empty, as traces::check_group() proves. One level.
HandledOrder handled_order(std::span<const traces::Event> events, unsigned ahead);

}  // namespace grtx::report
