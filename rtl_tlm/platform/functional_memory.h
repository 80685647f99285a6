// SPDX-License-Identifier: Apache-2.0
// Puts what a launch reads into a memory that holds data, and the picture behind it, by debug transport: the bytes of
// traces/memory_contents.h, where the memory map of the launch has them. Takes no simulated time.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/platform/picture.h"
#include "grtx/traces/memory_contents.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

class FunctionalMemory {
 public:
  /// contents: files, of each of `traces` in turn. Throws Error if one is of another trace, or has regions of other
  /// sizes.
  FunctionalMemory(const std::vector<std::string>& contents, const std::vector<const traces::Reader*>& traces,
                   const GpuConfig& config);

  /// Writes what launch `trace` reads. Returns why that cannot be, or nothing.
  std::string load(Gpu& gpu, std::size_t trace) const;
  /// Why the picture of `trace` cannot lie so, or nothing.
  std::string fault(const Picture& picture, std::size_t trace) const;
  /// Writes the pixels of the map, and the picture. Returns why that cannot be, or nothing.
  std::string store(Gpu& gpu, std::size_t trace, const Picture& picture) const;

 private:
  struct Size {
    unsigned width, height;
  };
  std::vector<traces::MemoryContents> contents_;
  std::vector<Size> sizes_;  ///< of the picture of each
};

}  // namespace grtx::sim
