// The coin that stochastic tracing tosses for each hit: a hash of ray, sample and Gaussian, so that what it shows does
// not depend on the order in which a structure meets them, on threads, or on the host.
#pragma once

#include <bit>
#include <cstdint>

#include "grtx/frontend/gaussian/canonical_hit.h"

namespace grtx::frontend {

/// The finaliser of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): every bit of x moves about half of the result's.
constexpr std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

class Coin {
 public:
  explicit Coin(std::uint32_t seed) : seed_(seed) {}

  void begin_ray(const TraceRay& ray) {
    ray_ = mixed(seed_ + 0x9E3779B97F4A7C15ULL);
    for (int i = 0; i < 3; ++i) {
      ray_ = mixed(ray_ + std::bit_cast<std::uint32_t>(ray.origin[i]));
      ray_ = mixed(ray_ + std::bit_cast<std::uint32_t>(ray.direction[i]));
    }
  }
  void begin_sample(std::uint32_t sample) { sample_ = mixed(ray_ + sample); }
  /// Whether the sample stops at the Gaussian: with probability alpha, in steps of 2^-24.
  bool stops(std::uint32_t gaussian, float alpha) const {
    const auto drawn = static_cast<std::uint32_t>(mixed(sample_ + gaussian) >> 40);
    return static_cast<float>(drawn) * 0x1p-24f < alpha;
  }

 private:
  std::uint64_t seed_;
  std::uint64_t ray_ = 0;
  std::uint64_t sample_ = 0;
};

}  // namespace grtx::frontend
