// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/messages/memory_map.h"

#include <algorithm>

#include "grtx/base/error.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/checkpoint_bins.h"

namespace grtx::modules {
namespace {

// Regions start on DRAM row boundaries, so that no burst straddles two regions.
constexpr std::uint64_t kAlignment = 4096;

// An eviction buffer holds at most the any-hit calls of one round that did not fit into the k-buffer. Their number is
// not in the header, so the default is the capacity of a checkpoint buffer (the paper sizes both together).
constexpr std::uint64_t kMinimumEvictions = 256;

// The same region holds a ray's list of delayed hits. What lies behind wraps around.
constexpr std::uint64_t kDelayedHits = 1024;

constexpr std::uint64_t kCacheLine = 128;

constexpr std::uint64_t kMostEntries = std::uint64_t{1}
                                       << 32;  ///< most entries of a ray's buffer, so that products fit 64 bits

std::uint64_t checked_entries(std::uint64_t entries, const char* name) {
  if (entries > kMostEntries) throw Error("memory map", name, "a ray's buffer has at most 2^32 entries");
  return entries;
}

constexpr std::uint64_t round_up(std::uint64_t bytes, std::uint64_t unit) { return (bytes + unit - 1) / unit * unit; }

// The rays of a warp fill their buffers at the same pace. With a stride of an even number of lines their current
// entries would map to the same few cache sets and DRAM banks; an odd number of lines spreads them.
constexpr std::uint64_t spread_stride(std::uint64_t bytes) {
  const std::uint64_t lines = (bytes + kCacheLine - 1) / kCacheLine;
  return (lines | 1) * kCacheLine;
}

}  // namespace

MemoryMap::MemoryMap(const traces::Header& header, const MemoryMapConfig& config)
    : gaussian_bytes_(header.gaussian_record_bytes),
      sh_bytes_(header.sh_record_bytes),
      gaussians_(header.gaussians),
      k_(header.tracing == traces::Tracing::single ? 2 * header.k : header.k),
      k_fields_(hit_fields(header)),
      eviction_entry_bytes_(traces::kEvictionEntryBytes + std::uint64_t{4} * (k_fields_ - 2)),
      k_buffers_(config.k_buffers),
      evictions_(config.evictions),
      warp_size_(header.warp_size),
      resident_warps_(config.resident_warps),
      checkpoint_entry_bytes_(config.checkpoint_entry_bytes) {
  const std::uint64_t warps = static_cast<std::uint64_t>(config.sms) * config.resident_warps;
  const std::uint64_t rays = warps * header.warp_size;
  std::uint64_t cursor = 0;
  const auto place = [&](const char* name, std::uint64_t bytes) {
    const std::uint64_t base = cursor;
    if (!lies_below(kAddressable, cursor, bytes)) {
      throw Error("memory map", name, "would end beyond the 128 GiB that the model addresses");
    }
    extents_.push_back({name, base, bytes});
    cursor = round_up(cursor + bytes, kAlignment);
    return base;
  };
  place("node_image", header.node_image_bytes);
  gaussian_ = place("gaussian", header.gaussians * gaussian_bytes_);
  if (!header.two_level && traces::has_box_leaves(header.accel)) {
    shape_ = place("shape", header.node_image_bytes / header.node_sizes().unit() * kShapeBytes);
  }
  sh_ = place("sh", header.gaussians * sh_bytes_);
  k_buffer_ = place("k_buffer", warps * k_ * k_fields_ * 4 * header.warp_size);
  if (header.checkpoint) {
    checkpoint_capacity_ = checked_entries(header.checkpoint_capacity, "checkpoint");
    checkpoint_lists_ = header.checkpoint_bins != 0 ? traces::CheckpointBins::rings_of(header.checkpoint_bins) : 2;
    checkpoint_stride_ = spread_stride(checkpoint_capacity_ * checkpoint_entry_bytes_);
    checkpoint_ = place("checkpoint", rays * checkpoint_lists_ * checkpoint_stride_);
  }
  if (header.checkpoint || header.any_hit == traces::AnyHit::delayed) {
    eviction_capacity_ = config.eviction_capacity != 0 ? config.eviction_capacity
                                                       : std::max(header.checkpoint_capacity, kMinimumEvictions);
    if (!header.checkpoint) eviction_capacity_ = kDelayedHits;
    checked_entries(eviction_capacity_, "eviction");
    const unsigned together = config.evictions == RayArrayLayout::by_ray ? 1 : header.warp_size;
    eviction_stride_ = spread_stride(eviction_capacity_ * eviction_entry_bytes_ * together);
    eviction_ = place("eviction", rays / together * eviction_stride_);
  }
  pixel_ = place("pixel", static_cast<std::uint64_t>(header.width) * header.height * kPixelBytes);
  if (config.stack_sectors != 0) {
    stack_sectors_ = config.stack_sectors;
    stack_stride_ = spread_stride(stack_sectors_ * kSectorBytes);
    stack_ = place("stack", rays * stack_stride_);
  }
  if (header.colour == traces::ColourPer::frame) {
    colour_ = place("colour", config.sms * gaussians_ * traces::kColourBytes);
  }
  end_ = cursor;
}

}  // namespace grtx::modules
