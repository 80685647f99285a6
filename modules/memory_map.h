// The flat GPU address space, compact from 0: node image, shader records, per-ray buffers. Addresses of all traffic.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "modules/memory_request.h"
#include "traces/header.h"
#include "traces/node_layout.h"

namespace grtx::modules {

/// Resources that decide how many per-ray buffers exist at a time.
struct MemoryMapConfig {
  unsigned sms = 8;
  unsigned resident_warps = 32;  ///< warp slots of an SM; buffers belong to slots and are reused by later warps
};

/// A ray slot is (sm * resident_warps + warp slot) * warp_size + lane.
class MemoryMap {
 public:
  MemoryMap(const traces::Header& header, const MemoryMapConfig& config);

  std::uint64_t node(std::uint64_t image_address) const { return image_address; }  ///< the node image lies at 0
  std::uint64_t gaussian_record(std::uint32_t gaussian) const;
  std::uint64_t sh_record(std::uint32_t gaussian) const;
  /// k-buffers are structures of arrays over a warp: value `field` (0 = t, 1 = id, 4 B each) of entry `index`.
  std::uint64_t k_buffer(std::uint64_t warp_slot, unsigned index, unsigned field, unsigned lane) const;
  /// First byte of entry `index` of buffer 0 or 1 of a ray slot; entries of a ray are contiguous, 20 B each.
  std::uint64_t checkpoint_entry(std::uint64_t ray_slot, unsigned buffer, std::uint64_t index) const;
  /// First byte of entry `index` of a ray slot's eviction buffer, 8 B each.
  std::uint64_t eviction_entry(std::uint64_t ray_slot, std::uint64_t index) const;
  /// 16 B of per-lane ray state / frame buffer of a pixel.
  std::uint64_t pixel(std::uint32_t pixel) const;
  std::uint64_t ray_slot(unsigned sm, unsigned warp_slot, unsigned lane) const;
  std::uint64_t warp_slot(unsigned sm, unsigned slot) const;
  std::uint64_t bytes() const { return end_; }
  /// Name, base and size of each region, for headers of outputs.
  struct Extent {
    std::string name;
    std::uint64_t base;
    std::uint64_t bytes;
  };
  const std::vector<Extent>& extents() const { return extents_; }

 private:
  traces::Header header_;
  MemoryMapConfig config_;
  std::uint64_t gaussian_ = 0, sh_ = 0, k_buffer_ = 0, checkpoint_ = 0, eviction_ = 0, pixel_ = 0, end_ = 0;
  std::uint64_t eviction_capacity_ = 0;  ///< entries a ray
  std::vector<Extent> extents_;
};

}  // namespace grtx::modules
