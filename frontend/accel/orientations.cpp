#include "grtx/frontend/accel/orientations.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace grtx::frontend {
namespace {

struct Quaternion {
  int w, x, y, z;
  double length = std::sqrt(static_cast<double>(w * w + x * x + y * y + z * z));
};

constexpr int kMostComponent = 3;

// Half of them: the other half are the same rotations.
std::vector<Quaternion> candidates() {
  std::vector<Quaternion> all;
  constexpr int n = kMostComponent;
  for (int w = 0; w <= n; ++w) {
    for (int x = -n; x <= n; ++x) {
      for (int y = -n; y <= n; ++y) {
        for (int z = -n; z <= n; ++z) {
          if (w != 0 || x != 0 || y != 0 || z != 0) all.push_back({w, x, y, z});
        }
      }
    }
  }
  return all;
}

// Cosine of half the least angle between two boxes turned so: the components of b conj(a), which turns the axes of a
// into those of b, against the quaternions of the 24 rotations that leave a box as it is: 1 (one component), 1/sqrt(2)
// (two) and 1/2 (all four).
double likeness(const Quaternion& a, const Quaternion& b) {
  std::array<int, 4> r = {
      std::abs(a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z), std::abs(a.w * b.x - a.x * b.w + a.y * b.z - a.z * b.y),
      std::abs(a.w * b.y - a.x * b.z - a.y * b.w + a.z * b.x), std::abs(a.w * b.z + a.x * b.y - a.y * b.x - a.z * b.w)};
  std::sort(r.begin(), r.end());
  const double two = static_cast<double>(r[3] + r[2]) / std::sqrt(2.0);
  const double four = static_cast<double>(r[0] + r[1] + r[2] + r[3]) / 2.0;
  return std::max({static_cast<double>(r[3]), two, four}) / (a.length * b.length);
}

Orientation rows_of(const Quaternion& q) {
  const int w = q.w, x = q.x, y = q.y, z = q.z;
  const int n = w * w + x * x + y * y + z * z;
  constexpr double kSteps = 1 << kOrientationFractionBits;
  const auto entry = [&](int numerator) {
    return static_cast<float>(std::floor(kSteps * numerator / n + 0.5) / kSteps);
  };
  return {glm::vec3(entry(n - 2 * (y * y + z * z)), entry(2 * (x * y - w * z)), entry(2 * (x * z + w * y))),
          glm::vec3(entry(2 * (x * y + w * z)), entry(n - 2 * (x * x + z * z)), entry(2 * (y * z - w * x))),
          glm::vec3(entry(2 * (x * z - w * y)), entry(2 * (y * z + w * x)), entry(n - 2 * (x * x + y * y)))};
}

std::array<Orientation, kOrientations> spread() {
  const std::vector<Quaternion> all = candidates();
  std::vector<double> nearest(all.size(), 0.0);
  std::array<Orientation, kOrientations> chosen;
  Quaternion last{1, 0, 0, 0};
  for (unsigned i = 0;; ++i) {
    chosen[i] = rows_of(last);
    if (i + 1 == kOrientations) return chosen;
    std::size_t farthest = 0;
    for (std::size_t c = 0; c < all.size(); ++c) {
      nearest[c] = std::max(nearest[c], likeness(last, all[c]));
      if (nearest[c] < nearest[farthest]) farthest = c;
    }
    last = all[farthest];
  }
}

}  // namespace

const std::array<Orientation, kOrientations>& orientations() {
  static const std::array<Orientation, kOrientations> all = spread();
  return all;
}

}  // namespace grtx::frontend
