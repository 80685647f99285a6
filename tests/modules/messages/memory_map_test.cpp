// SPDX-License-Identifier: Apache-2.0
// The memory map: regions are disjoint and aligned, every address lies inside its region, no two buffers overlap.
#include "grtx/modules/messages/memory_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "grtx/base/error.h"

namespace grtx::modules {
namespace {

traces::Header header_of(bool checkpoint, unsigned k, unsigned warp_size) {
  traces::Header header;
  header.k = k;
  header.checkpoint = checkpoint;
  header.width = 17;
  header.height = 5;
  header.warp_size = warp_size;
  header.node_image_bytes = 12345 * traces::kNodeUnit;
  header.gaussians = 777;
  header.sh_record_bytes = 108;
  header.checkpoint_capacity = checkpoint ? 300u : 0u;
  return header;
}

const MemoryMap::Extent& extent(const MemoryMap& map, const std::string& name) {
  const auto found = std::find_if(map.extents().begin(), map.extents().end(),
                                  [&](const MemoryMap::Extent& e) { return e.name == name; });
  EXPECT_NE(found, map.extents().end()) << name;
  return *found;
}

void expect_inside(const MemoryMap& map, const std::string& name, std::uint64_t first, std::uint64_t bytes) {
  const MemoryMap::Extent& e = extent(map, name);
  EXPECT_GE(first, e.base) << name;
  EXPECT_LE(first + bytes, e.base + e.bytes) << name;
}

TEST(MemoryMap, WhatCannotBeAddressedIsRefused) {
  traces::Header header = header_of(true, 8, 32);
  EXPECT_NO_THROW(MemoryMap(header, {170, 64, 0}));
  header.checkpoint_capacity = 1ULL << 24;
  EXPECT_THROW(MemoryMap(header, {170, 64, 0}), Error);
  header = header_of(true, 8, 32);
  for (const std::uint64_t entries : {1ULL << 30, ~0ULL}) {
    MemoryMapConfig config{8, 32, entries};
    EXPECT_THROW(MemoryMap(header, config), Error) << entries;
  }
}

TEST(MemoryMap, RegionsFollowEachOtherWithoutOverlapFromZero) {
  for (const bool checkpoint : {false, true}) {
    const MemoryMap map(header_of(checkpoint, 8, 32), {3, 5, 0});
    EXPECT_EQ(map.extents().size(), checkpoint ? 7u : 5u);
    std::uint64_t end = 0;
    for (const MemoryMap::Extent& e : map.extents()) {
      EXPECT_GE(e.base, end) << e.name;
      EXPECT_LT(e.base - end, 4096u) << e.name;  // compact
      EXPECT_EQ(e.base % 4096, 0u) << e.name;
      EXPECT_GT(e.bytes, 0u) << e.name;
      end = e.base + e.bytes;
    }
    EXPECT_GE(map.bytes(), end);
    EXPECT_EQ(map.extents().front().base, 0u);
    EXPECT_EQ(map.node(4711 * traces::kNodeUnit), 4711 * traces::kNodeUnit);
  }
}

TEST(MemoryMap, FirstAndLastItemsLieInsideTheirRegion) {
  const MemoryMapConfig config{3, 5, 0};
  const traces::Header header = header_of(true, 8, 32);
  const MemoryMap map(header, config);
  const std::uint64_t last_ray = map.ray_slot(2, 4, 31);
  EXPECT_EQ(last_ray, 3u * 5 * 32 - 1);
  expect_inside(map, "gaussian", map.gaussian_record(0), 48);
  expect_inside(map, "gaussian", map.gaussian_record(776), 48);
  expect_inside(map, "sh", map.sh_record(0), 108);
  expect_inside(map, "sh", map.sh_record(776), 108);
  expect_inside(map, "k_buffer", map.k_buffer(0, 0, 0, 0), 4);
  expect_inside(map, "k_buffer", map.k_buffer(map.warp_slot(2, 4), 7, 1, 31), 4);
  expect_inside(map, "checkpoint", map.checkpoint_entry(0, 0, 0), 20);
  expect_inside(map, "checkpoint", map.checkpoint_entry(last_ray, 1, 299), 20);
  expect_inside(map, "eviction", map.eviction_entry(0, 0), 8);
  expect_inside(map, "eviction", map.eviction_entry(last_ray, map.eviction_capacity() - 1), 8);
  expect_inside(map, "eviction", map.eviction_entry(last_ray, 10 * map.eviction_capacity() + 3), 8);
  expect_inside(map, "pixel", map.pixel(0), 16);
  expect_inside(map, "pixel", map.pixel(17 * 5 - 1), 16);
}

TEST(MemoryMap, NoTwoKBufferValuesShareAnAddress) {
  for (const auto& [warp_size, layout] : {std::pair(4u, RayArrayLayout::by_lane),
                                          {32u, RayArrayLayout::by_lane},
                                          {4u, RayArrayLayout::by_ray},
                                          {32u, RayArrayLayout::by_ray}}) {
    for (const unsigned k : {1u, 4u, 16u}) {
      MemoryMapConfig config{2, 3, 0};
      config.k_buffers = layout;
      const MemoryMap map(header_of(false, k, warp_size), config);
      std::set<std::uint64_t> seen;
      for (unsigned sm = 0; sm < 2; ++sm)
        for (unsigned slot = 0; slot < 3; ++slot)
          for (unsigned i = 0; i < k; ++i)
            for (unsigned field = 0; field < 2; ++field)
              for (unsigned lane = 0; lane < warp_size; ++lane)
                EXPECT_TRUE(seen.insert(map.k_buffer(map.warp_slot(sm, slot), i, field, lane)).second);
      EXPECT_EQ(*seen.rbegin() - *seen.begin() + 4, extent(map, "k_buffer").bytes);
    }
  }
}

TEST(MemoryMap, ARaysArrayIsContiguousOrSpreadOverItsWarp) {
  MemoryMapConfig config{2, 3, 0};
  const MemoryMap usual(header_of(true, 8, 32), config);
  EXPECT_EQ(usual.k_buffer(1, 3, 0, 5), usual.k_buffer(1, 3, 0, 4) + 4);
  EXPECT_EQ(usual.eviction_entry(70, 3), usual.eviction_entry(70, 2) + 8);
  config.k_buffers = RayArrayLayout::by_ray;
  config.evictions = RayArrayLayout::by_lane;
  const MemoryMap other(header_of(true, 8, 32), config);
  EXPECT_EQ(other.k_buffer(1, 3, 1, 5), other.k_buffer(1, 3, 0, 5) + 4);
  EXPECT_EQ(other.k_buffer(1, 3, 0, 5), other.k_buffer(1, 2, 0, 5) + 8);
  EXPECT_EQ(other.eviction_entry(71, 2), other.eviction_entry(70, 2) + 8);
  EXPECT_EQ(other.eviction_entry(70, 3), other.eviction_entry(70, 2) + 32 * 8);
  std::set<std::uint64_t> seen;
  for (std::uint64_t ray = 0; ray < 2 * 3 * 32; ++ray) {
    for (std::uint64_t i = 0; i < other.eviction_capacity(); ++i) {
      EXPECT_TRUE(seen.insert(other.eviction_entry(ray, i)).second);
      expect_inside(other, "eviction", other.eviction_entry(ray, i), 8);
    }
  }
}

TEST(MemoryMap, CheckpointBuffersOfARayAlternateWithoutOverlap) {
  const MemoryMap map(header_of(true, 8, 32), {1, 2, 0});
  std::uint64_t end = extent(map, "checkpoint").base;
  for (std::uint64_t ray = 0; ray < 64; ++ray) {
    for (unsigned buffer = 0; buffer < 2; ++buffer) {
      EXPECT_GE(map.checkpoint_entry(ray, buffer, 0), end);
      for (std::uint64_t i = 1; i < 300; ++i) {
        ASSERT_EQ(map.checkpoint_entry(ray, buffer, i), map.checkpoint_entry(ray, buffer, i - 1) + 20);
      }
      end = map.checkpoint_entry(ray, buffer, 299) + 20;
    }
  }
}

TEST(MemoryMap, BinsOfARayLieOneBehindTheOther) {
  traces::Header header = header_of(true, 8, 32);
  header.checkpoint_bins = 8;
  const MemoryMap map(header, {1, 2, 0, 0, 8});
  const std::uint64_t stride = map.checkpoint_bin(0, 1) - map.checkpoint_bin(0, 0);
  EXPECT_EQ(stride % 128, 0u);
  EXPECT_GE(stride, 300u * 8);
  for (std::uint64_t ray = 0; ray < 64; ++ray) {
    for (unsigned bin = 0; bin < 9; ++bin) {  // the far one is the last
      EXPECT_EQ(map.checkpoint_bin(ray, bin), map.checkpoint_bin(0, 0) + (ray * 9 + bin) * stride);
    }
  }
  EXPECT_LE(map.checkpoint_bin(63, 8) + stride, extent(map, "checkpoint").base + extent(map, "checkpoint").bytes);
}

TEST(MemoryMap, EvictionBuffersHoldTheirCapacityThenStartOver) {
  for (const std::uint64_t asked : {std::uint64_t{0}, std::uint64_t{7}, std::uint64_t{1000}}) {
    const MemoryMap map(header_of(true, 8, 32), {1, 2, asked});
    EXPECT_EQ(map.eviction_capacity(), asked == 0 ? 300u : asked);
    std::set<std::uint64_t> seen;
    for (std::uint64_t ray = 0; ray < 64; ++ray) {
      for (std::uint64_t i = 0; i < map.eviction_capacity(); ++i) {
        EXPECT_TRUE(seen.insert(map.eviction_entry(ray, i)).second);
        EXPECT_EQ(map.eviction_entry(ray, i + map.eviction_capacity()), map.eviction_entry(ray, i));
      }
    }
  }
}

TEST(MemoryMap, BuffersOfNeighbouringRaysSpreadOverCacheSets) {
  // 128 B lines: the stride is an odd number of lines whatever the capacity, so 2^n sets are all used.
  for (const std::uint64_t capacity : {64u, 256u, 1024u, 5000u}) {
    traces::Header header = header_of(true, 8, 32);
    header.checkpoint_capacity = capacity;
    const MemoryMap map(header, {1, 1, 0});
    std::set<std::uint64_t> checkpoint_sets;
    std::set<std::uint64_t> eviction_sets;
    for (std::uint64_t ray = 0; ray < 32; ++ray) {
      checkpoint_sets.insert(map.checkpoint_entry(ray, 0, 0) / 128 % 16);
      eviction_sets.insert(map.eviction_entry(ray, 0) / 128 % 16);
    }
    EXPECT_EQ(checkpoint_sets.size(), 8u);  // buffer 0 of each ray: every second buffer
    EXPECT_EQ(eviction_sets.size(), 16u);
  }
}

}  // namespace
}  // namespace grtx::modules
