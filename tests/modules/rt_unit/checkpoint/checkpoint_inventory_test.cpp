// SPDX-License-Identifier: Apache-2.0
// Bits of the checkpoint unit, by hand from what each part holds; what is switched off has none.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"

namespace grtx::modules {
namespace {

constexpr std::uint64_t kLanes = 256;

std::map<std::string, std::uint64_t> bits_of(const CheckpointConfig& config, unsigned bins = 0,
                                             std::uint64_t capacity = 0) {
  traces::Header header;
  header.checkpoint_bins = bins;
  header.two_level = true;
  header.checkpoint_capacity = capacity;
  std::map<std::string, std::uint64_t> bits;
  for (const Storage& s : checkpoint_inventory("unit", config, kLanes, header).storage) {
    bits[s.name] += s.bits;
  }
  return bits;
}

TEST(CheckpointInventory, HoldsASectorARayAndDirection) {
  CheckpointConfig config;
  config.write_queue = 8;
  config.entry_bytes = 20;
  config.write_combine = config.read_buffer = true;
  const auto bits = bits_of(config);
  EXPECT_EQ(bits.at("write_queue"), 8u * (256 + 32 + 48)) << "a sector, its byte mask, its address";
  EXPECT_EQ(bits.at("submitted"), kLanes * 8);
  EXPECT_EQ(bits.at("open_sectors"), kLanes * 256);
  EXPECT_EQ(bits.at("read_sectors"), kLanes * 256);
  for (const char* part : {"bin_pointers", "bin_read", "open_tags"}) EXPECT_FALSE(bits.contains(part)) << part;
  config.write_combine = config.read_buffer = false;
  EXPECT_FALSE(bits_of(config).contains("open_sectors"));
  EXPECT_FALSE(bits_of(config).contains("read_sectors"));
}

TEST(CheckpointInventory, ABinIsThreePlaces) {
  CheckpointConfig config;
  config.write_combine = true;
  config.open_sectors = 2;
  config.entry_bytes = 8;
  for (const auto& [capacity, place_bits] : {std::pair(512u, 10u), std::pair(511u, 9u), std::pair(1024u, 11u)}) {
    const auto bits = bits_of(config, 8, capacity);
    EXPECT_EQ(bits.at("bin_pointers"), kLanes * 9 * 3 * place_bits) << "read, written, and what the round may read";
    EXPECT_EQ(bits.at("bin_read"), kLanes * (32 + 22 + 4));
    EXPECT_EQ(bits.at("open_sectors"), kLanes * 2 * 256);
    EXPECT_EQ(bits.at("open_tags"), kLanes * 2 * (4 + place_bits));
  }
  EXPECT_FALSE(bits_of(config).contains("bin_pointers"));
}

}  // namespace
}  // namespace grtx::modules
