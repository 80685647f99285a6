// The Gaussians that the rays of a group processed: a list of the distinct ones, and for each entry of a ray whether it
// is the one that followed its predecessor last time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/event.h"

namespace grtx::traces {

/// Keeps its memory.
class ProcessedEncoder {
 public:
  /// Forgets all rays.
  void clear();
  /// The entries of the next ray.
  void add(std::span<const Processed> entries);
  /// Fills the columns of processed entries. Returns how many distinct Gaussians there are.
  std::size_t put(ColumnWriter& columns);

 private:
  void put_ray(ColumnWriter& columns, std::span<const Processed> entries);
  std::uint32_t position_of(std::uint32_t gaussian) const;

  std::vector<Processed> processed_;      ///< of all rays
  std::vector<std::size_t> ends_;         ///< of each ray
  std::vector<std::uint32_t> gaussians_;  ///< distinct, ascending
  std::vector<std::uint32_t> successor_;  ///< what followed a Gaussian last time; last place: what began a ray
};

/// Undoes ProcessedEncoder. Throws Malformed.
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
