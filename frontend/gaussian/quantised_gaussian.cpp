// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/quantised_gaussian.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace grtx::frontend {
namespace {

using Q = QuantisedGaussian;

// Fields in the order of their bits: id, opacity, mean, then for each row its exponent and three entries.
constexpr unsigned kMeanFirst = Q::kIdBits + Q::kOpacityBits;
constexpr unsigned kRowsFirst = kMeanFirst + 3 * Q::kMeanBits;
constexpr unsigned kRowBits = Q::kExponentBits + 3 * Q::kEntryBits;
static_assert(kRowsFirst + 3 * kRowBits == 256);

constexpr int kLeastExponent = -80;  // of a row; code 0
constexpr int kMostExponent = kLeastExponent + (1 << Q::kExponentBits) - 1;
constexpr int kEntryScale = Q::kEntryBits - 1;         // entries are multiples of 2^(exponent - kEntryScale)
constexpr double kMostEntry = (1 << kEntryScale) - 1;  // entries are signed
constexpr double kMostMean = MeanGrid::kMostCode;
static_assert(kMostMean == (std::uint64_t{1} << Q::kMeanBits) - 1);

double largest(const glm::dvec3& row) { return std::max({std::fabs(row.x), std::fabs(row.y), std::fabs(row.z)}); }

// The least exponent under which the row's largest entry still rounds to a code.
int exponent_of(const glm::dvec3& row) {
  int exponent = 0;
  const double fraction = std::frexp(largest(row), &exponent);  // 0.5 .. 1
  return std::round(std::ldexp(fraction, kEntryScale)) > kMostEntry ? exponent + 1 : exponent;
}

}  // namespace

MeanGrid MeanGrid::covering(const std::vector<glm::vec3>& means) {
  MeanGrid grid;
  if (means.empty()) return grid;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::minmax_element(
        means.begin(), means.end(), [axis](const glm::vec3& a, const glm::vec3& b) { return a[axis] < b[axis]; });
    const double extent = static_cast<double>((*most)[axis]) - static_cast<double>((*least)[axis]);
    int exponent = std::ilogb(kLeastStep);
    while (std::ldexp(kMostMean, exponent) < extent) ++exponent;
    grid.origin[axis] = (*least)[axis];
    grid.step[axis] = std::ldexp(1.0f, exponent);
  }
  return grid;
}

QuantisedGaussian::QuantisedGaussian(const MeanGrid& grid, std::uint32_t id, float opacity, const glm::vec3& mean,
                                     const glm::dvec3 (&to_unit)[3]) {
  assert(id < 1u << kIdBits);
  set_field(0, kIdBits, id);
  set_field(kIdBits, kOpacityBits, opacity_code(opacity));
  for (unsigned axis = 0; axis < 3; ++axis) {
    const int at = static_cast<int>(axis);
    const double code = std::round((static_cast<double>(mean[at]) - static_cast<double>(grid.origin[at])) /
                                   static_cast<double>(grid.step[at]));
    set_field(kMeanFirst + axis * kMeanBits, kMeanBits, static_cast<std::uint64_t>(std::clamp(code, 0.0, kMostMean)));

    const int wanted = exponent_of(to_unit[axis]), exponent = std::clamp(wanted, kLeastExponent, kMostExponent);
    const unsigned first = kRowsFirst + axis * kRowBits;
    set_field(first, kExponentBits, static_cast<std::uint64_t>(exponent - kLeastExponent));
    for (unsigned column = 0; column < 3; ++column) {
      const double entry = std::round(std::ldexp(to_unit[axis][static_cast<int>(column)], kEntryScale - wanted));
      set_field(first + kExponentBits + column * kEntryBits, kEntryBits,
                static_cast<std::uint64_t>(static_cast<std::int64_t>(entry)));
    }
  }
}

bool QuantisedGaussian::holds(const MeanGrid& grid, const glm::vec3& mean, const glm::dvec3 (&to_unit)[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const int exponent = exponent_of(to_unit[axis]);
    if (!(largest(to_unit[axis]) > 0.0) || exponent < kLeastExponent || exponent > kMostExponent) return false;
    // Also false where the decoder's sum would overflow.
    const double code = std::round((static_cast<double>(mean[axis]) - static_cast<double>(grid.origin[axis])) /
                                   static_cast<double>(grid.step[axis]));
    const bool sound = std::isfinite(static_cast<float>(code) * grid.step[axis]);
    if (!(code >= 0.0 && code <= kMostMean) || !sound) return false;
  }
  return true;
}

glm::vec3 QuantisedGaussian::mean(const MeanGrid& grid) const {
  glm::vec3 mean;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const int at = static_cast<int>(axis);
    mean[at] = grid.origin[at] + static_cast<float>(field(kMeanFirst + axis * kMeanBits, kMeanBits)) * grid.step[at];
  }
  return mean;
}

glm::vec3 QuantisedGaussian::row(unsigned axis) const {
  const unsigned first = kRowsFirst + axis * kRowBits;
  const int exponent = static_cast<int>(field(first, kExponentBits)) + kLeastExponent;
  glm::vec3 row;
  for (unsigned column = 0; column < 3; ++column) {
    const auto code = static_cast<std::int32_t>(field(first + kExponentBits + column * kEntryBits, kEntryBits));
    const std::int32_t entry = code >= 1 << kEntryScale ? code - (1 << kEntryBits) : code;
    row[static_cast<int>(column)] = std::ldexp(static_cast<float>(entry), exponent - kEntryScale);
  }
  return row;
}

unsigned QuantisedGaussian::opacity_code(float opacity) {
  return static_cast<unsigned>(std::lround(std::clamp(opacity, 0.0f, 1.0f) * ((1u << kOpacityBits) - 1)));
}

std::uint64_t QuantisedGaussian::field(unsigned first, unsigned bits) const {
  const unsigned word = first / 32, low = first % 32;
  const std::uint64_t next = word + 1 < words_.size() ? words_[word + 1] : 0;
  return ((next << 32 | words_[word]) >> low) & ((std::uint64_t{1} << bits) - 1);
}

void QuantisedGaussian::set_field(unsigned first, unsigned bits, std::uint64_t value) {
  const unsigned word = first / 32, low = first % 32;
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1, shifted = (value & mask) << low;
  words_[word] |= static_cast<std::uint32_t>(shifted);
  if (word + 1 < words_.size()) words_[word + 1] |= static_cast<std::uint32_t>(shifted >> 32);
}

}  // namespace grtx::frontend
