// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/reference/reference_sh.h"

#include <algorithm>

namespace grtx::frontend {

glm::dvec3 reference_colour(const float* sh, unsigned degree, const glm::dvec3& d) {
  const double x = d.x;
  const double y = d.y;
  const double z = d.z;
  const double xx = x * x;
  const double yy = y * y;
  const double zz = z * z;
  const double basis[25] = {
      0.28209479177387814,
      -0.4886025119029199 * y,
      0.4886025119029199 * z,
      -0.4886025119029199 * x,
      1.0925484305920792 * x * y,
      -1.0925484305920792 * y * z,
      0.31539156525252005 * (2.0 * zz - xx - yy),
      -1.0925484305920792 * x * z,
      0.5462742152960396 * (xx - yy),
      -0.5900435899266435 * y * (3.0 * xx - yy),
      2.890611442640554 * x * y * z,
      -0.4570457994644658 * y * (4.0 * zz - xx - yy),
      0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
      -0.4570457994644658 * x * (4.0 * zz - xx - yy),
      1.445305721320277 * z * (xx - yy),
      -0.5900435899266435 * x * (xx - 3.0 * yy),
      2.5033429417967046 * x * y * (xx - yy),
      -1.7701307697799304 * y * z * (3.0 * xx - yy),
      0.9461746957575601 * x * y * (7.0 * zz - 1.0),
      -0.6690465435572892 * y * z * (7.0 * zz - 3.0),
      0.10578554691520431 * (zz * (35.0 * zz - 30.0) + 3.0),
      -0.6690465435572892 * x * z * (7.0 * zz - 3.0),
      0.47308734787878004 * (xx - yy) * (7.0 * zz - 1.0),
      -1.7701307697799304 * x * z * (xx - 3.0 * yy),
      0.6258357354491761 * (xx * (xx - 3.0 * yy) - yy * (3.0 * xx - yy)),
  };
  const unsigned coefficients = (degree + 1) * (degree + 1);
  glm::dvec3 sum(0.5);
  for (unsigned k = 0; k < coefficients; ++k) {
    for (unsigned c = 0; c < 3; ++c) sum[static_cast<int>(c)] += basis[k] * static_cast<double>(sh[3 * k + c]);
  }
  return {std::max(sum.x, 0.0), std::max(sum.y, 0.0), std::max(sum.z, 0.0)};
}

}  // namespace grtx::frontend
