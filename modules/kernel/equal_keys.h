// SPDX-License-Identifier: Apache-2.0
// Compares 16 keys with one key, like a row of parallel comparators; with SIMD on the host.
#pragma once

#include <cstdint>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace grtx::modules {

/// Bit i of the result: keys[i] == key, for i < 16.
inline unsigned equal_keys(const std::uint32_t* keys, std::uint32_t key) {
#ifdef __SSE2__
  const __m128i wanted = _mm_set1_epi32(static_cast<int>(key));
  const auto four = [&](unsigned i) {
    return _mm_cmpeq_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(keys + i)), wanted);
  };
  const __m128i low = _mm_packs_epi32(four(0), four(4));
  const __m128i high = _mm_packs_epi32(four(8), four(12));
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
#else
  unsigned equal = 0;
  for (unsigned i = 0; i < 16; ++i) equal |= unsigned{keys[i] == key} << i;
  return equal;
#endif
}

}  // namespace grtx::modules
