// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/numbers/counter_random.h"

#include <cmath>

#include "grtx/frontend/numbers/portable_math.h"

namespace grtx::frontend {
namespace {

std::uint64_t combine(std::uint64_t a, std::uint64_t b) { return split_mix(a * kSplitMixStep + b); }

}  // namespace

CounterRandom::CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t index)
    : numbers_(combine(combine(split_mix(seed), stream), index)) {}

double CounterRandom::normal() {
  const double radius = std::sqrt(-2.0 * portable_log(1.0 - uniform()));
  return radius * portable_turn(uniform()).cosine;
}

double CounterRandom::gamma(double shape, double scale) {
  // Marsaglia and Tsang, ACM TOMS 2000; a shape below 1 is raised by 1 and the result shrunk by u^(1/shape).
  if (shape < 1.0) {
    const double shrink = portable_exp(portable_log(1.0 - uniform()) / shape);
    return shrink * gamma(shape + 1.0, scale);
  }
  const double d = shape - 1.0 / 3.0;
  const double c = 1.0 / std::sqrt(9.0 * d);
  for (;;) {
    const double x = normal();
    const double root = 1.0 + c * x;
    if (root <= 0.0) continue;
    const double v = root * root * root;
    if (portable_log(1.0 - uniform()) < 0.5 * x * x + d - d * v + d * portable_log(v)) return d * v * scale;
  }
}

glm::dvec3 CounterRandom::direction() {
  const double z = uniform(-1.0, 1.0);
  const SineCosine turn = portable_turn(uniform());
  const double r = std::sqrt(1.0 - z * z);
  return {r * turn.cosine, r * turn.sine, z};
}

double value_noise(std::uint64_t seed, const glm::dvec3& at) {
  const glm::dvec3 cell(std::floor(at.x), std::floor(at.y), std::floor(at.z));
  glm::dvec3 f = at - cell;
  f = f * f * (glm::dvec3(3.0) - 2.0 * f);
  double sum = 0.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::uint64_t hash = seed;
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = (corner >> axis & 1u) != 0;
      hash = combine(hash, static_cast<std::uint64_t>(static_cast<std::int64_t>(cell[axis]) + (upper ? 1 : 0)));
      weight *= upper ? f[axis] : 1.0 - f[axis];
    }
    sum += weight * (static_cast<double>(hash >> 11) * 0x1p-52 - 1.0);
  }
  return sum;
}

CounterPermutation::CounterPermutation(std::uint64_t seed, std::uint64_t count) : seed_(seed), count_(count) {
  while (half_bits_ < 31 && (std::uint64_t{1} << (2 * half_bits_)) < count) ++half_bits_;
}

std::uint64_t CounterPermutation::operator()(std::uint64_t index) const {
  const std::uint64_t mask = (std::uint64_t{1} << half_bits_) - 1;
  do {  // the network permutes a power of four >= count, less than 4 count: a few steps at most on average
    std::uint64_t left = index >> half_bits_;
    std::uint64_t right = index & mask;
    for (std::uint64_t round = 0; round < 4; ++round) {
      const std::uint64_t next = left ^ (combine(combine(seed_, round), right) & mask);
      left = right;
      right = next;
    }
    index = left << half_bits_ | right;
  } while (index >= count_);
  return index;
}

}  // namespace grtx::frontend
