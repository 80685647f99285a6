// Which stretch of distance a checkpoint entry belongs to: some leading bits. docs/model/checkpoint_unit.md.
#pragma once

#include <bit>
#include <cstdint>

namespace grtx::frontend {

/// The bin of a distance that is not negative. Never falls with growing distance, so what lies up to t_max has no
/// larger number than t_max. Three bits of fp32's mantissa stay: eight stretches an octave.
inline std::uint32_t number_of_bin(float distance) {
  constexpr unsigned kDroppedBits = 20;
  return std::bit_cast<std::uint32_t>(distance) >> kDroppedBits;
}

}  // namespace grtx::frontend
