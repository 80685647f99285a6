// SPDX-License-Identifier: Apache-2.0
// Work distribution round_robin.
#pragma once

#include "grtx/modules/simt/decide/work_distribution.h"

namespace grtx::modules {

/// The next SM with room after the one that got the last group (what public simulators do).
class SmsInTurn final : public WorkDistribution {
 public:
  unsigned choose(const traces::RayGroup&, const std::vector<unsigned>& room) override {
    const auto sms = static_cast<unsigned>(room.size());
    unsigned sm = turn_;
    while (room[sm] == 0) sm = sm + 1 == sms ? 0 : sm + 1;
    turn_ = sm + 1 == sms ? 0 : sm + 1;
    return sm;
  }

 private:
  unsigned turn_ = 0;  ///< SM to try first
};

}  // namespace grtx::modules
