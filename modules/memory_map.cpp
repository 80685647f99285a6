#include "modules/memory_map.h"

#include <cassert>

namespace grtx::modules {
namespace {

// Regions start on DRAM row boundaries, so that no burst straddles two of them.
constexpr std::uint64_t kAlignment = 4096;

// An eviction buffer holds at most the any-hit calls of one round that did not fit; traces record the maximum only in
// their totals, so the region is sized as the checkpoint buffer is (the paper gives both together).
constexpr std::uint64_t kMinimumEvictions = 256;

constexpr std::uint64_t align(std::uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

}  // namespace

MemoryMap::MemoryMap(const traces::Header& header, const MemoryMapConfig& config) : header_(header), config_(config) {
  const std::uint64_t warps = static_cast<std::uint64_t>(config.sms) * config.resident_warps;
  const std::uint64_t rays = warps * header.warp_size;
  std::uint64_t cursor = 0;
  const auto place = [&](const char* name, std::uint64_t bytes) {
    const std::uint64_t base = cursor;
    extents_.push_back({name, base, bytes});
    cursor = align(cursor + bytes);
    return base;
  };
  place("node_image", header.node_image_bytes);
  gaussian_ = place("gaussian", header.gaussians * header.gaussian_record_bytes);
  sh_ = place("sh", header.gaussians * header.sh_record_bytes);
  k_buffer_ = place("k_buffer", warps * header.k * 2 * 4 * header.warp_size);
  if (header.checkpoint) {
    checkpoint_ = place("checkpoint", rays * 2 * header.checkpoint_capacity * traces::kCheckpointEntryBytes);
    eviction_capacity_ = header.checkpoint_capacity > kMinimumEvictions ? header.checkpoint_capacity : kMinimumEvictions;
    eviction_ = place("eviction", rays * eviction_capacity_ * traces::kEvictionEntryBytes);
  }
  pixel_ = place("pixel", static_cast<std::uint64_t>(header.width) * header.height * 16);
  end_ = cursor;
}

std::uint64_t MemoryMap::gaussian_record(std::uint32_t gaussian) const {
  return gaussian_ + gaussian * header_.gaussian_record_bytes;
}

std::uint64_t MemoryMap::sh_record(std::uint32_t gaussian) const { return sh_ + gaussian * header_.sh_record_bytes; }

std::uint64_t MemoryMap::k_buffer(std::uint64_t warp_slot, unsigned index, unsigned field, unsigned lane) const {
  assert(index < header_.k && field < 2);
  return k_buffer_ + (((warp_slot * header_.k + index) * 2 + field) * header_.warp_size + lane) * 4;
}

std::uint64_t MemoryMap::checkpoint_entry(std::uint64_t ray_slot, unsigned buffer, std::uint64_t index) const {
  assert(header_.checkpoint && buffer < 2 && index < header_.checkpoint_capacity);
  return checkpoint_ + ((ray_slot * 2 + buffer) * header_.checkpoint_capacity + index) * traces::kCheckpointEntryBytes;
}

std::uint64_t MemoryMap::eviction_entry(std::uint64_t ray_slot, std::uint64_t index) const {
  assert(header_.checkpoint);
  // The region wraps per ray: addresses stay inside even if a ray evicts more than was foreseen.
  return eviction_ + (ray_slot * eviction_capacity_ + index % eviction_capacity_) * traces::kEvictionEntryBytes;
}

std::uint64_t MemoryMap::pixel(std::uint32_t pixel) const { return pixel_ + static_cast<std::uint64_t>(pixel) * 16; }

std::uint64_t MemoryMap::ray_slot(unsigned sm, unsigned warp_slot, unsigned lane) const {
  return this->warp_slot(sm, warp_slot) * header_.warp_size + lane;
}

std::uint64_t MemoryMap::warp_slot(unsigned sm, unsigned slot) const {
  return static_cast<std::uint64_t>(sm) * config_.resident_warps + slot;
}

}  // namespace grtx::modules
