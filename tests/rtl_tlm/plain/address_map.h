// SPDX-License-Identifier: Apache-2.0
// Where things lie in memory, and which slice an address belongs to: docs/model/memory_map.md.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/address_interleave.h"
#include "grtx/traces/header.h"
#include "rtl_tlm/plain/messages.h"

namespace grtx::sim::plain {

class AddressMap {
 public:
  /// most_evictions: of a ray, as the trace's totals have it.
  /// stack_sectors: of a ray's stack area; 0: there is none. entry_bytes: of a checkpoint entry.
  /// k_by_ray, evictions_by_lane: as simt.k_buffer_layout and simt.eviction_layout say.
  AddressMap(const traces::Header& header, unsigned sms, unsigned slots, std::uint64_t most_evictions,
             std::uint64_t stack_sectors, std::uint64_t entry_bytes, bool k_by_ray, bool evictions_by_lane)
      : header_(header),
        slots_(slots),
        stack_sectors_(stack_sectors),
        entry_bytes_(entry_bytes),
        k_by_ray_(k_by_ray),
        evictions_by_lane_(evictions_by_lane) {
    const std::uint64_t warps = std::uint64_t{sms} * slots, rays = warps * header.warp_size;
    k_ = header.tracing == traces::Tracing::single ? 2 * header.k : header.k;
    place(header.node_image_bytes);
    gaussian_ = place(header.gaussians * header.gaussian_record_bytes);
    std::uint64_t unit = 64;  // of a node
    if (header.layout == traces::NodeLayout::compact) unit = 80;
    if (header.layout == traces::NodeLayout::quantised) unit = 32;
    if (header.accel == traces::AccelKind::box) shape_ = place(header.node_image_bytes / unit * 48);
    sh_ = place(header.gaussians * header.sh_record_bytes);
    if (header.opacity_bound == traces::OpacityBound::on) words_ = 3;
    k_buffer_ = place(warps * k_ * words_ * 4 * header.warp_size);
    if (header.checkpoint) {
      if (header.checkpoint_bins > 0) lists_ = header.checkpoint_bins + 1;
      checkpoint_stride_ = odd_lines(header.checkpoint_capacity * entry_bytes);
      checkpoint_ = place(rays * lists_ * checkpoint_stride_);
      evictions_ = std::max<std::uint64_t>({header.checkpoint_capacity, 256, most_evictions});
    } else if (header.any_hit == traces::AnyHit::delayed) {
      evictions_ = 1024;
    }
    if (evictions_ > 0) {
      eviction_stride_ = odd_lines(evictions_ * evicted_bytes() * (evictions_by_lane_ ? header.warp_size : 1));
      eviction_ = place((evictions_by_lane_ ? warps : rays) * eviction_stride_);
    }
    pixel_ = place(std::uint64_t{header.width} * header.height * 16);
    if (stack_sectors > 0) {
      stack_stride_ = odd_lines(stack_sectors * kSector);
      stack_ = place(rays * stack_stride_);
    }
    if (header.colour == traces::ColourPer::frame) colour_ = place(sms * header.gaussians * 8);
  }
  std::uint64_t gaussian(std::uint64_t id) const { return gaussian_ + id * header_.gaussian_record_bytes; }
  /// A hit in a leaf, whose address is in units, times 64: a record for each.
  std::uint64_t record_of_hit(std::uint64_t leaf) const { return gaussian(leaf / 64 % header_.gaussians); }
  std::uint64_t evicted_bytes() const { return words_ * 4; }
  unsigned words() const { return words_; }  ///< of an entry of a k-buffer
  /// leaf: address of the box in units, times 64.
  std::uint64_t shape(std::uint64_t leaf) const { return shape_ + leaf / 64 * 48; }
  std::uint64_t sh(std::uint64_t id) const { return sh_ + id * header_.sh_record_bytes; }
  std::uint64_t colour(unsigned sm, std::uint64_t id) const { return colour_ + (sm * header_.gaussians + id) * 8; }
  std::uint64_t pixel(std::uint64_t pixel) const { return pixel_ + pixel * 16; }
  std::uint64_t k_buffer(unsigned sm, unsigned slot, std::uint64_t entry, unsigned field, unsigned lane) const {
    if (k_by_ray_) return k_buffer_ + (ray(sm, slot, lane) * k_ + entry) * words_ * 4 + field * 4;
    return k_buffer_ + (((warp(sm, slot) * k_ + entry) * words_ + field) * header_.warp_size + lane) * 4;
  }
  std::uint64_t eviction(unsigned sm, unsigned slot, unsigned lane, std::uint64_t entry) const {
    if (evictions_by_lane_) {
      return eviction_ + warp(sm, slot) * eviction_stride_ +
             (entry % evictions_ * header_.warp_size + lane) * evicted_bytes();
    }
    return eviction_ + ray(sm, slot, lane) * eviction_stride_ + entry % evictions_ * evicted_bytes();
  }
  /// list: one of the two buffers, or a bin.
  std::uint64_t checkpoint(unsigned sm, unsigned slot, unsigned lane, unsigned list, std::uint64_t entry) const {
    return checkpoint_ + (ray(sm, slot, lane) * lists_ + list) * checkpoint_stride_ + entry * entry_bytes_;
  }
  std::uint64_t stack(unsigned sm, unsigned slot, unsigned lane, std::uint64_t sector) const {
    return stack_ + ray(sm, slot, lane) * stack_stride_ + sector % stack_sectors_ * kSector;
  }

