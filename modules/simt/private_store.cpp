#include "grtx/modules/simt/private_store.h"

namespace grtx::modules {

const CounterTable<PrivateStore::Counters>& PrivateStore::Counters::table() {
  using C = PrivateStore::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::reads, "reads", "accesses", "reads of warps at the private store, an entry of each lane")
          .sum(&C::writes, "writes", "accesses", "writes of warps at the private store, an entry of each lane")
          .sum(&C::wait_cycles, "wait_cycles", "cycles", "cycles that a phase's accesses waited for the store's banks");
  return table;
}

}  // namespace grtx::modules
