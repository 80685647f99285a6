// SPDX-License-Identifier: Apache-2.0
// Checks of free memory before large allocations: a small file may claim, or decode to, more memory than the machine
// has, and a system that overcommits memory kills the process that uses it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace grtx {

/// Bytes that this process can still allocate: the minimum of what the machine has without swapping (MemAvailable) and
/// what RLIMIT_DATA leaves. nullopt if unknown (other systems than Linux).
std::optional<std::uint64_t> free_memory();

/// Error text if `bytes` are not free; "" if they are, and for amounts too small to check.
std::string memory_fault(std::uint64_t bytes);

/// Throws Error{file, place, memory_fault(bytes)} if `bytes` are not free.
void require_memory(std::uint64_t bytes, const std::string& file, const std::string& place);

}  // namespace grtx
