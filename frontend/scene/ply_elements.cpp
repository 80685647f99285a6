// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/ply_elements.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "grtx/base/error.h"
#include "grtx/frontend/scene/float_rounding.h"

namespace grtx::frontend {
namespace {

template <typename T>
T load(const char* at, bool swap) {
  unsigned char raw[sizeof(T)];
  std::memcpy(raw, at, sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

template <typename Source, typename Target>
void copy_column(const char* first, std::size_t row_bytes, std::size_t rows, bool swap, Target* out,
                 std::size_t stride) {
  if (swap) {
    for (std::size_t i = 0; i < rows; ++i)
      out[i * stride] = static_cast<Target>(load<Source>(first + i * row_bytes, true));
  } else {
    for (std::size_t i = 0; i < rows; ++i)
      out[i * stride] = static_cast<Target>(load<Source>(first + i * row_bytes, false));
  }
}

// Copies one property of `rows` rows, the first at `first`, to the column's rows from `row` on.
void copy_rows(const PlyColumn& column, PlyType type, const char* first, std::size_t row_bytes, std::size_t row,
               std::size_t rows, bool swap) {
  std::visit(
      [&](auto* out) {
        auto* to = out + row * column.stride;
        with_type(type, [&]<typename T>(T) { copy_column<T>(first, row_bytes, rows, swap, to, column.stride); });
      },
      column.out);
}

// Number of entries of a binary list; a negative count becomes a number too large for any file.
std::uint64_t list_length(const char* at, PlyType type, bool swap) {
  double length = 0.0;
  copy_rows(PlyColumn{0, &length, 1}, type, at, 0, 0, 1, swap);
  return length < 0.0 ? std::numeric_limits<std::uint64_t>::max() : static_cast<std::uint64_t>(length);
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

// Takes the next word off the front of `line`; empty when there is none.
std::string_view take_word(std::string_view& line) {
  std::size_t begin = 0;
  while (begin < line.size() && is_blank(line[begin])) ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end])) ++end;
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

std::string_view take_line(std::string_view bytes, std::size_t& at) {
  const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
  const std::string_view line = bytes.substr(at, end - at);
  at = std::min(end + 1, bytes.size());
  return line;
}

bool parse_number(std::string_view word, double& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return false;
  if (error == std::errc::result_out_of_range)
    value = std::strtod(std::string(word).c_str(), nullptr);  // underflow or overflow: 0 or infinity
  return error == std::errc() || error == std::errc::result_out_of_range;
}

bool fits(PlyType type, double value) {
  return with_type(type, [value]<typename T>(T) {
    using Limits = std::numeric_limits<T>;
    return !Limits::is_integer || (value >= Limits::min() && value <= Limits::max() && value == std::floor(value));
  });
}

void store(const PlyColumn& column, PlyType type, std::size_t row, double value) {
  // Rounds to the declared type first, so that ASCII and binary files of the same values give the same scene.
  if (type == PlyType::f32) value = round_to_float(value);
  std::visit(
      [&](auto* out) {
        using Target = std::remove_pointer_t<decltype(out)>;
        if constexpr (std::is_same_v<Target, std::uint32_t>) {
          out[row * column.stride] = static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
        } else {
          out[row * column.stride] = static_cast<Target>(value);
        }
      },
      column.out);
}

}  // namespace

PlyElements::PlyElements(std::string_view bytes, const PlyHeader& header, std::string file)
    : bytes_(bytes), header_(header), file_(std::move(file)) {
  std::size_t at = header.data_begin;
  std::size_t line = header.lines + 1;
  for (const PlyElement& element : header.elements) {
    begin_.push_back(at);
    first_line_.push_back(line);
    if (element.properties.empty()) continue;  // its rows take no bytes
    if (header.format == PlyFormat::ascii) {
      for (std::uint64_t row = 0; row < element.rows; ++row) {
        if (at == bytes.size()) fail_short(element, row);
        take_line(bytes, at);
        ++line;
      }
    } else if (element.has_list()) {
      for (std::uint64_t row = 0; row < element.rows; ++row) at = binary_row_end(element, at, row);
    } else {
      const std::uint64_t rows_left = (bytes.size() - at) / element.row_bytes();
      if (element.rows > rows_left) fail_short(element, rows_left);
      at += static_cast<std::size_t>(element.rows) * element.row_bytes();
    }
  }
  const std::string_view rest = bytes.substr(at);
  const bool only_space = rest.find_first_not_of(" \t\r\n") == std::string_view::npos;
  trailing_ = header.format == PlyFormat::ascii && only_space ? 0 : rest.size();
}

void PlyElements::fail_short(const PlyElement& element, std::uint64_t row) const {
  throw Error(file_, "byte " + std::to_string(bytes_.size()),
              "the file ends in row " + std::to_string(row) + " of the " + std::to_string(element.rows) +
                  " rows of element \"" + element.name + "\"");
}

std::size_t PlyElements::binary_row_end(const PlyElement& element, std::size_t row_begin, std::uint64_t row) const {
  const bool swap = header_.format == PlyFormat::binary_big_endian;
  std::size_t at = row_begin;
  for (const PlyProperty& property : element.properties) {
    std::uint64_t entries = 1;
    if (property.list_count) {
      const std::size_t count_bytes = size_in_bytes(*property.list_count);
      if (bytes_.size() - at < count_bytes) fail_short(element, row);
      entries = list_length(bytes_.data() + at, *property.list_count, swap);
      at += count_bytes;
    }
    if (entries > (bytes_.size() - at) / size_in_bytes(property.type)) fail_short(element, row);
    at += static_cast<std::size_t>(entries) * size_in_bytes(property.type);
  }
  return at;
}

void PlyElements::read(std::size_t element, const std::vector<PlyColumn>& columns) const {
  if (header_.format == PlyFormat::ascii) {
    read_ascii_rows(element, columns);
  } else if (header_.elements[element].has_list()) {
    read_list_rows(element, columns);
  } else {
    read_fixed_rows(element, columns);
  }
}

void PlyElements::read_fixed_rows(std::size_t element, const std::vector<PlyColumn>& columns) const {
  const PlyElement& layout = header_.elements[element];
  const std::size_t row_bytes = layout.row_bytes();
  const std::size_t rows = static_cast<std::size_t>(layout.rows);
  const bool swap = header_.format == PlyFormat::binary_big_endian;
  std::vector<std::size_t> offset;
  std::size_t offset_here = 0;
  for (const PlyProperty& p : layout.properties) {
    offset.push_back(offset_here);
    offset_here += size_in_bytes(p.type);
  }
  // Column by column within blocks of rows that stay in the cache.
  constexpr std::size_t kBlockRows = 128;
  for (std::size_t row = 0; row < rows; row += kBlockRows) {
    const std::size_t block = std::min(kBlockRows, rows - row);
    const char* first = bytes_.data() + begin_[element] + row * row_bytes;
    for (const PlyColumn& column : columns) {
      const PlyType type = layout.properties[column.property].type;
      copy_rows(column, type, first + offset[column.property], row_bytes, row, block, swap);
    }
  }
}

void PlyElements::read_list_rows(std::size_t element, const std::vector<PlyColumn>& columns) const {
  const PlyElement& layout = header_.elements[element];
  const bool swap = header_.format == PlyFormat::binary_big_endian;
  std::vector<std::size_t> offset(layout.properties.size());
  std::size_t at = begin_[element];
  for (std::size_t row = 0; row < layout.rows; ++row) {
    for (std::size_t p = 0; p < layout.properties.size(); ++p) {  // in range: the constructor has checked all rows
      const PlyProperty& property = layout.properties[p];
      std::size_t entries = 1;
      if (property.list_count) {
        entries = static_cast<std::size_t>(list_length(bytes_.data() + at, *property.list_count, swap));
        at += size_in_bytes(*property.list_count);
      }
      offset[p] = at;
      at += entries * size_in_bytes(property.type);
    }
    for (const PlyColumn& column : columns) {
      const PlyType type = layout.properties[column.property].type;
      copy_rows(column, type, bytes_.data() + offset[column.property], 0, row, 1, swap);
    }
  }
}

void PlyElements::read_ascii_rows(std::size_t element, const std::vector<PlyColumn>& columns) const {
  const PlyElement& layout = header_.elements[element];
  std::vector<const PlyColumn*> column_of(layout.properties.size(), nullptr);
  for (const PlyColumn& column : columns) column_of[column.property] = &column;
  std::size_t at = begin_[element];
  for (std::size_t row = 0; row < layout.rows; ++row) {
    std::string_view line = take_line(bytes_, at);
    const auto fail = [&](const std::string& rule) {
      throw Error(file_, "line " + std::to_string(first_line_[element] + row), rule);
    };
    const auto next_number = [&](const PlyProperty& property, PlyType type) {
      const std::string_view word = take_word(line);
      if (word.empty()) fail("has no value for the property \"" + property.name + "\"");
      double value = 0.0;
      if (!parse_number(word, value)) fail("has a value that is no number for the property \"" + property.name + "\"");
      if (!fits(type, value)) fail("has a value outside the type of the property \"" + property.name + "\"");
      return value;
    };
    for (std::size_t p = 0; p < layout.properties.size(); ++p) {
      const PlyProperty& property = layout.properties[p];
      if (property.list_count) {
        const double length = next_number(property, *property.list_count);
        if (length < 0.0) fail("has a negative list length for the property \"" + property.name + "\"");
        for (double i = 0.0; i < length; ++i) next_number(property, property.type);
        continue;
      }
      const double value = next_number(property, property.type);
      if (column_of[p] != nullptr) store(*column_of[p], property.type, row, value);
    }
    if (!take_word(line).empty()) fail("has more values than the element \"" + layout.name + "\" has properties");
  }
}

}  // namespace grtx::frontend
