#include "grtx/modules/rt_unit/checkpoint_entry.h"

#include <algorithm>
#include <bit>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/checkpoint_config.h"

namespace grtx::modules {
namespace {

constexpr unsigned kNumberBits = 32;  ///< of an entry of 8 B; 32 more are t

/// Of the numbers of all units in so many bytes.
unsigned bits_of(const traces::Header& header, std::uint64_t bytes) {
  const std::uint64_t unit = header.node_sizes().unit();
  const std::uint64_t units = (bytes + unit - 1) / unit;
  return static_cast<unsigned>(std::bit_width(std::max<std::uint64_t>(units, 1) - 1));
}

}  // namespace

CheckpointEntrySplit checkpoint_entry_split(const traces::Header& header) {
  if (!header.two_level) return {bits_of(header, header.node_image_bytes), 0};
  return {bits_of(header, header.blas_base), bits_of(header, header.node_image_bytes - header.blas_base)};
}

void require_entry_fits(unsigned entry_bytes, const traces::Header& header) {
  if (!CheckpointConfig::allows_entry_bytes(entry_bytes)) {
    throw Error("configuration", "rt.checkpoint.entry_bytes", "must be 8, 16 or 20");
  }
  if (entry_bytes == 20) return;
  const CheckpointEntrySplit split = checkpoint_entry_split(header);
  // 16 B: two numbers of 32 bits. 8 B: both numbers in 32 bits.
  const unsigned needed =
      entry_bytes == 8 ? split.node_bits + split.blas_bits : bits_of(header, header.node_image_bytes);
  if (needed <= kNumberBits) return;
  const std::string parts = entry_bytes == 8 && header.two_level
                                ? std::to_string(split.node_bits) + " + " + std::to_string(split.blas_bits)
                                : std::to_string(needed);
  throw Error("configuration", "rt.checkpoint.entry_bytes",
              std::to_string(entry_bytes) + " B cannot name the trace's nodes, which need " + parts +
                  " bits where the entry has 32");
}

}  // namespace grtx::modules
