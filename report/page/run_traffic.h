// SPDX-License-Identifier: Apache-2.0
// Bytes that a design moved, by purpose.
#pragma once

#include <cstddef>
#include <string>

#include "grtx/report/page/run_results.h"

namespace grtx::report {

/// Purposes: nodes, shading, k-buffers, checkpoints, stacks.
inline constexpr std::size_t kPurposes = 5;
std::string purpose_name(std::size_t purpose);

enum class MemoryLevel { l2, dram };
/// Bytes read and written for a purpose; 0 without such accesses.
double bytes_for(const DesignResult& design, MemoryLevel level, std::size_t purpose);
/// The same for all purposes.
double bytes_for_all(const DesignResult& design, MemoryLevel level);

}  // namespace grtx::report
