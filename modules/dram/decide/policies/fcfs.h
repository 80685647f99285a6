// DRAM scheduling fcfs: data in order of arrival, row hit or not.
#pragma once

#include <vector>

#include "grtx/modules/dram/decide/dram_scheduling.h"

namespace grtx::modules {

/// The column command goes to the oldest request of the channel and nobody else. Banks prepare themselves meanwhile:
/// the row command goes to the oldest request that is the oldest of its bank and lacks its row.
class Fcfs final : public DramScheduling {
 public:
  DramChoice choose(Cycle, const std::vector<DramBankQueue>& queues) override {
    DramChoice choice;
    std::size_t first = 0;
    for (std::size_t i = 0; i < queues.size(); ++i) {
      if (queues[i].oldest < queues[first].oldest) first = i;
      if (!queues[i].row_ready) continue;
      if (choice.row == DramChoice::kNone || queues[i].oldest < queues[choice.row].oldest) choice.row = i;
    }
    const DramBankQueue& queue = queues[first];
    if (queue.has_hit && queue.hit == queue.oldest && queue.column_ready) choice.column = first;
    return choice;
  }
};

}  // namespace grtx::modules
