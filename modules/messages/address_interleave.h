// Which L2 slice (and DRAM channel) an address belongs to, and its address inside that slice.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/parameter.h"

namespace grtx::modules {

struct AddressInterleave {
  unsigned slices = 4;
  unsigned bytes = 256;   ///< a power of two
  bool xor_hash = false;  ///< needs 2^n slices
  void parameters(ParameterList& list) {
    list.add("slices", slices, {1, 256}, "slices", "L2 slices = DRAM channels",
             assumed("this project: 4 x 28 GB/s; the paper gives no count"));
    list.add("interleave_bytes", bytes, {128, 1 << 20}, "B", "consecutive bytes of one slice", kGpgpuSim);
    list.add("xor_hash", xor_hash, "higher address bits are folded into the slice number", kOurs);
  }

  /// Throws Error for an impossible combination.
  void check() const {
    const auto require = [](bool holds, const char* rule) {
      if (!holds) throw Error("configuration", "address interleave", rule);
    };
    require(slices >= 1, "there must be at least one slice");
    require(std::has_single_bit(bytes) && bytes >= 128, "the interleave must be a power of two, at least a 128 B line");
    require(!xor_hash || std::has_single_bit(slices), "the XOR hash needs a power of two of slices");
  }
  /// Slice of a byte address, in [0, slices).
  unsigned slice(std::uint64_t address) const {
    const std::uint64_t block = address >> std::countr_zero(bytes);
    if (!xor_hash) return static_cast<unsigned>(std::has_single_bit(slices) ? block & (slices - 1) : block % slices);
    return static_cast<unsigned>(fold(block)) & (slices - 1);
  }
  /// Address inside its slice: blocks of one slice packed together. With the XOR hash too, since for given higher bits
  /// the slice number is a permutation of the low ones.
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

 private:
  std::uint64_t fold(std::uint64_t block) const {
    assert(std::has_single_bit(slices));
    const int width = std::countr_zero(slices);
    std::uint64_t folded = 0;
    for (std::uint64_t rest = block; width > 0 && rest != 0; rest >>= width) folded ^= rest;
    return folded;
  }
};

}  // namespace grtx::modules