 private:
  std::uint64_t warp(unsigned sm, unsigned slot) const { return std::uint64_t{sm} * slots_ + slot; }
  std::uint64_t ray(unsigned sm, unsigned slot, unsigned lane) const {
    return warp(sm, slot) * header_.warp_size + lane;
  }
  /// A region of so many bytes at the next multiple of 4 KiB.
  std::uint64_t place(std::uint64_t bytes) {
    const std::uint64_t base = end_;
    end_ = (end_ + bytes + 4095) / 4096 * 4096;
    return base;
  }
  /// The least odd number of 128 B lines that holds so many bytes.
  static std::uint64_t odd_lines(std::uint64_t bytes) {
    const std::uint64_t lines = (bytes + 127) / 128;
    return (lines % 2 == 0 ? lines + 1 : lines) * 128;
  }

  traces::Header header_;
  unsigned slots_;
  std::uint64_t stack_sectors_, entry_bytes_;
  bool k_by_ray_, evictions_by_lane_;
  std::uint64_t lists_ = 2;
  unsigned words_ = 2;
  std::uint64_t k_ = 0, evictions_ = 0, end_ = 0;
  std::uint64_t gaussian_ = 0, shape_ = 0, sh_ = 0, k_buffer_ = 0, checkpoint_ = 0, eviction_ = 0, pixel_ = 0,
                stack_ = 0, colour_ = 0;
  std::uint64_t checkpoint_stride_ = 0, eviction_stride_ = 0, stack_stride_ = 0;
};

/// Which slice, and where in it; which channel, and where in that.
class SliceMap {
 public:
  explicit SliceMap(const modules::AddressInterleave& config) : config_(config) {}
  unsigned slice(std::uint64_t address) const {
    std::uint64_t block = address / config_.bytes;
    if (!config_.xor_hash) return static_cast<unsigned>(block % config_.slices);
    unsigned folded = 0;  // all digits of the block number to the base of the slices, XORed
    for (; config_.slices > 1 && block != 0; block /= config_.slices)
      folded ^= static_cast<unsigned>(block % config_.slices);
    return folded;
  }
  std::uint64_t local(std::uint64_t address) const {
    return address / config_.bytes / config_.slices * config_.bytes + address % config_.bytes;
  }
  std::uint64_t global(std::uint64_t local, unsigned slice) const {
    const std::uint64_t block = local / config_.bytes;
    for (unsigned low = 0; low < config_.slices; ++low) {
      const std::uint64_t address = (block * config_.slices + low) * config_.bytes + local % config_.bytes;
      if (this->slice(address) == slice) return address;
    }
    return 0;  // does not happen
  }
  /// Slices of a channel.
  std::vector<unsigned> sharers(unsigned channel) const {
    std::vector<unsigned> all;
    for (unsigned slice = channel; slice < config_.slices; slice += channels()) all.push_back(slice);
    return all;
  }
  unsigned channels() const { return config_.channels == 0 ? config_.slices : config_.channels; }
  std::uint64_t in_channel(std::uint64_t address) const {
    const std::uint64_t blocks = local(address) / config_.bytes * (config_.slices / channels());
    return (blocks + slice(address) / channels()) * config_.bytes + address % config_.bytes;
  }

 private:
  modules::AddressInterleave config_;
};

}  // namespace grtx::sim::plain
