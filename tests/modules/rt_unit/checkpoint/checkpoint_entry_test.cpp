// SPDX-License-Identifier: Apache-2.0
// What entries of 8 and 16 B can name: bits by the size of the structure, and what is too large.
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_entry.h"

#include <gmock/gmock.h>

#include "grtx/base/error.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {
namespace {

constexpr std::uint64_t kUnit = traces::kNodeUnit;

traces::Header structure(std::uint64_t units, std::uint64_t blas_units = 0) {
  traces::Header header;
  header.node_image_bytes = (units + blas_units) * kUnit;
  header.two_level = blas_units != 0;
  header.blas_base = header.two_level ? units * kUnit : 0;
  return header;
}

struct Case {
  std::uint64_t units, blas_units;
  unsigned node_bits, blas_bits;
};

TEST(CheckpointEntrySplit, HasTheFewestBitsThatNumberAllUnits) {
  for (const Case& c : {Case{2, 0, 1, 0}, Case{1024, 0, 10, 0}, Case{1025, 0, 11, 0}, Case{1024, 32, 10, 5},
                        Case{1025, 33, 11, 6}, Case{1 << 25, 128, 25, 7}}) {
    SCOPED_TRACE(c.units);
    const CheckpointEntrySplit split = checkpoint_entry_split(structure(c.units, c.blas_units));
    EXPECT_EQ(split.node_bits, c.node_bits);
    EXPECT_EQ(split.blas_bits, c.blas_bits);
    // The largest number of each fits, and one bit less would not do.
    EXPECT_EQ((c.units - 1) >> split.node_bits, 0u);
    EXPECT_NE((c.units - 1) >> (split.node_bits - 1), 0u);
  }
}

TEST(CheckpointEntrySplit, TheOnlyUnitNeedsNoBits) {
  EXPECT_EQ(checkpoint_entry_split(structure(1)).node_bits, 0u);
  EXPECT_EQ(checkpoint_entry_split(structure(1, 1)).node_bits, 0u);
  EXPECT_EQ(checkpoint_entry_split(structure(1, 1)).blas_bits, 0u);
}

TEST(CheckpointEntry, OfTwentyBytesNamesAnything) {
  EXPECT_NO_THROW(require_entry_fits(20, structure(std::uint64_t{1} << 40, 1 << 20)));
}

TEST(CheckpointEntry, TakesStructuresUpToItsBitsAndRefusesOneUnitMore) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32;
  EXPECT_NO_THROW(require_entry_fits(16, structure(kMost)));
  EXPECT_THROW(require_entry_fits(16, structure(kMost + 1)), Error);
  EXPECT_NO_THROW(require_entry_fits(16, structure(kMost - 128, 128)));
  EXPECT_NO_THROW(require_entry_fits(8, structure(kMost)));
  EXPECT_THROW(require_entry_fits(8, structure(kMost + 1)), Error);
  EXPECT_NO_THROW(require_entry_fits(8, structure(1 << 25, 128)));
  EXPECT_THROW(require_entry_fits(8, structure((1 << 25) + 1, 128)), Error);
  EXPECT_THROW(require_entry_fits(8, structure(1 << 25, 129)), Error);
}

/// A scene TLAS of so many units, objects up to unit 1 << 20, a BLAS of 32.
traces::Header placed(std::uint64_t scene_units) {
  traces::Header header = structure(std::uint64_t{1} << 20, 32);
  header.object_roots = {(scene_units + 1) * kUnit};
  return header;
}

TEST(CheckpointEntry, NamesTheLeafOfTheSceneTlasInBitsThatWereFree) {
  EXPECT_EQ(checkpoint_entry_split(placed(128)).scene_bits, 7u);
  EXPECT_EQ(checkpoint_entry_split(structure(1 << 20, 32)).scene_bits, 0u);
  EXPECT_NO_THROW(require_entry_fits(8, placed(128)));  // 20 + 5 + 7
  EXPECT_THROW(require_entry_fits(8, placed(129)), Error);
  EXPECT_NO_THROW(require_entry_fits(16, placed(1 << 12)));
  EXPECT_THROW(require_entry_fits(16, placed((1 << 12) + 1)), Error);
  EXPECT_NO_THROW(require_entry_fits(20, placed(1 << 24)));
  EXPECT_THROW(require_entry_fits(20, placed((1 << 24) + 1)), Error);
  EXPECT_NO_THROW(require_entry_fits(28, placed((1 << 24) + 1)));
  try {
    require_entry_fits(8, placed(129));
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("20 + 5 + 8 bits where the entry has 32"));
  }
}

TEST(CheckpointEntry, SaysHowManyBitsAreMissing) {
  EXPECT_THAT([&] { require_entry_fits(8, structure((1 << 25) + 1, 128)); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("26 + 7 bits where the entry has 32")));
}

TEST(CheckpointEntry, HasEightSixteenTwentyOrTwentyEightBytes) {
  for (const unsigned bytes : {4u, 12u, 24u, 32u})
    EXPECT_THROW(require_entry_fits(bytes, structure(64)), Error) << bytes;
}

}  // namespace
}  // namespace grtx::modules
