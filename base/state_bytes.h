// SPDX-License-Identifier: Apache-2.0
// Model state as bytes, from which another process continues: little-endian numbers and texts, read in the order in
// which they were written.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "grtx/base/error.h"

namespace grtx {

class StateWriter {
 public:
  template <std::unsigned_integral Number>
  void put(Number value) {
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      bytes_ += static_cast<char>(std::uint64_t{value} >> 8 * i & 0xFF);
    }
  }
  void text(std::string_view text) {
    put(std::uint64_t{text.size()});
    bytes_ += text;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Throws Error{path, "byte N", rule} for malformed bytes.
class StateReader {
 public:
  /// path: for messages.
  StateReader(std::string path, std::string bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {}

  /// Reads a number; throws Error if it exceeds `most`.
  template <std::unsigned_integral Number>
  Number get(Number most = std::numeric_limits<Number>::max()) {
    require(sizeof(Number) <= bytes_.size() - at_, "ends too early");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[at_ + i])} << 8 * i;
    }
    require(value <= most, "a number is larger than it can be");
    at_ += sizeof(Number);
    return static_cast<Number>(value);
  }
  std::string text() {
    const auto size = get<std::uint64_t>();
    require(size <= bytes_.size() - at_, "ends too early");
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  void require(bool holds, const char* rule) const {
    if (!holds) throw Error(path_, "byte " + std::to_string(at_), rule);
  }
  void require_end() const { require(at_ == bytes_.size(), "is longer than its state"); }

 private:
  std::string path_, bytes_;
  std::size_t at_ = 0;
};

}  // namespace grtx
