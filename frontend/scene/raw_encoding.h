// How RawRows encodes colour and opacity, for readers of formats that store them in another way.
#pragma once

#include <cmath>

namespace grtx::frontend {

inline constexpr double kShC0 = 0.28209479177387814;  ///< value of the first spherical harmonic, 1 / (2 sqrt(pi))

/// Inverse of the sigmoid; -infinity at 0 and +infinity at 1.
inline float logit_of(double opacity) { return static_cast<float>(std::log(opacity) - std::log1p(-opacity)); }

}  // namespace grtx::frontend
