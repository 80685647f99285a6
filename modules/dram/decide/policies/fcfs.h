// DRAM scheduling fcfs: data in order of arrival, row hit or not.
#pragma once

#include "grtx/modules/dram/decide/dram_scheduling.h"

namespace grtx::modules {

/// The column command goes to the oldest request of the channel and nobody else. Banks prepare themselves meanwhile:
/// the row command goes to the oldest request that is the oldest of its bank and lacks its row.
class Fcfs final : public DramScheduling {
 public:
  DramChoice choose(Cycle, const DramQueues& queues) override {
    DramChoice choice;
    const unsigned first = DramQueues::oldest_of(queues.busy, queues.oldest);
    if (((queues.columns & ~queues.overtaking) >> first & 1) != 0) choice.column = first;
    choice.row = DramQueues::oldest_of(queues.rows, queues.oldest);
    return choice;
  }
};

}  // namespace grtx::modules
