// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/dram/decide/dram_scheduling.h"

#include <utility>

#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/dram/decide/policies/fcfs.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs_cap.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {
namespace {

auto& schedulings() {
  static Registry<DramSchedulingFactory> all(
      "DRAM scheduling", "dram.scheduling",
      {{kFrFcfs, [](const DramChannelConfig& channel) { return std::make_unique<FrFcfs>(channel.age_cap); }},
       {"fcfs", [](const DramChannelConfig&) { return std::make_unique<Fcfs>(); }},
       {kFrFcfsCap, [](const DramChannelConfig& channel) { return std::make_unique<FrFcfsCap>(channel); }}});
  return all;
}

}  // namespace

void register_dram_scheduling(const std::string& name, DramSchedulingFactory factory) {
  schedulings().add(name, std::move(factory));
}

std::vector<std::string> dram_scheduling_names() { return schedulings().names(); }

std::unique_ptr<DramScheduling> make_dram_scheduling(const DramChannelConfig& channel) {
  return schedulings().make(channel.scheduling, channel);
}

}  // namespace grtx::modules
