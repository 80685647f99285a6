// SPDX-License-Identifier: Apache-2.0
// The reference agrees with a straightforward evaluation in long double: explicit covariance inverse, world-space
// triangles of the published vertex table, one loop over everything.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <random>

#include "grtx/frontend/reference/reference.h"

namespace grtx::frontend {
namespace {

using Real = long double;
using Vec = glm::vec<3, Real>;
using Mat = glm::mat<3, 3, Real>;
using Triangle = std::array<Vec, 3>;

constexpr Real kInfinity = std::numeric_limits<Real>::infinity();

/// Unit-inradius icosahedron of 3DGRT: facts of particlePrimitives.cu.
std::vector<Triangle> icosahedron() {
  const Real p = (1.0L + std::sqrt(5.0L)) / 2.0L;
  const Vec v[12] = {{-1, p, 0}, {1, p, 0},  {0, 1, -p},  {-p, 0, -1}, {-p, 0, 1}, {0, 1, p},
                     {p, 0, 1},  {0, -1, p}, {-1, -p, 0}, {0, -1, -p}, {p, 0, -1}, {1, -p, 0}};
  const int f[20][3] = {{0, 1, 2},  {0, 2, 3},   {0, 3, 4},  {0, 4, 5},   {0, 5, 1}, {6, 1, 5},  {6, 5, 7},
                        {6, 7, 11}, {6, 11, 10}, {6, 10, 1}, {8, 4, 3},   {8, 3, 9}, {8, 9, 11}, {8, 11, 7},
                        {8, 7, 4},  {9, 3, 2},   {9, 2, 10}, {9, 10, 11}, {5, 4, 7}, {1, 10, 2}};
  std::vector<Triangle> faces;
  const Real scale = std::sqrt(3.0L) / (p * p);
  for (const auto& face : f) faces.push_back({v[face[0]] * scale, v[face[1]] * scale, v[face[2]] * scale});
  return faces;
}

std::vector<Triangle> icosphere() {
  std::vector<Triangle> faces;
  const Real scale = 1.0L / 0.934172358962715696L;  // inscribed distance of the nearer face class
  for (const auto& [p, q, r] : icosahedron()) {
    const Vec a = glm::normalize(p) * scale;
    const Vec b = glm::normalize(q) * scale;
    const Vec c = glm::normalize(r) * scale;
    const Vec ab = glm::normalize(a + b) * scale;
    const Vec bc = glm::normalize(b + c) * scale;
    const Vec ca = glm::normalize(c + a) * scale;
    faces.insert(faces.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return faces;
}

struct OracleGaussian {
  Vec mean;
  Mat inverse;  ///< of the covariance
  Mat to_world;
  Real opacity, kappa;
};

OracleGaussian prepare(const Scene& scene, std::size_t i, bool adaptive) {
  const glm::quat f = scene.rotation[i];
  glm::vec<4, Real> q{f.w, f.x, f.y, f.z};
  q /= glm::length(q);
  const Real w = q[0], x = q[1], y = q[2], z = q[3];
  const Mat r(Vec(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
              Vec(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
              Vec(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)));
  const Vec s(scene.scale[i]);
  Mat inverse_square(Real{0});
  Mat stretch(Real{0});
  for (int k = 0; k < 3; ++k) {
    inverse_square[k][k] = 1 / (s[k] * s[k]);
    stretch[k][k] = s[k];
  }
  const Real o = scene.opacity[i];
  const Real kappa = adaptive ? std::sqrt(-2 * std::log(std::min(0.0113L / o, 0.97L))) : 3.0L;
  return {Vec(scene.mean[i]), r * inverse_square * glm::transpose(r), r * stretch, o, kappa};
}

struct Entry {
  Real front = kInfinity;  ///< nearest front face at any t
  Real back = -kInfinity;  ///< farthest back face
};

Entry meet(const std::vector<Triangle>& faces, const OracleGaussian& g, const Vec& origin, const Vec& d) {
  Entry entry;
  for (const Triangle& face : faces) {
    const Vec a = g.mean + g.to_world * (face[0] * g.kappa);
    const Vec e1 = g.mean + g.to_world * (face[1] * g.kappa) - a;
    const Vec e2 = g.mean + g.to_world * (face[2] * g.kappa) - a;
    const Vec n = glm::cross(e1, e2);
    const Real slope = glm::dot(n, d);
    const Real t = glm::dot(n, a - origin) / slope;
    const Vec inside = origin + t * d - a;
    const Real u = glm::dot(glm::cross(inside, e2), n) / glm::dot(n, n);
    const Real v = glm::dot(glm::cross(e1, inside), n) / glm::dot(n, n);
    if (u < 0 || v < 0 || u + v > 1) continue;
    if (slope < 0) entry.front = std::min(entry.front, t);
    if (slope > 0) entry.back = std::max(entry.back, t);
  }
  return entry;
}

Vec colour(const Scene& scene, std::size_t id, const Vec& d) {
  const Real theta = std::acos(std::clamp<Real>(d.z, -1, 1));
  const Real phi = std::atan2(d.y, d.x);
  Vec sum(Real{0.5L});
  for (unsigned l = 0; l <= scene.sh_degree; ++l) {
    for (int m = -static_cast<int>(l); m <= static_cast<int>(l); ++m) {
      const auto order = static_cast<unsigned>(std::abs(m));
      Real basis = std::sph_legendre(l, order, theta);
      if (m < 0) basis *= std::sqrt(2.0L) * std::sin(static_cast<Real>(order) * phi);
      if (m > 0) basis *= std::sqrt(2.0L) * std::cos(static_cast<Real>(order) * phi);
      const std::size_t k = static_cast<std::size_t>(static_cast<int>(l * l + l) + m);
      for (std::size_t c = 0; c < 3; ++c) {
        sum[static_cast<int>(c)] += basis * static_cast<Real>(scene.sh[(id * scene.sh_coefficients() + k) * 3 + c]);
      }
    }
  }
  return glm::max(sum, Vec(Real{0}));
}

struct OracleHit {
  std::uint32_t id;
  Real t, alpha;
};

std::vector<OracleHit> trace(const Scene& scene, const ReferenceOptions& options, const Vec& origin, const Vec& d,
                             Vec& rgb) {
  const std::vector<Triangle> faces = options.proxy == ReferenceProxy::icosahedron20 ? icosahedron()
                                      : options.proxy == ReferenceProxy::icosphere80 ? icosphere()
                                                                                     : std::vector<Triangle>();
  std::vector<OracleHit> hits;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const OracleGaussian g = prepare(scene, i, options.adaptive_radius);
    const Vec pd = g.inverse * d;
    const Real a = glm::dot(d, pd);
    const Real peak = glm::dot(g.mean - origin, pd) / a;
    const Vec offset = origin + peak * d - g.mean;
    const Real d2 = glm::dot(offset, g.inverse * offset);
    const Real alpha = std::min(0.99L, g.opacity * std::exp(-d2 / 2));
    if (alpha < 1.0L / 255.0L || d2 > g.kappa * g.kappa) continue;
    Entry entry;
    if (faces.empty()) {
      const Real half = std::sqrt((g.kappa * g.kappa - d2) / a);
      entry = {peak - half, peak + half};
    } else {
      entry = meet(faces, g, origin, d);
    }
    Real t = options.sort_by_peak ? peak : entry.front;
    if (entry.front < 0) {
      if (!options.count_inside || entry.back < 0 || peak <= 0) continue;
      if (!options.sort_by_peak) t = 0;
    }
    hits.push_back({static_cast<std::uint32_t>(i), t, alpha});
  }
  std::sort(hits.begin(), hits.end(),
            [](const OracleHit& x, const OracleHit& y) { return x.t != y.t ? x.t < y.t : x.id < y.id; });
  rgb = Vec(Real{0});
  Real transmittance = 1;
  std::size_t count = 0;
  while (count < hits.size()) {
    const OracleHit& hit = hits[count++];
    const Vec to = options.sh_from_centre ? glm::normalize(Vec(scene.mean[hit.id]) - origin) : glm::normalize(d);
    rgb += transmittance * hit.alpha * colour(scene, hit.id, to);
    transmittance *= 1 - hit.alpha;
    if (transmittance < static_cast<Real>(options.ert)) break;
  }
  hits.resize(count);
  return hits;
}

Scene random_scene(unsigned seed, std::size_t count, unsigned degree, float smallest_scale, float largest_scale) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::normal_distribution<float> normal;
  Scene scene;
  scene.sh_degree = degree;
  scene.offset = glm::dvec3(1000.5, -3.25, 7.0);
  for (std::size_t i = 0; i < count; ++i) {
    // One statement a number: in which order the arguments of a call are drawn is the compiler's choice.
    glm::vec3 mean;
    for (int k = 2; k >= 0; --k) mean[k] = normal(random);
    scene.mean.push_back(mean * 2.0f);
    glm::vec3 scale;
    for (int k = 0; k < 3; ++k) scale[k] = smallest_scale * std::pow(largest_scale / smallest_scale, unit(random));
    scene.scale.push_back(scale);
    float wxyz[4];
    for (int k = 3; k >= 0; --k) wxyz[k] = normal(random);
    scene.rotation.push_back(glm::normalize(glm::quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3])));
    scene.opacity.push_back(unit(random) < 0.2f ? 1.0f : unit(random));
    for (unsigned k = 0; k < 3 * scene.sh_coefficients(); ++k) scene.sh.push_back(0.5f * normal(random));
  }
  return scene;
}

/// Looks along +z from 6 units before the cloud's middle, or from within it.
Camera camera(double distance) {
  Camera c;
  c.height = 9;
  c.width = 11;
  c.fx = c.fy = 7.0;
  c.cx = 5.5;
  c.cy = 4.5;
  c.position = glm::dvec3(1000.5, -3.25, 7.0 - distance);
  return c;
}

struct SceneCase {
  ReferenceOptions options;
  double distance;
};

std::vector<SceneCase> cases() {
  std::vector<SceneCase> list;
  for (const ReferenceProxy proxy :
       {ReferenceProxy::icosahedron20, ReferenceProxy::icosphere80, ReferenceProxy::sphere}) {
    for (const double distance : {6.0, 0.0}) {
      for (int variant = 0; variant < 4; ++variant) {
        ReferenceOptions options;
        options.proxy = proxy;
        options.keep_sequences = true;
        options.threads = 1 + static_cast<unsigned>(variant) % 2;
        options.sort_by_peak = variant == 1;
        options.adaptive_radius = variant != 2;
        options.sh_from_centre = variant == 3;
        options.count_inside = proxy == ReferenceProxy::sphere && variant >= 1;
        if (variant == 3) options.ert = 0.3;
        list.push_back({options, distance});
      }
    }
  }
  return list;
}

TEST(ReferenceOracle, EveryOptionAgreesWithLongDouble) {
  std::size_t blended = 0;
  unsigned seed = 1;
  for (const SceneCase& c : cases()) {
    const Scene scene = random_scene(seed, 60, seed % 5, 0.02f, 1.5f);
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " proxy " << static_cast<int>(c.options.proxy) << " peak "
                                      << c.options.sort_by_peak << " distance " << c.distance);
    ++seed;
    const Camera view = camera(c.distance);
    const ReferenceResult result = render_reference(scene, view, c.options);
    const Vec origin(glm::vec3(view.position - scene.offset));
    for (unsigned y = 0; y < view.height; ++y) {
      for (unsigned x = 0; x < view.width; ++x) {
        const Vec d(glm::vec3(view.direction(x, y)));
        Vec rgb;
        const std::vector<OracleHit> expected = trace(scene, c.options, origin, d, rgb);
        const std::vector<ReferenceHit>& got = result.sequences[y * view.width + x];
        ASSERT_EQ(got.size(), expected.size()) << x << ' ' << y;
        for (std::size_t i = 0; i < got.size(); ++i) {
          ASSERT_EQ(got[i].gaussian, expected[i].id) << x << ' ' << y;
          ASSERT_NEAR(got[i].t, static_cast<double>(expected[i].t), 1e-11);
          ASSERT_NEAR(got[i].alpha, static_cast<double>(expected[i].alpha), 1e-11);
        }
        blended += got.size();
        // Directions are unit to fp32 only; the reference does not normalise them again for SH, the oracle does.
        for (int k = 0; k < 3; ++k) {
          ASSERT_NEAR(result.image.at(x, y)[k], static_cast<float>(rgb[k]), 2e-6f);
        }
      }
    }
  }
  EXPECT_GT(blended, 5000u);  // the table is not vacuous
}

TEST(ReferenceOracle, NeedlesAndFlakesOfRatioAMillionAgree) {
  Scene scene = random_scene(77, 200, 0, 1e-6f, 1.0f);
  ReferenceOptions options;
  options.keep_sequences = true;
  const Camera view = camera(6.0);
  const ReferenceResult result = render_reference(scene, view, options);
  const Vec origin(glm::vec3(view.position - scene.offset));
  std::size_t hits = 0;
  for (unsigned y = 0; y < view.height; ++y) {
    for (unsigned x = 0; x < view.width; ++x) {
      Vec rgb;
      const std::vector<OracleHit> expected = trace(scene, options, origin, Vec(glm::vec3(view.direction(x, y))), rgb);
      const std::vector<ReferenceHit>& got = result.sequences[y * view.width + x];
      ASSERT_EQ(got.size(), expected.size());
      for (std::size_t i = 0; i < got.size(); ++i) {
        ASSERT_EQ(got[i].gaussian, expected[i].id);
        ASSERT_NEAR(got[i].alpha, static_cast<double>(expected[i].alpha), 1e-6);
      }
      hits += got.size();
    }
  }
  EXPECT_GT(hits, 50u);
}

}  // namespace
}  // namespace grtx::frontend
