// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"

#include <utility>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/wrong_answer.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/scheduler/decide/policies/greedy_then_oldest.h"
#include "grtx/modules/rt_unit/scheduler/decide/policies/oldest_first.h"
#include "grtx/modules/rt_unit/scheduler/decide/policies/round_robin.h"

namespace grtx::modules {
namespace {

auto& selections() {
  static Registry<WarpSelectionFactory> all(
      "warp selection", "rt.scheduler.policy",
      {{"oldest_first", [] { return std::make_unique<OldestFirst>(); }},
       {"round_robin", [] { return std::make_unique<RoundRobin>(); }},
       {"greedy_then_oldest", [] { return std::make_unique<GreedyThenOldest>(); }}});
  return all;
}

}  // namespace

void register_warp_selection(const std::string& name, WarpSelectionFactory factory) {
  selections().add(name, std::move(factory));
}

std::vector<std::string> warp_selection_names() { return selections().names(); }

std::unique_ptr<WarpSelection> make_warp_selection(std::string_view name) { return selections().make(name); }

unsigned selected_entry(WarpSelection& selection, const std::string& name, LaneMask candidates,
                        const std::vector<std::uint64_t>& ages, const SelectableWarps& warps) {
  const unsigned entry = selection.select(candidates, ages, warps);
  if (entry >= 64 || (candidates & bit(entry)) == 0) [[unlikely]] {
    throw WrongAnswer("the warp selection " + name + " chose entry " + std::to_string(entry) +
                      ", which is no candidate");
  }
  return entry;
}

}  // namespace grtx::modules
