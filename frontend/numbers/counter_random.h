// SPDX-License-Identifier: Apache-2.0
// Random numbers for scenes and objects: counter-based, integer arithmetic, so that row n never depends on row n - 1,
// on the compiler or on the host.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/base/split_mix.h"

namespace grtx::frontend {

/// SplitMix64, started from (seed, stream, index).
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

  std::uint64_t bits() { return numbers_.next(); }
  double uniform() { return numbers_.uniform(); }  ///< [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal();  ///< mean 0, standard deviation 1
  double gamma(double shape, double scale);
  glm::dvec3 direction();  ///< uniform on the unit sphere

 private:
  SplitMix64 numbers_;
};

/// Smooth noise in [-1, 1] with features of size 1, from a hashed lattice.
double value_noise(std::uint64_t seed, const glm::dvec3& at);

/// A pseudo-random order of 0 .. count - 1 without a table: a Feistel network walked until it stays in range.
class CounterPermutation {
 public:
  CounterPermutation(std::uint64_t seed, std::uint64_t count);
  std::uint64_t operator()(std::uint64_t index) const;

 private:
  std::uint64_t seed_;
  std::uint64_t count_;
  unsigned half_bits_ = 1;
};

}  // namespace grtx::frontend
