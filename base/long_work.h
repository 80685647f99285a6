// SPDX-License-Identifier: Apache-2.0
// Announces the time and memory of long work before it begins.
#pragma once

#include <cstdint>
#include <string>

namespace grtx {

/// "" for work of up to a minute, else "WORK takes about 3 min and 4.2 GB". Both figures are estimates.
std::string long_work(const std::string& work, double seconds, std::uint64_t bytes);

/// Prints that line to stderr, if there is one. where: command or step, for the line's beginning. instead: what would
/// be faster, "" if nothing would.
void say_long_work(const std::string& where, const std::string& work, double seconds, std::uint64_t bytes,
                   const std::string& instead = "");

}  // namespace grtx
