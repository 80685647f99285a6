// SPDX-License-Identifier: Apache-2.0
// Address interleaving: maps a global address to an L2 slice and a slice-local address, and slices to DRAM channels,
// which several slices may share.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>

#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {

struct AddressInterleave {
  unsigned slices = 4;
  unsigned bytes = 256;   ///< a power of two
  bool xor_hash = false;  ///< needs 2^n slices
  unsigned channels = 0;  ///< DRAM channels, a divisor of slices; 0: one per slice
  void parameters(ParameterList& list) {
    list.add("slices", slices, {1, 256}, "slices", "of the L2, each with a port of one sector per cycle",
             assumed("this project: 4 x 28 GB/s; the paper gives no count"));
    list.add("interleave_bytes", bytes, {128, 1 << 20}, "B", "consecutive bytes of one slice", kGpgpuSim);
    list.add("xor_hash", xor_hash, "higher address bits are folded into the slice number", kOurs);
    list.rule(
        "interleave_bytes", [this] { return std::has_single_bit(bytes); }, "must be a power of two");
    list.rule(
        "xor_hash", [this] { return !xor_hash || std::has_single_bit(slices); }, "needs a power of two of l2.slices");
  }
  void channel_parameters(ParameterList& list) {
    list.add("channels", channels, {0, 256}, "channels",
             "of the DRAM; each is shared by l2.slices / channels slices; 0: one per slice",
             assumed("this project: 4 x 28 GB/s; the paper gives no count"));
    list.rule(
        "channels", [this] { return slices % dram_channels() == 0; },
        "must divide l2.slices: each slice belongs to one channel");
  }

  /// Throws Error if a value is outside its range or breaks a rule of its key.
  void check() const {
    AddressInterleave copy = *this;
    ParameterList list;
    list.part("l2", copy);
    list.under("dram", [&](ParameterList& keys) { copy.channel_parameters(keys); });
    require_allowed(list);
  }
  // The functions below rely on check(): with other numbers addresses are wrong, which only asserts notice.

  /// Slice of a byte address, in [0, slices).
  unsigned slice(std::uint64_t address) const {
    const std::uint64_t block = address >> std::countr_zero(bytes);
    if (!xor_hash) return static_cast<unsigned>(std::has_single_bit(slices) ? block & (slices - 1) : block % slices);
    return static_cast<unsigned>(fold(block)) & (slices - 1);
  }
  /// Slice-local address: the blocks of a slice are packed together. Also valid with the XOR hash, because for fixed
  /// higher bits the slice number is a permutation of the low bits.
  std::uint64_t local(std::uint64_t address) const {
    const std::uint64_t block = address >> std::countr_zero(bytes);
    const std::uint64_t packed = std::has_single_bit(slices) ? block >> std::countr_zero(slices) : block / slices;
    return packed * bytes + (address & (bytes - 1));
  }
  /// Inverse of slice() and local().
  std::uint64_t global(std::uint64_t local_address, unsigned slice) const {
    const std::uint64_t block = local_address / bytes;
    const std::uint64_t low = xor_hash ? slice ^ (fold(block) & (slices - 1)) : slice;
    return (block * slices + low) * bytes + local_address % bytes;
  }

  unsigned dram_channels() const { return channels == 0 ? slices : channels; }
  unsigned slices_a_channel() const { return slices / dram_channels(); }
  /// Channel of a slice, in [0, dram_channels()).
  unsigned channel(unsigned slice) const { return slice % dram_channels(); }
  /// Channel-local address of a slice-local one: the blocks of the channel's slices alternate. Without the XOR hash
  /// they are in the order of their global addresses.
  std::uint64_t in_channel(std::uint64_t local_address, unsigned slice) const {
    if (channels == 0) return local_address;
    const std::uint64_t block = local_address / bytes * slices_a_channel() + slice / dram_channels();
    return block * bytes + local_address % bytes;
  }

 private:
  // The XOR of all groups of log2(slices) bits is in the lowest group; what the others hold is unspecified.
  std::uint64_t fold(std::uint64_t block) const {
    assert(std::has_single_bit(slices));
    if (slices == 1) return 0;
    for (int shift = std::countr_zero(slices); shift < 64; shift *= 2) block ^= block >> shift;
    return block;
  }
};

}  // namespace grtx::modules
