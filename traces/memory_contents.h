// SPDX-License-Identifier: Apache-2.0
// The bytes that a launch of a trace finds in memory, and those of its picture: what a platform with a memory that
// holds data needs beside the trace. docs/model/memory_map.md describes file and records.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace grtx::traces {

/// Bytes of one region of the memory map, all of it, under the map's name.
struct MemoryRegion {
  std::string name;
  std::string_view bytes;
};

/// Names of the regions that a file holds.
inline constexpr const char* kNodeImageRegion = "node_image";
inline constexpr const char* kGaussianRegion = "gaussian";  ///< records of 48 B
inline constexpr const char* kShapeRegion = "shape";        ///< with leaves that are boxes alone
inline constexpr const char* kShRegion = "sh";
inline constexpr const char* kPixelRegion = "pixel";  ///< after the launch: red, green, blue, 0, fp32 each

/// One file, read whole. Regions are views into it.
class MemoryContents {
 public:
  /// Throws Error{path, place, rule} if it cannot be read or breaks the format, which includes a wrong hash.
  explicit MemoryContents(const std::string& path);
  MemoryContents(MemoryContents&&) = default;
  MemoryContents& operator=(MemoryContents&&) = default;

  const std::string& path() const { return path_; }
  /// Reader::content_hash() of the trace that it belongs to.
  const std::string& trace() const { return trace_; }
  const std::vector<MemoryRegion>& regions() const { return regions_; }
  /// Empty if there is no such region.
  std::string_view region(std::string_view name) const;

 private:
  std::string path_;
  std::unique_ptr<const std::string> file_;  ///< whose bytes stay where they are when this is moved
  std::string trace_;
  std::vector<MemoryRegion> regions_;
};

/// Writes a file atomically. Throws Error.
void write_memory_contents(const std::string& path, const std::string& trace, const std::vector<MemoryRegion>& regions);

}  // namespace grtx::traces
