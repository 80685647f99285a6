// SPDX-License-Identifier: Apache-2.0
// Codes the Gaussians that the rays of a group processed: a list of the distinct ones, and for each entry of a ray
// whether it also followed the preceding entry's Gaussian the last time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/event.h"

namespace grtx::traces {

/// Reuses its memory for the next group.
class ProcessedEncoder {
 public:
  /// Removes all rays.
  void clear();
  /// Adds the entries of the next ray.
  void add(std::span<const Processed> entries);
  /// Fills the columns of processed entries. Returns the number of distinct Gaussians.
  std::size_t put(ColumnWriter& columns);

 private:
  void put_ray(ColumnWriter& columns, std::span<const Processed> entries);
  std::uint32_t position_of(std::uint32_t gaussian) const;

  std::vector<Processed> processed_;      ///< entries of all rays
  std::vector<std::size_t> ends_;         ///< [ray] end of its entries in processed_
  std::vector<std::uint32_t> gaussians_;  ///< distinct, ascending
  std::vector<std::uint32_t> successor_;  ///< [position] position that followed it last; last element: start of a ray
};

/// Inverse of ProcessedEncoder. Throws Malformed.
class ProcessedDecoder {
 public:
  /// Reads the list of `count` distinct Gaussians.
  void begin(std::uint64_t count, ColumnReaders& readers);
  /// Appends the `count` entries of the next ray.
  void take_ray(std::uint64_t count, ColumnReaders& readers, std::vector<Processed>& processed);

 private:
  std::vector<std::uint32_t> gaussians_;
  std::vector<std::uint32_t> successor_;  ///< as in ProcessedEncoder
};

}  // namespace grtx::traces
