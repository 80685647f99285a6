// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "grtx/base/json.h"
#include "grtx/base/split_mix.h"

namespace grtx::explore {
namespace {

/// Value at a share (0 to 1) of the range, ends included.
SweepValue in_range(const Axis& axis, double share) {
  const double value =
      axis.logarithmic ? axis.from * std::pow(axis.to / axis.from, share) : axis.from + (axis.to - axis.from) * share;
  if (axis.integer) return std::llround(std::clamp(value, axis.from, axis.to));
  return nine_digits(std::clamp(value, axis.from, axis.to));
}

std::vector<SweepValue> grid_values(const Axis& axis) {
  if (!axis.values.empty()) return axis.values;
  std::vector<SweepValue> values;
  for (unsigned i = 0; i < axis.steps; ++i) {
    const double share = axis.steps == 1 ? 0.0 : static_cast<double>(i) / (axis.steps - 1);
    const SweepValue value = in_range(axis, share);
    if (values.empty() || values.back() != value) values.push_back(value);
  }
  return values;
}

}  // namespace

double nine_digits(double value) { return std::stod(fmt::format("{:.9g}", value)); }

std::vector<Coordinates> grid_points(const std::vector<Axis>& axes) {
  std::vector<Coordinates> points = {{}};
  for (const Axis& axis : axes) {
    const std::vector<SweepValue> values = grid_values(axis);
    std::vector<Coordinates> longer;
    longer.reserve(points.size() * values.size());
    for (const Coordinates& point : points) {
      for (const SweepValue& value : values) {
        longer.push_back(point);
        longer.back().emplace_back(axis.name, value);
      }
    }
    points = std::move(longer);
  }
  return points;
}

SweepValue value_at(const Axis& axis, double u) {
  if (!axis.values.empty()) {
    const auto index = static_cast<std::size_t>(u * static_cast<double>(axis.values.size()));
    return axis.values[std::min(index, axis.values.size() - 1)];
  }
  if (!axis.integer) return in_range(axis, u);
  // Every integer is equally likely (on a logarithmic range: in proportion to its width in the logarithm).
  if (axis.logarithmic) {
    const double low = axis.from - 0.5, high = axis.to + 0.5;
    const double value = low > 0.0 ? low * std::pow(high / low, u) : in_range(axis, u).get<double>();
    return std::llround(std::clamp(value, axis.from, axis.to));
  }
  return static_cast<std::int64_t>(axis.from) + static_cast<std::int64_t>(u * (axis.to - axis.from + 1.0));
}

std::vector<Coordinates> random_points(const std::vector<Axis>& axes, unsigned count, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Coordinates> points(count);
  for (Coordinates& point : points) {
    for (const Axis& axis : axes) point.emplace_back(axis.name, value_at(axis, random.uniform()));
  }
  return points;
}

std::vector<Coordinates> latin_points(const std::vector<Axis>& axes, unsigned count, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Coordinates> points(count);
  std::vector<unsigned> strata(count);
  for (const Axis& axis : axes) {
    std::iota(strata.begin(), strata.end(), 0U);
    for (unsigned i = count; i > 1; --i) std::swap(strata[i - 1], strata[random.next() % i]);
    for (unsigned i = 0; i < count; ++i) {
      points[i].emplace_back(axis.name, value_at(axis, (strata[i] + random.uniform()) / count));
    }
  }
  return points;
}

std::string text_of(const SweepValue& value) { return value.is_string() ? value.get<std::string>() : json_text(value); }

}  // namespace grtx::explore
