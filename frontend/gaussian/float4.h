// Four floats that are worked on at once, by the compiler's vector types: SSE2, NEON or plain code, with the same
// results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace grtx::frontend {

using Float4 [[gnu::vector_size(16)]] = float;

/// As std::min(b, a) and std::max(b, a): b where both are equal, as zeros of either sign are.
inline Float4 min(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 max(Float4 a, Float4 b) { return a > b ? a : b; }

inline Float4 abs(Float4 a) {
  using Bits [[gnu::vector_size(16)]] = std::int32_t;
  return reinterpret_cast<Float4>(reinterpret_cast<Bits>(a) & 0x7FFFFFFF);
}

/// Writes a as the four floats number 4 * quad on of an array.
inline void store(void* floats, std::size_t quad, Float4 a) {
  std::memcpy(static_cast<unsigned char*>(floats) + quad * sizeof a, &a, sizeof a);
}

}  // namespace grtx::frontend
