// SPDX-License-Identifier: Apache-2.0
// Damaged inputs of readers: each is read, or refused with an Error. Nothing else.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/readers.h"
#include "grtx/base/atomic_file.h"
#include "mutations.h"

namespace grtx::fuzzing {

class InputFuzz : public ::testing::TestWithParam<InputReader> {};

TEST_P(InputFuzz, WhatIsDamagedIsReadOrRefused) {
  const InputReader& reader = GetParam();
  std::mt19937_64 random(testing_fuzz::seed());
  std::uint64_t refused = 0;
  const std::vector<std::string> seeds = reader.seeds();
  ASSERT_FALSE(seeds.empty());
  for (const std::string& seed : seeds) {
    EXPECT_TRUE(read_bytes(reader, seed)) << reader.name << ": a sound file is refused";
    for (std::uint64_t i = 0; i < testing_fuzz::count(500); ++i) {
      const std::string bytes = testing_fuzz::mutated(seed, random);
      try {
        refused += read_bytes(reader, bytes) ? 0 : 1;
      } catch (const std::exception& error) {
        ADD_FAILURE() << reader.name << ", mutation " << i << " of seed " << testing_fuzz::seed() << ": "
                      << error.what();
        const std::string find = "grtx_find_" + std::to_string(i) + "_" + reader.file;
        write_file((std::filesystem::temp_directory_path() / find).string(), bytes);
      }
    }
  }
  EXPECT_GT(refused, 0U) << reader.name << ": no mutation was noticed";
}

TEST_P(InputFuzz, WhatFuzzersLeftIsReadOrRefused) {
  const InputReader& reader = GetParam();
  const std::vector<std::string> inputs = corpus(reader);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    try {
      refused += read_bytes(reader, inputs[i]) ? 0 : 1;
    } catch (const std::exception& error) {
      ADD_FAILURE() << reader.name << ", input " << i << ": " << error.what();
    }
  }
  EXPECT_GT(refused, 0U) << reader.name << ": nothing in the corpus is damaged";
}

}  // namespace grtx::fuzzing
