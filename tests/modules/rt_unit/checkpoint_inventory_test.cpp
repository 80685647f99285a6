// Bits of the checkpoint unit, by hand from what each part holds; what is switched off has none.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "grtx/modules/rt_unit/checkpoint_unit.h"

namespace grtx::modules {
namespace {

constexpr std::uint64_t kLanes = 256;

std::map<std::string, std::uint64_t> bits_of(const CheckpointConfig& config, std::uint64_t log_entries = 0) {
  std::map<std::string, std::uint64_t> bits;
  for (const Storage& s : checkpoint_inventory("unit", config, kLanes, true, log_entries).storage) {
    bits[s.name] += s.bits;
  }
  return bits;
}

TEST(CheckpointInventory, HoldsASectorARayAndDirection) {
  CheckpointConfig config;
  config.entry_bytes = 20;
  config.write_queue = 8;
  config.write_combine = config.read_buffer = true;
  const auto bits = bits_of(config);
  EXPECT_EQ(bits.at("write_queue"), 8u * (256 + 32 + 48)) << "a sector, its byte mask, its address";
  EXPECT_EQ(bits.at("submitted"), kLanes * 8);
  EXPECT_EQ(bits.at("open_sectors"), kLanes * 256);
  EXPECT_EQ(bits.at("read_sectors"), kLanes * 256);
  for (const char* part : {"runs", "private_store", "store_reads", "ahead", "named"})
    EXPECT_FALSE(bits.contains(part)) << part;
  config.write_combine = config.read_buffer = false;
  EXPECT_FALSE(bits_of(config).contains("open_sectors"));
  EXPECT_FALSE(bits_of(config).contains("read_sectors"));
}

TEST(CheckpointInventory, ARunIsTwoPlacesOfTheLogAndAMark) {
  CheckpointConfig config;
  config.entry_bytes = 16;
  for (const auto& [log_entries, place_bits] : {std::pair(1024u, 10u), std::pair(1025u, 11u), std::pair(512u, 9u)}) {
    EXPECT_EQ(bits_of(config, log_entries).at("runs"), kLanes * (2 * (2 * place_bits + 1) + 128)) << log_entries;
  }
}

TEST(CheckpointInventory, StoresAndReadingAheadArePricedWhereTheyAre) {
  CheckpointConfig config;
  config.entry_bytes = 20;
  config.store.entries = 4;
  config.store.warps = 3;
  config.read_ahead = 2;
  config.prefetch_nodes = true;
  const auto bits = bits_of(config);
  EXPECT_EQ(bits.at("private_store"), 2u * 4 * 3 * 32 * 160) << "both buffers of each ray";
  EXPECT_EQ(bits.at("store_reads"), kLanes * 8);
  EXPECT_EQ(bits.at("ahead"), kLanes * 40);
  EXPECT_EQ(bits.at("named"), kLanes * 16);
}

}  // namespace
}  // namespace grtx::modules
