// SPDX-License-Identifier: Apache-2.0
// Varints: seven bits per byte, one form for each number, nothing beyond 64 bits.
#include <gtest/gtest.h>

#include <limits>

#include "grtx/traces/byte_stream.h"

namespace grtx::traces {
namespace {

TEST(Varint, RoundTripAtEveryLength) {
  for (unsigned bits = 0; bits <= 64; ++bits) {
    for (const std::uint64_t delta : {0U, 1U}) {
      const std::uint64_t value = (bits == 64 ? 0 : 1ULL << bits) - delta;
      Bytes bytes;
      put_varint(bytes, value);
      ByteReader reader(bytes.data(), bytes.size(), "test");
      EXPECT_EQ(reader.varint(), value);
      EXPECT_EQ(reader.remaining(), 0U);
    }
  }
}

TEST(Varint, ZigzagOrdersByMagnitude) {
  EXPECT_EQ(zigzag(0), 0U);
  EXPECT_EQ(zigzag(-1), 1U);
  EXPECT_EQ(zigzag(1), 2U);
  for (const std::int64_t value :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(), std::int64_t{-12345}}) {
    EXPECT_EQ(unzigzag(zigzag(value)), value);
  }
}

TEST(Varint, RefusesPaddingOverflowAndEnd) {
  for (const Bytes& bytes : {Bytes{0x80, 0x00}, Bytes(11, 0xFF), Bytes{0x80}, Bytes{},
                             Bytes{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02}}) {
    ByteReader reader(bytes.data(), bytes.size(), "test");
    EXPECT_THROW(reader.varint(), Malformed);
  }
}

}  // namespace
}  // namespace grtx::traces
