// SPDX-License-Identifier: Apache-2.0
// Little-endian numbers and varints in byte strings, and a bounds-checked reader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace grtx::traces {

using Bytes = std::vector<std::uint8_t>;

/// Thrown for bytes that break a rule of the format. Caught where file and offset are known, and rethrown as
/// grtx::Error.
class Malformed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline void put_u32(Bytes& out, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
inline void put_u64(Bytes& out, std::uint64_t value) {
  for (unsigned i = 0; i < 8; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
inline std::uint32_t load_u32(const std::uint8_t* bytes) {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  return value;
}
inline std::uint64_t load_u64(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (unsigned i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  return value;
}

/// LEB128: seven bits per byte, low bits first, high bit set on all bytes but the last.
inline void put_varint(Bytes& out, std::uint64_t value) {
  while (value >= 0x80) {
    out.push_back(static_cast<std::uint8_t>(value | 0x80));
    value >>= 7;
  }
  out.push_back(static_cast<std::uint8_t>(value));
}

/// The same into a buffer with enough room, which is not checked. Returns the end.
inline std::uint8_t* store_varint(std::uint8_t* at, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) *at++ = static_cast<std::uint8_t>(value | 0x80);
  *at++ = static_cast<std::uint8_t>(value);
  return at;
}

/// Maps signed numbers to unsigned ones for varints: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
inline std::uint64_t zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}
inline std::int64_t unzigzag(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

/// Reads a byte string from front to back. Throws Malformed, with the string's name, if it ends too early.
class ByteReader {
 public:
  ByteReader() = default;
  ByteReader(const std::uint8_t* begin, std::size_t size, const char* name)
      : next_(begin), end_(begin + size), name_(name) {}

  std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }
  const std::uint8_t* position() const { return next_; }

  std::uint8_t u8() {
    if (next_ == end_) ends_early();
    return *next_++;
  }
  std::uint64_t varint() {
    if (next_ != end_ && *next_ < 0x80) return *next_++;
    return long_varint();
  }
  /// A varint; throws Malformed if it exceeds `limit`.
  std::uint64_t varint(std::uint64_t limit) {
    const std::uint64_t value = varint();
    if (value > limit) fail("holds a number beyond its limit");
    return value;
  }
  void skip(std::size_t count) {
    if (count > remaining()) ends_early();
    next_ += count;
  }
  void expect_end() const {
    if (next_ != end_) fail("has bytes after its end");
  }
  [[noreturn]] void fail(const char* rule) const { throw Malformed(std::string(name_) + " " + rule); }

 private:
  [[noreturn]] void ends_early() const { fail("ends too early"); }
  std::uint64_t long_varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const std::uint8_t byte = u8();
      if (shift == 63 && byte > 1) fail("holds a varint of more than 64 bits");
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) {
        if (byte == 0 && shift > 0) fail("holds a varint with padding");
        return value;
      }
    }
    fail("holds a varint of more than 64 bits");
  }

  const std::uint8_t* next_ = nullptr;
  const std::uint8_t* end_ = nullptr;
  const char* name_ = "";
};

/// Converts a value computed from data of `from` to 32 bits. Throws Malformed if it does not fit.
inline std::uint32_t checked_u32(const ByteReader& from, std::int64_t value) {
  if (value < 0 || value > std::numeric_limits<std::uint32_t>::max()) from.fail("leaves 32 bits");
  return static_cast<std::uint32_t>(value);
}

}  // namespace grtx::traces
