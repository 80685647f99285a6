// One thing that a sweep varies: a configuration key or "tracer.OPTION", and the values it takes.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grtx::sim {

using SweepValue = nlohmann::ordered_json;  ///< a boolean, integer, real number or text

struct Axis {
  std::string name;
  std::string place;               ///< "line N" of the plan, for messages
  std::vector<SweepValue> values;  ///< the choices; empty: a range
  double from = 0.0, to = 0.0;     ///< the range, ends included
  bool logarithmic = false;
  bool integer = false;
  unsigned steps = 0;  ///< of a range in a grid
};

/// What one point sets, in the plan's order.
using Coordinates = std::vector<std::pair<std::string, SweepValue>>;

/// Every combination; the last axis varies fastest. A range gives `steps` values from end to end.
std::vector<Coordinates> grid_points(const std::vector<Axis>& axes);
/// Independent draws. The same seed gives the same points on every host.
std::vector<Coordinates> random_points(const std::vector<Axis>& axes, unsigned count, std::uint64_t seed);
/// Latin hypercube: each axis is cut into `count` equally likely strata and every stratum is used once.
std::vector<Coordinates> latin_points(const std::vector<Axis>& axes, unsigned count, std::uint64_t seed);

/// The value at `u` in [0, 1) of an axis: a choice, or a place in the range. Reals have nine significant digits, so
/// that a mathematical library's last bit is no new point.
SweepValue value_at(const Axis& axis, double u);

/// Rounded to nine significant digits.
double nine_digits(double value);

/// As `--set` and command lines take it: texts without quotes.
std::string text_of(const SweepValue& value);

}  // namespace grtx::sim
