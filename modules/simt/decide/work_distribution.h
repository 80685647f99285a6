// SPDX-License-Identifier: Apache-2.0
// Work distribution policies: which SM gets the next ray group. Selected by name, free of SystemC. The project's are in
// policies/, one file each. Register one of your own before the first GPU is built.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/traces/event.h"

namespace grtx::modules {

class WorkDistribution {
 public:
  static constexpr unsigned kNobody = ~0u;
  virtual ~WorkDistribution() = default;
  /// The SM that gets `group`, the next of the trace. room: [sm] free warp slots, one at least not 0; also 0 where the
  /// SM cannot take a warp in this cycle. kNobody: none of these; asked again in the next cycle in which there is room.
  /// An SM without room ends the run.
  virtual unsigned choose(const traces::RayGroup& group, const std::vector<unsigned>& room) = 0;
};

using WorkDistributionFactory = std::function<std::unique_ptr<WorkDistribution>(unsigned sms)>;

/// Makes `name` a value of gpu.distribution. Throws std::logic_error if the name is taken.
void register_work_distribution(const std::string& name, WorkDistributionFactory factory);
/// The registered values of gpu.distribution, the project's first.
std::vector<std::string> work_distribution_names();
/// Throws Error for an unknown name, with the known ones, and for a factory that makes nothing.
std::unique_ptr<WorkDistribution> make_work_distribution(std::string_view name, unsigned sms);

}  // namespace grtx::modules
