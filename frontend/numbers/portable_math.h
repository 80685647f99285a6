// Elementary functions whose last bit is the same on every host: mathematical libraries choose other code for other
// processors. Only IEEE +, -, *, /, sqrt and exact operations are used; relative error about 1e-15.
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
