// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/synth/synth_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "grtx/frontend/numbers/portable_math.h"

namespace grtx::frontend {
namespace {

constexpr double kPi = 3.141592653589793;
// Contrast that a Gaussian loses if its footprint is as large as the pattern. Less than a box filter removes:
// neighbours blur again, and a fit compensates for that.
constexpr double kBlur = 0.25;

/// Two unit vectors that complete `normal` to a right-handed frame.
void frame_of(const glm::dvec3& normal, glm::dvec3& u, glm::dvec3& v) {
  const glm::dvec3 other = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  u = glm::normalize(glm::cross(other, normal));
  v = glm::cross(normal, u);
}

double hill(const glm::dvec3& at) { return 0.12 * value_noise(11, at * 0.35) + 0.03 * value_noise(12, at * 1.7); }

SynthPoint on_quad(const SynthPatch& patch, CounterRandom& random) {
  SynthPoint point;
  const double s = random.uniform();
  const double t = random.uniform();
  point.position = patch.origin + s * patch.a + t * patch.b;
  point.normal = glm::normalize(glm::cross(patch.a, patch.b));
  if (patch.shape == SynthShape::ground) {
    const double step = 0.05;
    const glm::dvec3 u = glm::normalize(patch.a);
    const glm::dvec3 v = glm::normalize(patch.b);
    const double height = hill(point.position);
    const double along_u = (hill(point.position + step * u) - height) / step;
    const double along_v = (hill(point.position + step * v) - height) / step;
    const glm::dvec3 up = point.normal;
    point.position += height * up;
    point.normal = glm::normalize(up - along_u * u - along_v * v);
  }
  return point;
}

SynthPoint on_ellipsoid(const SynthPatch& patch, CounterRandom& random) {
  SynthPoint point;
  const glm::dvec3 d = random.direction();
  point.position = patch.origin + d.x * patch.a + d.y * patch.b + d.z * patch.c;
  point.normal =
      glm::normalize(patch.a * (d.x / glm::dot(patch.a, patch.a)) + patch.b * (d.y / glm::dot(patch.b, patch.b)) +
                     patch.c * (d.z / glm::dot(patch.c, patch.c)));
  return point;
}

SynthPoint on_cylinder(const SynthPatch& patch, CounterRandom& random) {
  SynthPoint point;
  const SineCosine turn = portable_turn(random.uniform());
  const glm::dvec3 side = turn.cosine * patch.a + turn.sine * patch.b;
  point.position = patch.origin + side + random.uniform() * patch.c;
  point.normal = glm::normalize(side);
  return point;
}

SynthPoint on_leaf(const SynthPatch& patch, std::uint64_t seed, std::uint64_t leaves, CounterRandom& random) {
  const std::uint64_t leaf = random.bits() % std::max<std::uint64_t>(1, leaves);
  CounterRandom shape(seed, 0x1eaf0000u + patch.object, leaf);
  const glm::dvec3 d = shape.direction();
  const double depth = 1.0 - 0.55 * shape.uniform() * shape.uniform();  // most leaves near the clump's outside
  const glm::dvec3 centre = patch.origin + depth * (d.x * patch.a + d.y * patch.b + d.z * patch.c);
  const glm::dvec3 outward = glm::normalize(d.x * patch.a + d.y * patch.b + d.z * patch.c);
  const glm::dvec3 normal = glm::normalize(outward + 0.9 * shape.direction());
  glm::dvec3 u;
  glm::dvec3 v;
  frame_of(normal, u, v);
  const SineCosine turn = portable_turn(shape.uniform());
  const glm::dvec3 along = turn.cosine * u + turn.sine * v;
  const glm::dvec3 across = glm::cross(normal, along);
  const SineCosine at = portable_turn(random.uniform());
  const double radius = patch.leaf_radius * shape.uniform(0.6, 1.4) * std::sqrt(random.uniform());
  SynthPoint point;
  point.position = centre + radius * (at.cosine * along + 0.45 * at.sine * across);
  point.normal = normal;
  point.noise = shape.uniform(-1.0, 1.0);
  return point;
}

SynthPoint in_haze(const SynthPatch& patch, CounterRandom& random) {
  SynthPoint point;
  const glm::dvec3 d = random.direction();
  double radius = 0.0;  // the largest of three uniform numbers has the density 3 r^2 of a ball
  for (int i = 0; i < 3; ++i) radius = std::max(radius, random.uniform());
  point.position = patch.origin + radius * (d.x * patch.a + d.y * patch.b + d.z * patch.c);
  point.normal = glm::dvec3(0.0);
  return point;
}

/// 0 or 1 alternating, with a small soft joint; `x` in pattern sizes.
double joint(double x, double width) {
  const double f = x - std::floor(x);
  return f < width || f > 1.0 - width ? 1.0 : 0.0;
}

double lattice(std::uint64_t seed, double i, double j) {
  return CounterRandom(seed, static_cast<std::uint64_t>(static_cast<std::int64_t>(i)),
                       static_cast<std::uint64_t>(static_cast<std::int64_t>(j)))
      .uniform();
}

}  // namespace

SynthPoint sample_patch(const SynthPatch& patch, std::uint64_t seed, std::uint64_t leaves, CounterRandom& random) {
  SynthPoint point;
  switch (patch.shape) {
    case SynthShape::quad:
    case SynthShape::ground:
      point = on_quad(patch, random);
      break;
    case SynthShape::ellipsoid:
      point = on_ellipsoid(patch, random);
      break;
    case SynthShape::cylinder:
      point = on_cylinder(patch, random);
      break;
    case SynthShape::leaves:
      return on_leaf(patch, seed, leaves, random);
    case SynthShape::haze:
      point = in_haze(patch, random);
      break;
  }
  point.noise = value_noise(seed + patch.object, point.position / std::max(1e-6, 2.0 * patch.texture.size));
  return point;
}

glm::dvec3 patch_colour(const SynthPatch& patch, const SynthPoint& point, double footprint, std::uint64_t seed) {
  const SynthTexture& texture = patch.texture;
  const glm::dvec3 d = point.position - patch.pattern_origin;
  // Pattern coordinates: along the patch for rectangles, around the vertical otherwise.
  double s = d.x + d.z;
  double t = d.y;
  if (patch.shape == SynthShape::quad || patch.shape == SynthShape::ground) {
    s = glm::dot(d, glm::normalize(patch.a));
    t = glm::dot(d, glm::normalize(patch.b));
  }
  s /= texture.size;
  t /= texture.size;
  double mix = 0.0;
  switch (texture.pattern) {
    case SynthPattern::plain:
      mix = 0.5 + 0.12 * point.noise;
      break;
    case SynthPattern::mottled:
      mix = 0.5 + 0.45 * point.noise + 0.25 * value_noise(seed + 5, point.position / (0.4 * texture.size));
      break;
    case SynthPattern::planks:
      mix = 0.8 * lattice(seed + 1, std::floor(s), std::floor(t / 7.0 + 0.37 * std::floor(s))) + 0.1 * point.noise;
      mix = std::max(mix, joint(s, 0.06));
      break;
    case SynthPattern::tiles:
      mix = std::max(joint(s, 0.05), joint(t, 0.05)) + 0.08 * point.noise;
      break;
    case SynthPattern::bricks: {
      const double row = std::floor(t);
      const double shifted = 0.4 * s + 0.5 * row;
      mix = std::max({joint(t, 0.1), joint(shifted, 0.05), 0.5 * lattice(seed + 2, std::floor(shifted), row)});
      break;
    }
    case SynthPattern::stripes:
      mix = 0.5 + 0.5 * portable_turn(s).sine;
      break;
    case SynthPattern::books: {
      const double shelf = std::floor(t / 6.0);
      const double column = std::floor(s + 0.3 * shelf);
      if (joint(t / 6.0, 0.07) > 0.0) return texture.first;
      const glm::dvec3 cover(lattice(seed + 3, column, shelf), lattice(seed + 4, column, shelf),
                             lattice(seed + 5, column, shelf));
      const double blur = std::min(1.0, footprint / texture.size);
      return 0.15 + (0.6 * (1.0 - blur) * cover + 0.3 * blur) * texture.second + 0.1 * joint(s + 0.3 * shelf, 0.12);
    }
    case SynthPattern::picture: {
      const double sky = value_noise(seed + patch.object, d / (6.0 * texture.size));
      mix = 0.5 + 0.9 * sky + 0.4 * value_noise(seed + patch.object + 1, d / (2.0 * texture.size));
      break;
    }
  }
  const double mean = texture.pattern == SynthPattern::tiles || texture.pattern == SynthPattern::bricks ? 0.25 : 0.5;
  const double blur = std::min(1.0, kBlur * footprint / texture.size);
  mix = std::clamp(mix * (1.0 - blur) + mean * blur, 0.0, 1.0);
  return texture.first * (1.0 - mix) + texture.second * mix;
}

SynthPatch& SynthLayout::style(SynthTexture texture, double detail) {
  const std::uint32_t next = style_.object + 1;
  style_ = SynthPatch();
  style_.object = next;
  style_.texture = texture;
  style_.detail = detail;
  return style_;
}

void SynthLayout::add(SynthPatch patch, double area) {
  patch.area = area;
  patches_.push_back(patch);
}

void SynthLayout::refine(std::size_t first, double by) {
  for (std::size_t i = first; i < patches_.size(); ++i) patches_[i].detail -= by;
}

void SynthLayout::quad(glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b, double cell) {
  const int across = std::max(1, static_cast<int>(glm::length(a) / cell + 0.5));
  const int along = std::max(1, static_cast<int>(glm::length(b) / cell + 0.5));
  SynthPatch patch = style_;
  if (patch.shape != SynthShape::ground) patch.shape = SynthShape::quad;
  patch.pattern_origin = origin;
  patch.whole_a = glm::length(a);
  patch.whole_b = glm::length(b);
  patch.a = a / static_cast<double>(across);
  patch.b = b / static_cast<double>(along);
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < along; ++j) {
      patch.origin = origin + static_cast<double>(i) * patch.a + static_cast<double>(j) * patch.b;
      add(patch, glm::length(glm::cross(patch.a, patch.b)));
    }
  }
}

