// SPDX-License-Identifier: Apache-2.0
// How long the warps of each pixel's rays ran: a picture of where the simulated time went.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

class PixelCycles final : public modules::WarpObserver {
 public:
  PixelCycles(const traces::Header& header, unsigned sms, unsigned resident_warps)
      : resident_warps_(resident_warps),
        cycles_(std::size_t{header.width} * header.height),
        running_(std::size_t{sms} * resident_warps) {}

  void launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle now) override {
    running_[sm * resident_warps_ + slot] = {&group, now};
  }
  /// A pixel with rays in several warps (secondary rays) gets the sum.
  void ended(unsigned sm, unsigned slot, Cycle now) override {
    const auto& [group, since] = running_[sm * resident_warps_ + slot];
    for (const traces::Ray& ray : group->rays) {
      if (ray.pixel < cycles_.size()) cycles_[ray.pixel] += now - since;
    }
  }
  /// Row by row, the top one first.
  const std::vector<std::uint64_t>& cycles() const { return cycles_; }

 private:
  struct Running {
    const traces::RayGroup* group = nullptr;
    Cycle since = 0;
  };
  unsigned resident_warps_;
  std::vector<std::uint64_t> cycles_;
  std::vector<Running> running_;  ///< by SM and slot
};

}  // namespace grtx::sim
