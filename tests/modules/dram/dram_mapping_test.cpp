// SPDX-License-Identifier: Apache-2.0
// Which bank and row a byte of a channel lies in.
#include "grtx/modules/dram/decide/dram_mapping.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

namespace grtx::modules {
namespace {

DramChannelConfig config(unsigned banks, unsigned groups = 1, unsigned row_bytes = 1024) {
  DramChannelConfig config;
  config.banks = banks;
  config.bank_groups = groups;
  config.group_bytes = 128;
  config.row_bytes = row_bytes;
  return config;
}

TEST(DramMapping, ConsecutiveRowsAreOfConsecutiveBanks) {
  // bank = address / row_bytes mod banks, row = address / (row_bytes x banks).
  for (const unsigned banks : {4u, 6u}) {  // shifts, and divisions
    const DramMapping mapping(config(banks));
    for (std::uint64_t number = 0; number < 3 * banks; ++number) {
      for (const std::uint64_t within : {0u, 1023u}) {
        const DramMapping::Place place = mapping.place(1024 * number + within);
        EXPECT_EQ(place.bank, number % banks) << banks << " banks, row number " << number;
        EXPECT_EQ(place.row, number / banks) << banks << " banks, row number " << number;
      }
    }
  }
}

TEST(DramMapping, ConsecutiveBlocksAreOfConsecutiveBankGroups) {
  const DramMapping mapping(config(8, 4));
  for (std::uint64_t block = 0; block < 16; ++block) {
    EXPECT_EQ(mapping.group(mapping.place(128 * block).bank), block % 4) << "block " << block;
  }
  // A row of 1,024 B has 8 blocks of its group, which are every fourth of the channel.
  EXPECT_EQ(mapping.place(0).bank, mapping.place(128 * 4 * 7).bank);
  EXPECT_NE(mapping.place(0).bank, mapping.place(128 * 4 * 8).bank);
}

TEST(DramMapping, LowBitsOfTheRowAreFoldedIntoTheBank) {
  DramChannelConfig folded = config(4);
  folded.bank_xor = true;
  const DramMapping mapping(folded);
  for (std::uint64_t row = 0; row < 8; ++row) {
    for (std::uint32_t bank = 0; bank < 4; ++bank) {
      const DramMapping::Place place = mapping.place(1024 * (4 * row + bank));
      EXPECT_EQ(place.row, row);
      EXPECT_EQ(place.bank, bank ^ (row % 4));
    }
  }
}

TEST(DramMapping, GivesEachPlaceToAsManyBytesAsARowHas) {
  for (const unsigned groups : {1u, 2u, 3u}) {
    for (const bool fold : {false, true}) {
      if (fold && groups == 3) continue;  // needs a power of two of banks
      DramChannelConfig channel = config(4 * groups, groups);
      channel.bank_xor = fold;
      const DramMapping mapping(channel);
      std::map<std::pair<std::uint64_t, std::uint32_t>, unsigned> blocks;
      constexpr unsigned kRows = 4;
      for (std::uint64_t at = 0; at < std::uint64_t{kRows} * channel.banks * channel.row_bytes; at += 128) {
        const DramMapping::Place place = mapping.place(at);
        ++blocks[{place.row, place.bank}];
      }
      EXPECT_EQ(blocks.size(), kRows * channel.banks);
      for (const auto& [place, count] : blocks) EXPECT_EQ(count, channel.row_bytes / 128);
    }
  }
}

}  // namespace
}  // namespace grtx::modules
