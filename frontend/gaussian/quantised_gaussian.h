// SPDX-License-Identifier: Apache-2.0
// A Gaussian in 32 B, as a leaf of layout quantised holds it. The tracer reads every Gaussian of that layout through
// this code, so it draws what the hardware would decode. Fields and precision: docs/model/node-image.md.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace grtx::frontend {

/// Grid of the codes of means: mean = origin + code * step, with a power of two as step on each axis.
struct MeanGrid {
  glm::vec3 origin{0.0f};
  glm::vec3 step{1.0f};
  static constexpr double kMostCode = (1 << 22) - 1;
  static constexpr double kLeastStep = 0x1p-100;
  /// The finest grid that holds all these means.
  static MeanGrid covering(const std::vector<glm::vec3>& means);
};

class QuantisedGaussian {
 public:
  static constexpr unsigned kIdBits = 26, kOpacityBits = 8, kMeanBits = 22, kExponentBits = 7, kEntryBits = 15;

  QuantisedGaussian() = default;
  /// to_unit: rows of the map from world differences to the unit sphere. opacity: 0..1. id: below 2^26.
  /// Entries keep 15 bits under the exponent of their row; a row beyond 2^-80 .. 2^47 keeps its direction.
  QuantisedGaussian(const MeanGrid& grid, std::uint32_t id, float opacity, const glm::vec3& mean,
                    const glm::dvec3 (&to_unit)[3]);

  std::uint32_t id() const { return static_cast<std::uint32_t>(field(0, kIdBits)); }
  float opacity() const { return decoded_opacity(static_cast<unsigned>(field(kIdBits, kOpacityBits))); }
  glm::vec3 mean(const MeanGrid& grid) const;
  glm::vec3 row(unsigned axis) const;
  /// Whether a code can hold these values: the mean lies on the grid, and no row exceeds the exponents.
  static bool holds(const MeanGrid& grid, const glm::vec3& mean, const glm::dvec3 (&to_unit)[3]);
  const std::array<std::uint32_t, 8>& words() const { return words_; }

  /// The opacity nearest to `opacity` that a leaf can hold; the kernel radius follows from it.
  static float nearest_opacity(float opacity) { return decoded_opacity(opacity_code(opacity)); }

 private:
  static unsigned opacity_code(float opacity);
  static float decoded_opacity(unsigned code) { return static_cast<float>(code) / ((1u << kOpacityBits) - 1); }
  /// `bits` (at most 32) from bit `first` on, counted from the lowest of word 0.
  std::uint64_t field(unsigned first, unsigned bits) const;
  void set_field(unsigned first, unsigned bits, std::uint64_t value);

  std::array<std::uint32_t, 8> words_{};
};
static_assert(sizeof(QuantisedGaussian) == 32);

}  // namespace grtx::frontend
