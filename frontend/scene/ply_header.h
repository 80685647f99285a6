// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: which elements follow, in which order, with which properties.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace grtx::frontend {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };
enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

/// Calls `f` with a value of the C++ type for `type`.
template <typename F>
auto with_type(PlyType type, F&& f) {
  switch (type) {
    case PlyType::i8:
      return f(std::int8_t{});
    case PlyType::u8:
      return f(std::uint8_t{});
    case PlyType::i16:
      return f(std::int16_t{});
    case PlyType::u16:
      return f(std::uint16_t{});
    case PlyType::i32:
      return f(std::int32_t{});
    case PlyType::u32:
      return f(std::uint32_t{});
    case PlyType::f32:
      return f(float{});
    default:
      return f(double{});
  }
}

std::size_t size_in_bytes(PlyType type);
bool is_integer(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;        ///< of the value, or of a list's entries
  std::optional<PlyType> list_count;  ///< type of a list's entry count; none: a single value
};

struct PlyElement {
  std::string name;
  std::uint64_t rows = 0;
  std::vector<PlyProperty> properties;

  bool has_list() const;
  /// Bytes per row in the binary formats; only for elements without lists.
  std::size_t row_bytes() const;
  std::optional<std::size_t> find(std::string_view property) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;
  std::size_t lines = 0;       ///< in the header, "ply" and "end_header" included
  std::size_t data_begin = 0;  ///< offset behind the newline of "end_header"

  std::optional<std::size_t> find(std::string_view element) const;
};

/// Lines may end in LF or CR LF. Throws Error with the line's number.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& file);

}  // namespace grtx::frontend
