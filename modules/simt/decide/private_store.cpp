#include "grtx/modules/simt/decide/private_store.h"

namespace grtx::modules {

const CounterTable<PrivateStore::Counters>& PrivateStore::Counters::table() {
  using C = PrivateStore::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::reads, "reads", "accesses", "reads of warps at the private store, an entry of each lane")
          .sum(&C::writes, "writes", "accesses", "writes of warps at the private store, an entry of each lane")
          .sum(&C::wait_cycles, "wait_cycles", "cycles", "cycles that a phase's accesses waited for the store's banks")
          .sum(&C::insertions)
          .sum(&C::insertion_words)
          .sum(&C::insertion_wait)
          .described([](const C& c, StatisticList& list, const std::string& prefix) {
            if (!list.lists_kinds() && c.insertions == 0) return;
            list.add(prefix + ".insertions", c.insertions, "hits",
                     "hits of lanes that banks inserted, without a shader");
            list.add(prefix + ".insertion_busy_cycles", c.insertion_words, "cycles",
                     "cycles of a bank that insertions took, summed over banks");
            list.add(prefix + ".insertion_wait_cycles", c.insertion_wait, "cycles",
                     "cycles that hits waited for their bank");
          });
  return table;
}

}  // namespace grtx::modules
