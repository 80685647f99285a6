// SPDX-License-Identifier: Apache-2.0
// Elementary functions that give the same bits on every host: mathematical libraries use different code on different
// processors. Uses only IEEE +, -, *, /, sqrt and exact operations; relative error about 1e-15.
#pragma once

namespace grtx::frontend {

/// e^x for |x| < 700.
double portable_exp(double x);
/// Natural logarithm of x > 0.
double portable_log(double x);

struct SineCosine {
  double sine, cosine;
};
/// Sine and cosine of 2 pi u.
SineCosine portable_turn(double u);

}  // namespace grtx::frontend
