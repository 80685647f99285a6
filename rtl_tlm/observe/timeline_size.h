// SPDX-License-Identifier: Apache-2.0
// Warns of large timelines: a viewer takes long to load one, and `grtx ray` needs only one warp of it.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace grtx::sim {

constexpr std::uintmax_t kLargeTimeline = 100'000'000;  ///< bytes

/// The warning for a timeline of more bytes; "" for a smaller one, and for a path that is no file.
inline std::string large_timeline_warning(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) return "";
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  if (bytes <= kLargeTimeline) return "";
  return fmt::format("{} has {:.0f} MB; --timeline-window A:B keeps the cycles that you look at", path,
                     static_cast<double>(bytes) * 1e-6);
}

}  // namespace grtx::sim
