#include "grtx/modules/simt/decide/private_store.h"

namespace grtx::modules {

const CounterTable<PrivateStore::Counters>& PrivateStore::Counters::table() {
  using C = PrivateStore::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::reads, "reads", "accesses", "reads of warps at the private store, an entry of each lane")
          .sum(&C::writes, "writes", "accesses", "writes of warps at the private store, an entry of each lane")
          .sum(&C::wait_cycles, "wait_cycles", "cycles", "cycles that a phase's accesses waited for the store's banks")
          .when([](const C& c) { return c.insertions > 0; })
          .sum(&C::insertions, "insertions", "hits", "hits of lanes that banks inserted, without a shader")
          .sum(&C::insertion_words, "insertion_busy_cycles", "cycles",
               "cycles of a bank that insertions took, summed over banks")
          .sum(&C::insertion_wait, "insertion_wait_cycles", "cycles", "cycles that hits waited for their bank");
  return table;
}

}  // namespace grtx::modules
