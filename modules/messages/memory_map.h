// The flat GPU address space, compact from 0: node image, shader records, per-ray buffers. Addresses of all traffic.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/header.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

/// Arrays of which every ray of a warp has one. by_ray: a ray's entries follow each other. by_lane: entry i of all
/// lanes of a warp lie side by side, so that lanes that are at the same entry share sectors.
enum class RayArrayLayout : std::uint8_t { by_ray, by_lane };
constexpr auto enum_names(RayArrayLayout) { return names_in_order<RayArrayLayout>({"by_ray", "by_lane"}); }

/// Resources that decide how many per-ray buffers exist at a time.
struct MemoryMapConfig {
  unsigned sms = 8;
  unsigned resident_warps = 32;  ///< warp slots of an SM; buffers belong to slots and are reused by later warps
  /// Entries of a ray's eviction buffer; 0: as many as a checkpoint buffer has, at least 256. The totals of a trace
  /// know the number that is really needed (max_evictions_per_ray).
  std::uint64_t eviction_capacity = 0;
  /// Sectors of a ray's stack area in memory; 0: stacks do not spill.
  std::uint64_t stack_sectors = 0;
  std::uint64_t checkpoint_entry_bytes = traces::kCheckpointEntryBytes;
  RayArrayLayout k_buffers = RayArrayLayout::by_lane;
  RayArrayLayout evictions = RayArrayLayout::by_ray;
};

/// A ray slot is (sm * resident_warps + warp slot) * warp_size + lane.
class MemoryMap {
 public:
  /// Throws Error when it does not fit into 128 GiB.
  MemoryMap(const traces::Header& header, const MemoryMapConfig& config);

  std::uint64_t node(std::uint64_t image_address) const { return image_address; }  ///< the node image lies at 0
  std::uint64_t gaussian_record(std::uint32_t gaussian) const { return gaussian_ + gaussian * gaussian_bytes_; }
  /// Matrix to the unit sphere, of the Gaussian in the box at `leaf` (units). The array that an intersection shader
  /// reads lies in the order of the leaves.
  std::uint64_t shape_record(std::uint32_t leaf) const { return shape_ + leaf * kShapeBytes; }
  std::uint64_t sh_record(std::uint32_t gaussian) const { return sh_ + gaussian * sh_bytes_; }
  /// Value `field` (0 = t, 1 = id, 4 B each) of entry `index`. by_lane: k-buffers are structures of arrays over a warp.
  /// Single-round tracing sorts there and back: its buffers have 2 k entries.
  std::uint64_t k_buffer(std::uint64_t warp_slot, unsigned index, unsigned field, unsigned lane) const {
    assert(index < k_ && field < 2);
    if (k_buffers_ == RayArrayLayout::by_ray) {
      return k_buffer_ + (((warp_slot * warp_size_ + lane) * k_ + index) * 2 + field) * 4;
    }
    return k_buffer_ + (((warp_slot * k_ + index) * 2 + field) * warp_size_ + lane) * 4;
  }
  /// First byte of entry `index` of buffer 0 or 1 of a ray slot; entries of a ray are contiguous.
  std::uint64_t checkpoint_entry(std::uint64_t ray_slot, unsigned buffer, std::uint64_t index) const {
    assert(checkpoint_stride_ != 0 && checkpoint_lists_ == 2 && buffer < 2 && index < checkpoint_capacity_);
    return checkpoint_ + (ray_slot * 2 + buffer) * checkpoint_stride_ + index * checkpoint_entry_bytes_;
  }
  std::uint64_t checkpoint_entry_bytes() const { return checkpoint_entry_bytes_; }
  /// First byte of a bin of a ray slot (traces::CheckpointBins), which begins and ends on a line boundary. All bins
  /// have the same distance to the next.
  std::uint64_t checkpoint_bin(std::uint64_t ray_slot, unsigned bin) const {
    assert(checkpoint_stride_ != 0 && bin < checkpoint_lists_);
    return checkpoint_ + (ray_slot * checkpoint_lists_ + bin) * checkpoint_stride_;
  }
  /// First byte of entry `index` of a ray slot's eviction buffer, 8 B each. Beyond the capacity it starts over, so that
  /// addresses stay inside even if a ray evicts more than was foreseen.
  std::uint64_t eviction_entry(std::uint64_t ray_slot, std::uint64_t index) const {
    assert(eviction_stride_ != 0);
    const std::uint64_t entry = index < eviction_capacity_ ? index : index % eviction_capacity_;
    if (evictions_ == RayArrayLayout::by_ray) {
      return eviction_ + ray_slot * eviction_stride_ + entry * traces::kEvictionEntryBytes;
    }
    return eviction_ + ray_slot / warp_size_ * eviction_stride_ +
           (entry * warp_size_ + ray_slot % warp_size_) * traces::kEvictionEntryBytes;
  }
  /// Sector `index` of a ray slot's stack area; beyond its size it starts over, as the eviction buffer does.
  std::uint64_t stack_sector(std::uint64_t ray_slot, std::uint64_t index) const {
    assert(stack_sectors_ != 0);
    return stack_ + ray_slot * stack_stride_ + index % stack_sectors_ * kSectorBytes;
  }
  /// 16 B of per-lane ray state / frame buffer of a pixel.
  std::uint64_t pixel(std::uint32_t pixel) const { return pixel_ + static_cast<std::uint64_t>(pixel) * kPixelBytes; }
  std::uint64_t ray_slot(unsigned sm, unsigned warp_slot, unsigned lane) const {
    return this->warp_slot(sm, warp_slot) * warp_size_ + lane;
  }
  std::uint64_t warp_slot(unsigned sm, unsigned slot) const {
    return static_cast<std::uint64_t>(sm) * resident_warps_ + slot;
  }
  std::uint64_t eviction_capacity() const { return eviction_capacity_; }  ///< entries a ray; 0 without checkpointing
  std::uint64_t bytes() const { return end_; }
  /// Name, base and size of each region, for headers of outputs.
  struct Extent {
    std::string name;
    std::uint64_t base;
    std::uint64_t bytes;
  };
  const std::vector<Extent>& extents() const { return extents_; }

  static constexpr std::uint64_t kPixelBytes = 16;  ///< colour and transmittance, 4 floats
  static constexpr std::uint64_t kShapeBytes = 48;  ///< three rows of four floats

 private:
  std::uint64_t gaussian_bytes_, sh_bytes_;  ///< sizes of one record
  unsigned k_;                               ///< entries of a k-buffer
  RayArrayLayout k_buffers_, evictions_;
  unsigned warp_size_, resident_warps_;
  std::uint64_t gaussian_ = 0, shape_ = 0, sh_ = 0, k_buffer_ = 0, checkpoint_ = 0, eviction_ = 0, pixel_ = 0, end_ = 0;
  std::uint64_t checkpoint_capacity_ = 0;  ///< entries of one list
  std::uint64_t checkpoint_lists_ = 0;     ///< of a ray: two buffers, or bins
  std::uint64_t checkpoint_stride_ = 0;    ///< bytes from one of them to the next
  std::uint64_t checkpoint_entry_bytes_;
  std::uint64_t eviction_capacity_ = 0;  ///< entries a ray
  std::uint64_t eviction_stride_ = 0;    ///< bytes from one ray's, or warp's, eviction buffer to the next
  std::uint64_t stack_ = 0, stack_sectors_ = 0, stack_stride_ = 0;  ///< stack areas
  std::vector<Extent> extents_;
};

}  // namespace grtx::modules
