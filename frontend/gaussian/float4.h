// SPDX-License-Identifier: Apache-2.0
// Four floats processed at once with the compiler's vector types: SSE2, NEON or plain code, with the same results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace grtx::frontend {

using Float4 [[gnu::vector_size(16)]] = float;

/// As std::min(b, a) and std::max(b, a): returns b if both are equal, as for zeros of either sign.
inline Float4 min(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 max(Float4 a, Float4 b) { return a > b ? a : b; }

inline Float4 abs(Float4 a) {
  using Bits [[gnu::vector_size(16)]] = std::int32_t;
  return reinterpret_cast<Float4>(reinterpret_cast<Bits>(a) & 0x7FFFFFFF);
}

/// Writes a to floats 4 * quad to 4 * quad + 3 of an array.
inline void store(void* floats, std::size_t quad, Float4 a) {
  std::memcpy(static_cast<unsigned char*>(floats) + quad * sizeof a, &a, sizeof a);
}

}  // namespace grtx::frontend
