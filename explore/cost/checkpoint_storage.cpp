// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/checkpoint_storage.h"

namespace grtx::explore {

CheckpointStorage checkpoint_storage(const std::vector<modules::Inventory>& rt_unit) {
  CheckpointStorage table;
  for (const modules::Inventory& module : rt_unit) {
    for (const modules::Storage& storage : module.storage) {
      if (!storage.added_by_grtx) continue;
      table.fields.push_back({storage.name, storage.bits});
      table.bits += storage.bits;
    }
  }
  return table;
}

}  // namespace grtx::explore
