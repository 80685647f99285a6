// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/long_work.h"

#include <fmt/format.h>

#include <cstdio>

namespace grtx {

std::string long_work(const std::string& work, double seconds, std::uint64_t bytes) {
  if (seconds <= 60.0) return "";
  const std::string time =
      seconds < 5400.0 ? fmt::format("{:.0f} min", seconds / 60.0) : fmt::format("{:.1f} h", seconds / 3600.0);
  return fmt::format("{} takes about {} and {:.1f} GB", work, time, 1e-9 * static_cast<double>(bytes));
}

void say_long_work(const std::string& where, const std::string& work, double seconds, std::uint64_t bytes,
                   const std::string& instead) {
  const std::string line = long_work(work, seconds, bytes);
  if (line.empty()) return;
  fmt::print(stderr, "grtx: {}: {}{}{}\n", where, line, instead.empty() ? "" : "; ", instead);
}

}  // namespace grtx
