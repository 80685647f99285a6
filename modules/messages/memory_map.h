// SPDX-License-Identifier: Apache-2.0
// The flat GPU address space, packed from 0: node image, shader records, per-ray buffers. All traffic uses it.
#pragma once

#include <algorithm>
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

/// Layout of per-ray arrays. by_ray: the entries of a ray are contiguous. by_lane: entry i of all lanes of a warp is
/// contiguous, so that lanes at the same entry share sectors.
enum class RayArrayLayout : std::uint8_t { by_ray, by_lane };
constexpr auto enum_names(RayArrayLayout) { return names_in_order<RayArrayLayout>({"by_ray", "by_lane"}); }

/// Number, size and layout of the per-ray buffers.
struct MemoryMapConfig {
  unsigned sms = 8;
  unsigned resident_warps = 32;  ///< warp slots of an SM; buffers belong to slots and are reused by later warps
  /// Entries of a ray's eviction buffer; 0: as many as a checkpoint buffer has, at least 256. The number actually
  /// needed is in the totals of a trace (max_evictions_per_ray).
  std::uint64_t eviction_capacity = 0;
  /// Sectors of a ray's stack area in memory; 0: stacks never spill.
  std::uint64_t stack_sectors = 0;
  std::uint64_t checkpoint_entry_bytes = traces::kCheckpointEntryBytes;
  RayArrayLayout k_buffers = RayArrayLayout::by_lane;
  RayArrayLayout evictions = RayArrayLayout::by_ray;
};

/// A ray slot is (sm * resident_warps + warp slot) * warp_size + lane.
class MemoryMap {
 public:
  /// Throws Error if the map does not fit into 128 GiB.
  MemoryMap(const traces::Header& header, const MemoryMapConfig& config);

  // Buffers, fields and indices must be among those of header and configuration; only asserts check it.

