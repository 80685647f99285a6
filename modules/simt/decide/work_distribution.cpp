// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/simt/decide/work_distribution.h"

#include <utility>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/simt/decide/policies/sms_in_turn.h"

namespace grtx::modules {
namespace {

auto& distributions() {
  static Registry<WorkDistributionFactory> all(
      "work distribution", "gpu.distribution",
      {{"round_robin", [](unsigned) { return std::make_unique<SmsInTurn>(); }}});
  return all;
}

}  // namespace

void register_work_distribution(const std::string& name, WorkDistributionFactory factory) {
  distributions().add(name, std::move(factory));
}

std::vector<std::string> work_distribution_names() { return distributions().names(); }

std::unique_ptr<WorkDistribution> make_work_distribution(std::string_view name, unsigned sms) {
  return distributions().make(name, sms);
}

}  // namespace grtx::modules
