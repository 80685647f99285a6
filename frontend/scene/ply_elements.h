// SPDX-License-Identifier: Apache-2.0
// The rows of a PLY file's elements, in any of its three encodings, as columns of numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "grtx/frontend/scene/ply_header.h"

namespace grtx::frontend {

/// Destination of one property: that of row i is converted and stored at out[i * stride].
struct PlyColumn {
  std::size_t property = 0;                             ///< index in the element; must not be a list
  std::variant<float*, double*, std::uint32_t*> out{};  ///< uint32_t only for properties of an integer type
  std::size_t stride = 1;                               ///< entries from one row to the next
};

class PlyElements {
 public:
  /// Finds where each element starts. `bytes` (the whole file) and `header` must outlive this object.
  /// Throws Error when the file is too short for the rows that its header announces.
  PlyElements(std::string_view bytes, const PlyHeader& header, std::string file);

  /// Reads the named columns of one element; the others are skipped. Throws Error with line (ASCII) or byte.
  void read(std::size_t element, const std::vector<PlyColumn>& columns) const;

  /// Bytes behind the last element (ASCII: not counting white space).
  std::size_t trailing_bytes() const { return trailing_; }

 private:
  std::size_t binary_row_end(const PlyElement& element, std::size_t row_begin, std::uint64_t row) const;
  void read_fixed_rows(std::size_t element, const std::vector<PlyColumn>& columns) const;
  void read_list_rows(std::size_t element, const std::vector<PlyColumn>& columns) const;
  void read_ascii_rows(std::size_t element, const std::vector<PlyColumn>& columns) const;
  [[noreturn]] void fail_short(const PlyElement& element, std::uint64_t row) const;

  std::string_view bytes_;
  const PlyHeader& header_;
  std::string file_;
  std::vector<std::size_t> begin_;       ///< first byte of each element
  std::vector<std::size_t> first_line_;  ///< ASCII: number of its first line
  std::size_t trailing_ = 0;
};

}  // namespace grtx::frontend