  std::uint64_t node(std::uint64_t image_address) const { return image_address; }  ///< the node image lies at 0
  std::uint64_t gaussian_record(std::uint32_t gaussian) const { return gaussian_ + gaussian * gaussian_bytes_; }
  /// Matrix to the unit sphere for the Gaussian in the box at leaf address `leaf` (in units). The intersection shader
  /// reads it; the array is in leaf order.
  std::uint64_t shape_record(std::uint32_t leaf) const { return shape_ + leaf * kShapeBytes; }
  std::uint64_t sh_record(std::uint32_t gaussian) const { return sh_ + gaussian * sh_bytes_; }
  /// A Gaussian's entry in the table of colours of an SM, for a trace with colour = frame.
  std::uint64_t colour(unsigned sm, std::uint32_t gaussian) const {
    return colour_ + (sm * gaussians_ + gaussian) * traces::kColourBytes;
  }
  /// The record that the any-hit shader reads for a hit in a leaf at this address (in units). A trace does not name the
  /// Gaussian of a hit, so it is another one for each leaf, not the Gaussian's.
  std::uint64_t record_of_hit(std::uint32_t leaf) const {
    return gaussian_record(static_cast<std::uint32_t>(leaf % std::max<std::uint64_t>(gaussians_, 1)));
  }
  /// Address of `field` (0 = t, 1 = id, 2 = alpha, which only a trace with opacity_bound has; 4 B each) of entry
  /// `index`. by_lane: structure of arrays over a warp.
  /// Single-round tracing has buffers of 2 k entries, since it sorts from one half into the other.
  std::uint64_t k_buffer(std::uint64_t warp_slot, unsigned index, unsigned field, unsigned lane) const {
    assert(index < k_ && field < k_fields_);
    if (k_buffers_ == RayArrayLayout::by_ray) {
      return k_buffer_ + (((warp_slot * warp_size_ + lane) * k_ + index) * k_fields_ + field) * 4;
    }
    return k_buffer_ + (((warp_slot * k_ + index) * k_fields_ + field) * warp_size_ + lane) * 4;
  }
  /// First byte of entry `index` of buffer 0 or 1 of a ray slot; the entries of a buffer are contiguous.
  std::uint64_t checkpoint_entry(std::uint64_t ray_slot, unsigned buffer, std::uint64_t index) const {
    assert(checkpoint_stride_ != 0 && checkpoint_lists_ == 2 && buffer < 2 && index < checkpoint_capacity_);
    return checkpoint_ + (ray_slot * 2 + buffer) * checkpoint_stride_ + index * checkpoint_entry_bytes_;
  }
  std::uint64_t checkpoint_entry_bytes() const { return checkpoint_entry_bytes_; }
  /// First byte of a bin of a ray slot (traces::CheckpointBins). Bins are aligned to lines and equally spaced.
  std::uint64_t checkpoint_bin(std::uint64_t ray_slot, unsigned bin) const {
    assert(checkpoint_stride_ != 0 && bin < checkpoint_lists_);
    return checkpoint_ + (ray_slot * checkpoint_lists_ + bin) * checkpoint_stride_;
  }
  /// First byte of entry `index` of a ray slot's eviction buffer. Wraps around at the capacity, so that
  /// addresses stay inside even if a ray evicts more than expected.
  std::uint64_t eviction_entry(std::uint64_t ray_slot, std::uint64_t index) const {
    assert(eviction_stride_ != 0);
    const std::uint64_t entry = index < eviction_capacity_ ? index : index % eviction_capacity_;
    if (evictions_ == RayArrayLayout::by_ray) {
      return eviction_ + ray_slot * eviction_stride_ + entry * eviction_entry_bytes_;
    }
    return eviction_ + ray_slot / warp_size_ * eviction_stride_ +
           (entry * warp_size_ + ray_slot % warp_size_) * eviction_entry_bytes_;
  }
  /// Sector `index` of a ray slot's stack area; wraps around like the eviction buffer.
  std::uint64_t stack_sector(std::uint64_t ray_slot, std::uint64_t index) const {
    assert(stack_sectors_ != 0);
    return stack_ + ray_slot * stack_stride_ + index % stack_sectors_ * kSectorBytes;
  }
  /// First byte of a pixel's 16 B in the frame buffer, which also hold the ray state.
  std::uint64_t pixel(std::uint32_t pixel) const { return pixel_ + static_cast<std::uint64_t>(pixel) * kPixelBytes; }
  std::uint64_t ray_slot(unsigned sm, unsigned warp_slot, unsigned lane) const {
    return this->warp_slot(sm, warp_slot) * warp_size_ + lane;
  }
  std::uint64_t warp_slot(unsigned sm, unsigned slot) const {
    return static_cast<std::uint64_t>(sm) * resident_warps_ + slot;
  }
  /// Words of an entry of a k-buffer: t, id, and with opacity_bound alpha. An evicted entry has as many.
  static unsigned hit_fields(const traces::Header& header) {
    return header.opacity_bound == traces::OpacityBound::on ? 3 : 2;
  }
  unsigned hit_fields() const { return k_fields_; }
  std::uint64_t eviction_entry_bytes() const { return eviction_entry_bytes_; }
  std::uint64_t eviction_capacity() const { return eviction_capacity_; }  ///< entries per ray; 0 without checkpointing
  std::uint64_t bytes() const { return end_; }
  /// Name, first byte and size of a region, for the headers of output files.
  struct Extent {
    std::string name;
    std::uint64_t base;
    std::uint64_t bytes;
  };
  const std::vector<Extent>& extents() const { return extents_; }

  static constexpr std::uint64_t kPixelBytes = 16;  ///< colour and transmittance, 4 floats
  static constexpr std::uint64_t kShapeBytes = 48;  ///< three rows of four floats
  static constexpr std::uint64_t kMeanBytes = 12;   ///< of a Gaussian record, which begins with it

 private:
  std::uint64_t gaussian_bytes_, sh_bytes_;  ///< sizes of one record
  std::uint64_t gaussians_;
  unsigned k_;  ///< entries of a k-buffer
  unsigned k_fields_;
  std::uint64_t eviction_entry_bytes_;
  RayArrayLayout k_buffers_, evictions_;
  unsigned warp_size_, resident_warps_;
  std::uint64_t gaussian_ = 0, shape_ = 0, sh_ = 0, k_buffer_ = 0, checkpoint_ = 0, eviction_ = 0, pixel_ = 0, end_ = 0;
  std::uint64_t checkpoint_capacity_ = 0;  ///< entries of one list
  std::uint64_t checkpoint_lists_ = 0;     ///< lists per ray: two buffers, or the bins
  std::uint64_t checkpoint_stride_ = 0;    ///< bytes from one list to the next
  std::uint64_t checkpoint_entry_bytes_;
  std::uint64_t eviction_capacity_ = 0;                             ///< entries per ray
  std::uint64_t eviction_stride_ = 0;                               ///< bytes per ray (by_ray) or warp (by_lane)
  std::uint64_t stack_ = 0, stack_sectors_ = 0, stack_stride_ = 0;  ///< stack areas
  std::uint64_t colour_ = 0;                                        ///< tables of colours
  std::vector<Extent> extents_;
};

}  // namespace grtx::modules
