// SPDX-License-Identifier: Apache-2.0
// Configuration keys that are set but have no effect, for a warning.
#pragma once

#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// A key without effect, and the other key that makes it so.
struct IdleKey {
  std::string key;
  std::string because;  ///< "dram.scheduling = fcfs"
};
/// The keys without effect whose value is not their default, in order of the keys.
std::vector<IdleKey> idle_keys(const GpuConfig& config);

/// Names them on stderr, one line per reason.
void warn_of_idle_keys(const GpuConfig& config);
/// The same for keys from idle_keys().
void warn_of(const std::vector<IdleKey>& keys);

}  // namespace grtx::sim
