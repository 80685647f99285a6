// SPDX-License-Identifier: Apache-2.0
// Seeded mutations of a file's bytes, for tests that readers refuse what is damaged and never crash. scripts/fuzz.sh
// runs them for long: GRTX_FUZZ is how many, GRTX_FUZZ_SEED which.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

namespace grtx::testing_fuzz {

inline std::uint64_t environment(const char* name, std::uint64_t otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}
/// Mutations of each input; `otherwise` in CI.
inline std::uint64_t count(std::uint64_t otherwise) { return environment("GRTX_FUZZ", otherwise); }
inline std::uint64_t seed() { return environment("GRTX_FUZZ_SEED", 1); }

/// Texts at which readers of numbers, JSON, TOML and headers stumble.
inline const std::vector<std::string>& words() {
  static const std::vector<std::string> all = {
      "nan", "inf", "-1",  "0",       "1e999", "-1e-999", "4294967296", "18446744073709551616", "99999999999", "\"\"",
      "[]",  "{}",  "[[",  "null",    "true",  "\n",      "\r\n",       std::string(1, '\0'),   "\xff\xfe",    "''",
      "=",   ",",   "\\u", "\"\\ud8", "1.5",   " ",       "-",          "0x7fffffffffffffff",   "1_0",         "#"};
  return all;
}

/// One to four changes: bits, bytes, words of four bytes with extreme values, texts, pieces cut, doubled or moved.
inline std::string mutated(std::string bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1)); };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    // Headers and beginnings decide most.
    const std::size_t at = below(random() % 2 == 0 ? std::min<std::size_t>(bytes.size(), 200) : bytes.size());
    const std::size_t length = std::min(1 + below(16), bytes.size() - std::min(at, bytes.size()));
    switch (random() % 9) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        if (!bytes.empty()) bytes[at] = static_cast<char>(random());
        break;
      case 2: {
        constexpr std::uint32_t kExtremes[] = {0U,          1U,          0x7fffffffU, 0x80000000U, 0xffffffffU,
                                               0x7f800000U, 0x7fc00000U, 0x00010000U, 0x40000000U};
        const std::uint32_t value = kExtremes[below(std::size(kExtremes))];
        for (std::size_t i = 0; i < 4 && at + i < bytes.size(); ++i)
          bytes[at + i] = static_cast<char>(value >> (8 * i));
        break;
      }
      case 3:
        bytes.resize(at);
        break;
      case 4:
        bytes.erase(at, length);
        break;
      case 5:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 6:
        bytes.insert(at, bytes.substr(below(bytes.size()), length));
        break;
      case 7:
        bytes.insert(at, words()[below(words().size())]);
        break;
      default:
        bytes.replace(at, length, words()[below(words().size())]);
    }
  }
  return bytes;
}

}  // namespace grtx::testing_fuzz
