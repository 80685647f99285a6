// What memory there is, asked before a great deal of it is taken: a small file may claim, or decode to, more than a
// machine has, and a system that promises memory ends the process that uses it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace grtx {

/// Bytes that this process may still take: what the machine has without swapping (MemAvailable), and what a limit of
/// its own (RLIMIT_DATA) leaves. Nothing where the system (other than Linux) does not say.
std::optional<std::uint64_t> free_memory();

/// The rule that taking `bytes` would break; "" when so much is free, and for what is too little to ask.
std::string memory_fault(std::uint64_t bytes);

/// Throws Error with memory_fault().
void require_memory(std::uint64_t bytes, const std::string& file, const std::string& place);

}  // namespace grtx
