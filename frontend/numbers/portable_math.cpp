// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/numbers/portable_math.h"

#include <cmath>

namespace grtx::frontend {
namespace {

constexpr double kLn2High = 0.6931471803691238;  // 33 significant bits, so that k * kLn2High is exact
constexpr double kLn2Low = 1.9082149292705877e-10;

constexpr double kReciprocal[] = {0.0,      1.0,      1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,  1.0 / 7,
                                  1.0 / 8,  1.0 / 9,  1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15,
                                  1.0 / 16, 1.0 / 17, 1.0 / 18, 1.0 / 19, 1.0 / 20, 1.0 / 21};

}  // namespace

double portable_exp(double x) {
  const double k = std::floor(x / (kLn2High + kLn2Low) + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;  // |r| <= ln 2 / 2
  double sum = 1.0;
  for (int n = 15; n >= 1; --n) sum = 1.0 + sum * (r * kReciprocal[n]);
  return std::ldexp(sum, static_cast<int>(k));
}

double portable_log(double x) {
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // [0.5, 1)
  if (mantissa < 0.70710678118654752) {
    mantissa *= 2.0;
    --exponent;
  }
  const double s = (mantissa - 1.0) / (mantissa + 1.0);  // |s| <= 0.172; ln m = 2 atanh s
  const double s2 = s * s;
  double sum = 0.0;
  for (int n = 21; n >= 1; n -= 2) sum = sum * s2 + kReciprocal[n];
  return exponent * kLn2High + (2.0 * s * sum + exponent * kLn2Low);
}

SineCosine portable_turn(double u) {
  constexpr double kTwoPi = 6.283185307179586;
  const double quarters = std::floor(4.0 * u + 0.5);
  const double a = kTwoPi * (u - 0.25 * quarters);  // |a| <= pi / 4
  const double a2 = a * a;
  double sine = 1.0;
  double cosine = 1.0;
  for (int n = 8; n >= 1; --n) {
    sine = 1.0 - sine * (a2 * kReciprocal[2 * n] * kReciprocal[2 * n + 1]);
    cosine = 1.0 - cosine * (a2 * kReciprocal[2 * n] * kReciprocal[2 * n - 1]);
  }
  sine *= a;
  const double turns = quarters - 4.0 * std::floor(0.25 * quarters);
  if (turns == 0.0) return {sine, cosine};
  if (turns == 1.0) return {cosine, -sine};
  if (turns == 2.0) return {-sine, -cosine};
  return {-cosine, sine};
}

}  // namespace grtx::frontend
