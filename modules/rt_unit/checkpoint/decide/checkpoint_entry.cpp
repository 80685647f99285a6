// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_entry.h"

#include <algorithm>
#include <bit>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_config.h"

namespace grtx::modules {
namespace {

constexpr unsigned kNumberBits = 32;   ///< 8 B entry: for all node numbers; the other 32 bits are t
constexpr unsigned kSceneBits20 = 24;  ///< 20 B entry: scene leaf, above the instance leaf's 40-bit address
constexpr unsigned kSceneBits16 = 12;  ///< 16 B entry: scene leaf, between the sibling masks and the run flag

/// Number of bits to number all node units in `bytes`.
unsigned bits_of(const traces::Header& header, std::uint64_t bytes) {
  const std::uint64_t unit = header.node_sizes().unit();
  const std::uint64_t units = (bytes + unit - 1) / unit;
  return static_cast<unsigned>(std::bit_width(std::max<std::uint64_t>(units, 1) - 1));
}

}  // namespace

CheckpointEntrySplit checkpoint_entry_split(const traces::Header& header) {
  if (!header.two_level) return {bits_of(header, header.node_image_bytes), 0};
  return {bits_of(header, header.blas_base), bits_of(header, header.node_image_bytes - header.blas_base),
          header.three_level() ? bits_of(header, header.objects_base()) : 0};
}

void require_entry_fits(unsigned entry_bytes, const traces::Header& header) {
  if (!CheckpointConfig::allows_entry_bytes(entry_bytes)) {
    throw Error("configuration", "rt.checkpoint.entry_bytes", CheckpointConfig::kEntryBytesRule);
  }
  const CheckpointEntrySplit split = checkpoint_entry_split(header);
  const auto require = [&](const char* what, unsigned needed, unsigned bits, const std::string& parts) {
    if (needed <= bits) return;
    throw Error("configuration", "rt.checkpoint.entry_bytes",
                std::to_string(entry_bytes) + " B cannot name the trace's " + what + ", which need " + parts +
                    " bits where the entry has " + std::to_string(bits));
  };
  if (entry_bytes == 8) {  // all numbers share 32 bits
    std::string parts = std::to_string(split.node_bits);
    for (const unsigned bits : {split.blas_bits, split.scene_bits}) {
      if (bits != 0) parts += " + " + std::to_string(bits);
    }
    require("nodes", split.node_bits + split.blas_bits + split.scene_bits, kNumberBits, parts);
  }
  if (entry_bytes == 16) {  // two numbers of 32 bits and the scene leaf
    const unsigned node_bits = bits_of(header, header.node_image_bytes);
    require("nodes", node_bits, kNumberBits, std::to_string(node_bits));
    require("scene leaves", split.scene_bits, kSceneBits16, std::to_string(split.scene_bits));
  }
  if (entry_bytes == 20) require("scene leaves", split.scene_bits, kSceneBits20, std::to_string(split.scene_bits));
}

}  // namespace grtx::modules
