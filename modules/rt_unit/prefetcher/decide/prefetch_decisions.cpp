// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/prefetcher/decide/prefetch_decisions.h"

#include <string>

namespace grtx::modules {

const CounterTable<PrefetchCounters>& PrefetchCounters::table() {
  using C = PrefetchCounters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::triggers, "triggers", "visits", "internal visits whose hit siblings were prefetched")
          .sum(&C::nodes, "nodes", "nodes", "sibling nodes queued for prefetch")
          .sum(&C::merged, "merged", "nodes", "sibling nodes that were on their way to be prefetched already")
          .sum(&C::dropped, "dropped", "nodes", "sibling nodes dropped because the queue was full")
          .sum(&C::sectors, "sectors", "requests", "32 B prefetch requests sent")
          .sum(&C::responses)
          .when([](const C& c) { return c.replayed > 0; })
          .sum(&C::replayed, "replayed", "visits", "replayed leaves whose siblings were prefetched, of the triggers");
  return table;
}

}  // namespace grtx::modules
