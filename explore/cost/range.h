// SPDX-License-Identifier: Apache-2.0
// A coefficient or a result as low, central and high. Sums add the ends, which assumes fully correlated errors.
#pragma once

namespace grtx::explore {

struct Range {
  double low = 0.0, central = 0.0, high = 0.0;

  static constexpr Range exactly(double value) { return {value, value, value}; }
  constexpr Range& operator+=(const Range& o) {
    low += o.low;
    central += o.central;
    high += o.high;
    return *this;
  }
  friend constexpr Range operator+(Range a, const Range& b) { return a += b; }
  /// Product of two factors, both >= 0; the ends are multiplied.
  friend constexpr Range operator*(const Range& a, const Range& b) {
    return {a.low * b.low, a.central * b.central, a.high * b.high};
  }
  friend constexpr Range operator*(const Range& a, double factor) {
    return {a.low * factor, a.central * factor, a.high * factor};
  }
  bool operator==(const Range&) const = default;
};

}  // namespace grtx::explore
