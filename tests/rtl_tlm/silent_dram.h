// SPDX-License-Identifier: Apache-2.0
// A DRAM that never issues a command: a machine with it stands still although its clocks go on.
#pragma once

#include <memory>

#include "grtx/modules/dram/decide/dram_scheduling.h"

namespace grtx::sim::test {

/// Makes `silent` a value of dram.scheduling; once a process.
inline void make_a_silent_dram() {
  class Silent final : public modules::DramScheduling {
   public:
    modules::DramChoice choose(Cycle, const modules::DramQueues&) override { return {}; }
  };
  modules::register_dram_scheduling("silent",
                                    [](const modules::DramChannelConfig&) { return std::make_unique<Silent>(); });
}

}  // namespace grtx::sim::test
