// The distance bin of a checkpoint entry: the leading bits of its distance. docs/model/checkpoint_unit.md.
#pragma once

#include <bit>
#include <cstdint>

namespace grtx::frontend {

/// The bin of a non-negative distance. It never falls with growing distance, so entries up to t_max have no higher bin
/// than t_max. Keeps three bits of fp32's mantissa: eight bins per octave.
inline std::uint32_t number_of_bin(float distance) {
  constexpr unsigned kDroppedBits = 20;
  return std::bit_cast<std::uint32_t>(distance) >> kDroppedBits;
}

}  // namespace grtx::frontend
