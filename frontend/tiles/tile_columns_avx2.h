// SPDX-License-Identifier: Apache-2.0
// Transposes rows of eight records into columns of eight lanes.
#pragma once

#if defined(__x86_64__)

#include <immintrin.h>

#include <cstddef>

namespace grtx::frontend {

/// columns[i] receives float offset + i of the eight rows, which are aligned to 16 bytes.
[[gnu::target("avx2"), gnu::always_inline]] inline void load_columns(const float* const* rows, std::size_t offset,
                                                                     __m256* columns) {
  __m256 pairs[4];
  for (int i = 0; i < 4; ++i) {
    pairs[i] = _mm256_set_m128(_mm_load_ps(rows[i + 4] + offset), _mm_load_ps(rows[i] + offset));
  }
  const __m256 a = _mm256_unpacklo_ps(pairs[0], pairs[1]), b = _mm256_unpackhi_ps(pairs[0], pairs[1]);
  const __m256 c = _mm256_unpacklo_ps(pairs[2], pairs[3]), d = _mm256_unpackhi_ps(pairs[2], pairs[3]);
  columns[0] = _mm256_shuffle_ps(a, c, 0x44);
  columns[1] = _mm256_shuffle_ps(a, c, 0xEE);
  columns[2] = _mm256_shuffle_ps(b, d, 0x44);
  columns[3] = _mm256_shuffle_ps(b, d, 0xEE);
}

}  // namespace grtx::frontend

#endif
