// SPDX-License-Identifier: Apache-2.0
// A parameter that a sweep varies: a configuration key or "tracer.OPTION", and its values.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::explore {

using SweepValue = nlohmann::ordered_json;  ///< a boolean, integer, real number or text

struct Axis {
  std::string name;
  std::string place;               ///< "line N" of the plan, for messages
  std::vector<SweepValue> values;  ///< the choices; empty: a range
  double from = 0.0, to = 0.0;     ///< the range, ends included
  bool logarithmic = false;
  bool integer = false;
  unsigned steps = 0;  ///< number of values of a range in a grid
};

/// Names and values that a point sets, in the plan's order.
using Coordinates = std::vector<std::pair<std::string, SweepValue>>;

/// All combinations; the last axis varies fastest. A range contributes `steps` equally spaced values, both ends
/// included.
std::vector<Coordinates> grid_points(const std::vector<Axis>& axes);
/// Independent random points. The same seed gives the same points on every host.
std::vector<Coordinates> random_points(const std::vector<Axis>& axes, unsigned count, std::uint64_t seed);
/// Latin hypercube: each axis is cut into `count` equally likely strata and every stratum is used once.
std::vector<Coordinates> latin_points(const std::vector<Axis>& axes, unsigned count, std::uint64_t seed);

/// Value of an axis at `u` in [0, 1): a choice, or a position in the range. Reals are rounded to nine significant
/// digits, so that last-bit differences between mathematical libraries do not make new points.
SweepValue value_at(const Axis& axis, double u);

/// Rounded to nine significant digits.
double nine_digits(double value);

/// Text form for `--set` and command lines: strings without quotes.
std::string text_of(const SweepValue& value);

}  // namespace grtx::explore
