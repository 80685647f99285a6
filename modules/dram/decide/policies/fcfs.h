// SPDX-License-Identifier: Apache-2.0
// DRAM scheduling fcfs: column commands in order of arrival, regardless of row hits.
#pragma once

#include "grtx/modules/dram/decide/dram_scheduling.h"

namespace grtx::modules {

/// Only the channel's oldest request gets a column command. Other banks prepare meanwhile: the row command goes to the
/// oldest request that is the oldest of its bank and whose row is not open.
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
