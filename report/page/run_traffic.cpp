// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/run_traffic.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <vector>

#include "grtx/modules/messages/memory_request.h"

namespace grtx::report {
namespace {

using modules::Region;

struct Purpose {
  const char* name;
  std::vector<Region> regions;
};
const std::array<Purpose, kPurposes>& purposes() {
  static const std::array<Purpose, kPurposes> list = {
      Purpose{"nodes", {Region::tlas, Region::blas, Region::leaf, Region::instance}},
      Purpose{"shading", {Region::gaussian, Region::sh, Region::ray}},
      Purpose{"k-buffers", {Region::k_buffer, Region::eviction}}, Purpose{"checkpoints", {Region::checkpoint}},
      Purpose{"stacks", {Region::stack}}};
  return list;
}

}  // namespace

std::string purpose_name(std::size_t purpose) { return purposes().at(purpose).name; }

double bytes_for(const DesignResult& design, MemoryLevel level, std::size_t purpose) {
  double sectors = 0.0;
  for (const Region region : purposes().at(purpose).regions) {
    const std::string name(name_of(region));
    for (const std::string& counter : level == MemoryLevel::l2
                                          ? std::array{"gpu.l2." + name + ".reads", "gpu.l2." + name + ".writes"}
                                          : std::array{"gpu.l2.dram_reads." + name, "gpu.l2.dram_writes." + name}) {
      const double value = design.value(counter);
      sectors += std::isfinite(value) ? value : 0.0;  // a region without accesses has no counter
    }
  }
  return sectors * static_cast<double>(modules::kSectorBytes);
}

double bytes_for_all(const DesignResult& design, MemoryLevel level) {
  double sum = 0.0;
  for (std::size_t purpose = 0; purpose < kPurposes; ++purpose) sum += bytes_for(design, level, purpose);
  return sum;
}

}  // namespace grtx::report