void SynthLayout::ground(glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b, double cell) {
  style_.shape = SynthShape::ground;
  quad(origin, a, b, cell);
  style_.shape = SynthShape::quad;
}

void SynthLayout::box(glm::dvec3 foot, glm::dvec3 size, bool bottom) {
  const glm::dvec3 x(size.x, 0, 0);
  const glm::dvec3 y(0, size.y, 0);
  const glm::dvec3 z(0, 0, size.z);
  const glm::dvec3 low = foot - 0.5 * x - 0.5 * z - y;  // smallest x, y, z; y points down, so this is the top
  quad(low, x, z * 1.0);                                // x cross z = -y: up
  patches_.back().pattern_origin = low;
  quad(low, y, x);      // y cross x = -z
  quad(low + z, x, y);  // x cross y = +z
  quad(low, z, y);      // z cross y = -x
  quad(low + x, y, z);  // y cross z = +x
  if (bottom) quad(low + y, z, x);
}

void SynthLayout::ellipsoid(glm::dvec3 centre, glm::dvec3 radii) {
  SynthPatch patch = style_;
  patch.shape = SynthShape::ellipsoid;
  patch.origin = patch.pattern_origin = centre;
  patch.a = {radii.x, 0, 0};
  patch.b = {0, radii.y, 0};
  patch.c = {0, 0, radii.z};
  // The mean of the three products is within a few per cent of the surface for the shapes used here.
  add(patch, 4.0 * kPi / 3.0 * (radii.x * radii.y + radii.y * radii.z + radii.z * radii.x));
}

void SynthLayout::cylinder(glm::dvec3 from, glm::dvec3 to, double radius) {
  SynthPatch patch = style_;
  patch.shape = SynthShape::cylinder;
  patch.origin = patch.pattern_origin = from;
  patch.c = to - from;
  glm::dvec3 u;
  glm::dvec3 v;
  frame_of(glm::normalize(patch.c), u, v);
  patch.a = radius * u;
  patch.b = radius * v;
  add(patch, 2.0 * kPi * radius * glm::length(patch.c));
}

void SynthLayout::leaves(glm::dvec3 centre, glm::dvec3 radii, double leaf_radius) {
  ellipsoid(centre, radii);
  SynthPatch& patch = patches_.back();
  patch.shape = SynthShape::leaves;
  patch.leaf_radius = leaf_radius;
  patch.object = ++style_.object;  // every clump is an object of its own
  patch.area *= 2.0;               // a few layers deep
}

void SynthLayout::haze(glm::dvec3 centre, glm::dvec3 radii) {
  ellipsoid(centre, radii);
  patches_.back().shape = SynthShape::haze;
}

}  // namespace grtx::frontend
