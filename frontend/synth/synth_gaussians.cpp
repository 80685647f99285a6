// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/synth/synth_gaussians.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

#include "grtx/frontend/numbers/portable_math.h"

namespace grtx::frontend {
namespace {

constexpr double kPi = 3.141592653589793;
// Each expression below draws at most one number from a generator: compilers may evaluate operands in any order.
// Streams of random numbers; a patch uses kPosition + its number.
enum Stream : std::uint64_t { kDensity = 1, kShell = 3, kFar = 4, kShape = 5, kPosition = 1000 };

float logit(double opacity) { return static_cast<float>(portable_log(opacity / (1.0 - opacity))); }

/// Distribution function of the normal distribution within 2e-4 (logistic with a cubic term).
double normal_share(double z) { return 1.0 / (1.0 + portable_exp(-1.5976 * z - 0.07056 * z * z * z)); }

/// Opacity at rank `u` (0..1) of a histogram over tenths. Uniform inside a tenth, but the last one piles up at 0.996,
/// where 8-bit sources end, and the first one starts at 0.002.
double opacity_at(const std::array<double, 10>& shares, double u) {
  double total = 0.0;
  for (const double share : shares) total += share;
  double rest = u * total;
  std::size_t tenth = 0;
  while (tenth < 9 && rest >= shares[tenth]) rest -= shares[tenth++];
  const double f = std::clamp(rest / shares[tenth], 0.0, 1.0);
  if (tenth == 0) return 0.002 + 0.098 * f;
  if (tenth == 9) return 0.9 + 0.0965 * (1.0 - (1.0 - f) * (1.0 - f) * (1.0 - f) * (1.0 - f));
  return 0.1 * (static_cast<double>(tenth) + f);
}

/// Quaternion w x y z of a rotation matrix with the given columns (Shepperd's rule).
std::array<double, 4> quaternion(const glm::dmat3& m) {
  const double trace = m[0][0] + m[1][1] + m[2][2];
  std::array<double, 4> q{};
  if (trace > 0.0) {
    const double s = 2.0 * std::sqrt(trace + 1.0);
    q = {0.25 * s, (m[1][2] - m[2][1]) / s, (m[2][0] - m[0][2]) / s, (m[0][1] - m[1][0]) / s};
  } else {
    int i = 0;
    for (int k = 1; k < 3; ++k) {
      if (m[k][k] > m[i][i]) i = k;
    }
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    const double s = 2.0 * std::sqrt(1.0 + m[i][i] - m[j][j] - m[k][k]);
    q[0] = (m[j][k] - m[k][j]) / s;
    q[static_cast<std::size_t>(i) + 1] = 0.25 * s;
    q[static_cast<std::size_t>(j) + 1] = (m[i][j] + m[j][i]) / s;
    q[static_cast<std::size_t>(k) + 1] = (m[i][k] + m[k][i]) / s;
  }
  return q;
}

/// Stores scales and rotation: `large` is the axis of the largest scale, `normal` that of the smallest. The axes are
/// numbered at random and the quaternion has a random length and sign, as in trained files.
void shape_row(PlyRow& row, glm::dvec3 large, const glm::dvec3& normal, const std::array<double, 3>& log_scales,
               CounterRandom& random) {
  large = glm::normalize(large - glm::dot(large, normal) * normal);
  const glm::dvec3 middle = glm::cross(normal, large);
  const glm::dvec3 axes[3] = {large, middle, normal};
  const auto turn = static_cast<unsigned>(random.bits() % 3);
  const bool swap = (random.bits() & 1u) != 0;
  glm::dmat3 m;
  for (unsigned i = 0; i < 3; ++i) {
    unsigned from = (i + turn) % 3;
    if (swap && from < 2) from = 1 - from;
    m[static_cast<int>(i)] = axes[from];
    row.log_scale[i] = static_cast<float>(log_scales[from]);
  }
  if (swap) m[0] = -m[0];  // exchanging two axes mirrors the frame; a negated axis restores it
  std::array<double, 4> q = quaternion(m);
  double length = portable_exp(0.25 * random.normal());
  if ((random.bits() & 1u) != 0) length = -length;
  for (std::size_t i = 0; i < 4; ++i) row.rotation[i] = static_cast<float>(length * q[i]);
}

glm::dvec3 any_perpendicular(const glm::dvec3& normal, CounterRandom& random) {
  for (;;) {
    const glm::dvec3 d = random.direction();
    if (std::abs(glm::dot(d, normal)) < 0.99) return glm::normalize(glm::cross(normal, d));
  }
}

/// ln d8 of a patch by how well a capture sees it: from the distance of the nearest camera that has it in view and that
/// it faces; coarse without one.
double captured_spacing(const SynthPatch& patch, const SynthWorld& world) {
  constexpr double kNearest = 0.08;  // in diagonals: detail does not grow below this distance
  constexpr double kUnseen = 0.9;
  const bool flat = patch.shape == SynthShape::quad || patch.shape == SynthShape::ground;
  const glm::dvec3 middle = flat ? patch.origin + 0.5 * (patch.a + patch.b) : patch.origin;
  const double radius = 0.5 * (glm::length(patch.a) + glm::length(patch.b));
  double nearest = std::numeric_limits<double>::max();
  double seen = nearest;
  for (const Camera& camera : world.cameras) {
    const glm::dvec3 from_eye = middle - camera.position;
    const double distance = glm::length(from_eye);
    nearest = std::min(nearest, distance);
    if (flat && glm::dot(from_eye, glm::cross(patch.a, patch.b)) > 0.0) continue;
    const glm::dvec3 at = glm::transpose(camera.rotation) * from_eye;
    const double half = std::max(0.0, at.z) * 0.5 * camera.width / camera.fx + radius;
    if (at.z > -radius && std::abs(at.x) < half && std::abs(at.y) < half) seen = std::min(seen, distance);
  }
  const double at = std::max(std::min(seen, 2.0 * nearest) / world.diagonal, kNearest);
  return world.statistics.capture * portable_log(at) + (seen < std::numeric_limits<double>::max() ? 0.0 : kUnseen);
}

/// Distances to the rim of the surface that a Gaussian lies on.
struct ToRim {
  double across, along;
  glm::dvec3 direction;  ///< in which `along` is measured
};

ToRim to_rim(const SynthPatch& patch, const glm::dvec3& at) {
  switch (patch.shape) {
    case SynthShape::quad: {
      const glm::dvec3 a = glm::normalize(patch.a);
      const glm::dvec3 b = glm::normalize(patch.b);
      const double s = glm::dot(at - patch.pattern_origin, a);
      const double t = glm::dot(at - patch.pattern_origin, b);
      const double to_a = std::max(0.0, std::min(s, patch.whole_a - s));
      const double to_b = std::max(0.0, std::min(t, patch.whole_b - t));
      return to_a < to_b ? ToRim{to_a, to_b, b} : ToRim{to_b, to_a, a};
    }
    case SynthShape::cylinder:
      return {glm::length(patch.a), glm::length(patch.c), patch.c};
    case SynthShape::ellipsoid: {
      double size[] = {patch.a.x, patch.b.y, patch.c.z};
      std::sort(std::begin(size), std::end(size));
      return {0.6 * size[1], 0.6 * size[2], {0, 0, 0}};
    }
    default:
      return {1e30, 1e30, {0, 0, 0}};
  }
}

/// The axis of the largest scale: along a rim that it would cross, or along the patch's grain, else random.
glm::dvec3 long_axis(const SynthPatch& patch, const glm::dvec3& normal, const glm::dvec3& wobble,
                     const glm::dvec3& along_rim, CounterRandom& random) {
  glm::dvec3 along = any_perpendicular(normal, random);
  const double grain = random.uniform();
  if (grain < 0.75 && glm::dot(patch.grain, patch.grain) > 0.0) {
    const glm::dvec3 wanted = patch.grain + 0.25 * wobble;
    if (glm::length(glm::cross(wanted, normal)) > 0.1 * glm::length(wanted)) along = wanted;
  }
  if (glm::length(glm::cross(along_rim, normal)) > 0.1 * glm::length(along_rim)) along = along_rim;
  return along;
}

}  // namespace

SynthGaussians::SynthGaussians(SynthWorld world, const SynthOptions& options)
    : world_(std::move(world)), options_(options), order_(options.seed, options.count) {
  noise_ = {options.seed, options.sh_degree, world_.statistics.sh_rms};
  world_.light = glm::normalize(world_.light);
  if (world_.background) {
    // Sky: 0.3 % of a small scene to 0.1 % of one with 1 M Gaussians or more, so that it stays a few layers deep.
    const double n = static_cast<double>(options.count);
    const double share = std::clamp(0.003 * std::sqrt(1e5 / n), 0.001, 0.003);
    shell_ = static_cast<std::uint64_t>(share * n + 0.5);
    far_ = std::max<std::uint64_t>(options.count >= 1000 ? 2 : 0, options.count / 10000);
  }
  surface_ = options.count - shell_ - far_;
  allocate(surface_);
}

void SynthGaussians::allocate(std::uint64_t surface_rows) {
  const SynthStatistics& statistics = world_.statistics;
  const std::vector<SynthPatch>& patches = world_.layout.patches();
  const auto volumes = static_cast<double>(
      std::count_if(patches.begin(), patches.end(), [](const SynthPatch& p) { return p.shape == SynthShape::haze; }));
  std::vector<double> weights;
  double surface_weight = 0.0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    CounterRandom object(options_.seed, kDensity, patches[i].object);
    CounterRandom patch(options_.seed, kDensity, (std::uint64_t{1} << 32) + i);
    // ln d8 of a patch: half of its variance is common to the object, so that a wall does not look like a quilt.
    double log_spacing = patches[i].detail + statistics.density_sd * 0.7071 * (object.normal() + patch.normal());
    if (statistics.capture > 0.0) log_spacing += captured_spacing(patches[i], world_);
    const bool volume = patches[i].shape == SynthShape::haze;
    weights.push_back(volume ? 0.0 : patches[i].area * portable_exp(-2.0 * log_spacing));
    surface_weight += weights.back();
  }
  const double haze = volumes > 0.0 ? statistics.haze_share : 0.0;
  double before = 0.0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const bool volume = patches[i].shape == SynthShape::haze;
    const double share = volume ? haze / volumes : (1.0 - haze) * weights[i] / surface_weight;
    const auto edge = [&](double sum) {
      return std::min(surface_rows, static_cast<std::uint64_t>(sum * static_cast<double>(surface_rows) + 0.5));
    };
    Part part;
    part.patch = patches[i];
    part.first = edge(before);
    before += share;
    part.count = (i + 1 == patches.size() ? surface_rows : edge(before)) - part.first;
    const double n = std::max(1.0, static_cast<double>(part.count));
    if (volume) {
      const SynthPatch& p = part.patch;
      const double ball = 4.0 / 3.0 * kPi * glm::length(p.a) * glm::length(p.b) * glm::length(p.c);
      part.spacing = portable_exp(portable_log(8.0 * ball / (4.0 / 3.0 * kPi * n)) / 3.0);
    } else {
      part.spacing = std::sqrt(8.0 * part.patch.area / (kPi * n));
    }
    if (part.patch.shape == SynthShape::leaves) {
      // Leaves cover the clump's area; at least 16 Gaussians per leaf, so that it has a surface.
      const double leaf = 0.45 * kPi * part.patch.leaf_radius * part.patch.leaf_radius;
      part.leaves = static_cast<std::uint64_t>(std::max(1.0, std::min(part.patch.area / leaf, n / 16.0)));
      part.patch.leaf_radius = std::sqrt(part.patch.area / (0.45 * kPi * static_cast<double>(part.leaves)));
    }
    part.log_reach = portable_log(part.leaves > 0 ? 0.35 * part.patch.leaf_radius
                                  : volume        ? 0.12 * part.spacing  // floaters are specks, not fog
                                                  : statistics.reach * std::sqrt(part.patch.area));
    if (part.count > 0) parts_.push_back(part);
  }
}

PlyRow SynthGaussians::row(std::uint64_t index) const {
  const std::uint64_t generation = order_(index);
  if (generation < surface_) return surface_row(generation);
  if (generation < surface_ + shell_) return shell_row(generation);
  return far_row(generation);
}

PlyRow SynthGaussians::surface_row(std::uint64_t generation) const {
  const SynthStatistics& statistics = world_.statistics;
  const auto after = std::upper_bound(parts_.begin(), parts_.end(), generation,
                                      [](std::uint64_t g, const Part& part) { return g < part.first; });
  const Part& part = *(after - 1);
  const std::uint64_t stream = kPosition + static_cast<std::uint64_t>(after - parts_.begin());
  CounterRandom random(options_.seed, kShape, generation);
  std::uint64_t member = generation - part.first;
  if (member > 0 && random.uniform() < statistics.coincident_share) --member;
  CounterRandom place(options_.seed, stream, member);
  SynthPoint point = sample_patch(part.patch, options_.seed, part.leaves, place);
  // One in ten is clearly off the surface, like floaters near surfaces.
  const double spread = statistics.thickness * (place.uniform() < 0.1 ? 4.0 : 1.0);
  const glm::dvec3 surface_point = point.position;
  point.position += spread * part.spacing * place.normal() * point.normal;

  PlyRow row;
  row.position = glm::vec3(point.position);
  const double size_score = random.normal();
  const bool aligned = random.uniform() < statistics.aligned_share;
  // Gaussians across the surface are smaller and fainter; the mean of lies_flat is 0.
  const double lies_flat = (aligned ? 1.0 : 0.0) - statistics.aligned_share;
  const SurfaceSize size = surface_size(part, surface_point, size_score, lies_flat, random);

  glm::dvec3 normal = random.direction();
  const glm::dvec3 wobble{random.normal(), random.normal(), random.normal()};
  if (aligned) normal = glm::normalize(point.normal + statistics.cone * wobble);
  const glm::dvec3 along = long_axis(part.patch, normal, wobble, size.along_rim, random);
  shape_row(row, along, normal, size.log_scales, random);
  row.opacity_logit = opacity_logit(size_score, lies_flat, part.patch.opacity_shift, random);

  if (part.patch.shape == SynthShape::haze) {  // training leaves nothing directly in front of a camera
    for (const Camera& camera : world_.cameras) {
      if (glm::distance(camera.position, point.position) < 0.08 * world_.diagonal) row.opacity_logit = logit(1e-3);
    }
  }

  point.position = surface_point;  // colour belongs to the surface
  colour_surface(row, part, point, size.log_scales, random);
  return row;
}

SynthGaussians::SurfaceSize SynthGaussians::surface_size(const Part& part, const glm::dvec3& at, double size_score,
                                                         double lies_flat, CounterRandom& random) const {
  const SynthStatistics& statistics = world_.statistics;
  const double usual = portable_log(part.spacing) + statistics.size_mean;
  const double excess = statistics.size_sd * size_score + 0.6 * lies_flat;
  // Training removes what sticks out of an object: two standard deviations end at the rim of patch or leaf.
  double largest = std::min(usual + excess, part.log_reach + 0.2 * random.normal());
  const double to_middle = random.gamma(statistics.large_to_middle.shape, statistics.large_to_middle.scale);
  double middle = std::min(largest, usual + statistics.middle_follows * excess - to_middle);
  const SynthGamma& flatness =
      random.uniform() < statistics.needle_share ? statistics.needle : statistics.middle_to_small;
  const double to_small = to_middle + random.gamma(flatness.shape, flatness.scale);
  SurfaceSize size;
  if (statistics.rims) {
    const ToRim rim = to_rim(part.patch, at);
    const double across = portable_log(0.5 * rim.across + 0.12 * part.spacing);
    if (largest > across) size.along_rim = rim.direction;
    largest = std::min(largest, portable_log(0.5 * rim.along + 0.12 * part.spacing));
    middle = std::min({middle, across, largest});
  }
  const double smallest = std::min(middle, usual + statistics.small_follows * excess - to_small);
  const double floor = portable_log(statistics.smallest_scale);
  size.log_scales = {std::max(largest, floor), std::max(middle, floor), std::max(smallest, floor)};
  return size;
}

void SynthGaussians::colour_surface(PlyRow& row, const Part& part, const SynthPoint& point,
                                    const std::array<double, 3>& log_scales, CounterRandom& random) const {
  // A Gaussian shows the mean colour of what it covers.
  const double footprint = portable_exp(0.5 * (log_scales[0] + log_scales[1]));
  glm::dvec3 colour = patch_colour(part.patch, point, footprint, options_.seed);
  if (part.patch.shape == SynthShape::leaves) colour *= 0.8 + 0.3 * point.noise;
  // A floater has no dark side: it was trained to look like what is behind it.
  const double facing =
      part.patch.shape == SynthShape::haze ? 0.5 : std::max(0.0, glm::dot(point.normal, world_.light));
  colour *= world_.ambient + (1.0 - world_.ambient) * facing;
  colour_row(row, noise_, colour, views_of(point), part.patch.object, random);
}

float SynthGaussians::opacity_logit(double size_score, double lies_flat, double shift, CounterRandom& random) const {
  const SynthStatistics& statistics = world_.statistics;
  const double rho = statistics.opacity_size_correlation;
  // The score keeps mean 0 and variance 1, so the opacity histogram is kept.
  constexpr double kLean = 1.7;
  const double lean = kLean * lies_flat;
  const double share = statistics.aligned_share;
  const double rest = std::max(0.05, 1.0 - rho * rho - kLean * kLean * share * (1.0 - share));
  const double score = rho * size_score + lean + std::sqrt(rest) * random.normal();
  if (random.uniform() < statistics.clear_share) return logit(1e-6);
  return static_cast<float>(static_cast<double>(logit(opacity_at(statistics.opacity, normal_share(score)))) + shift);
}

std::vector<glm::dvec3> SynthGaussians::views_of(const SynthPoint& point) const {
  struct View {
    bool behind;  // Gaussians are translucent: cameras behind a wall also see its colours
    double distance;
    glm::dvec3 direction;
  };
  std::vector<View> views;
  for (const Camera& camera : world_.cameras) {
    const glm::dvec3 from_eye = point.position - camera.position;
    const double distance = glm::length(from_eye);
    if (distance > 0.0) views.push_back({glm::dot(from_eye, point.normal) > 0.0, distance, from_eye / distance});
  }
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return a.behind != b.behind ? b.behind : a.distance < b.distance; });
  std::vector<glm::dvec3> directions;
  for (const View& view : views) directions.push_back(view.direction);
  return directions;
}

PlyRow SynthGaussians::shell_row(std::uint64_t generation) const {
  // Sky: 5 to 30 diagonals away (two thirds within 12), flat towards the scene, large enough to cover it.
  CounterRandom random(options_.seed, kShell, generation);
  const double crowd = std::sqrt(static_cast<double>(shell_) / 300.0);
  glm::dvec3 d = random.direction();
  if (d.y > 0.0 && random.uniform() < 0.9) d.y = -d.y;  // mostly above the horizon; y points down
  const double distance = 5.0 * portable_exp(random.uniform() * random.uniform() * portable_log(6.0));
  const double size =
      std::clamp(0.05 * distance / std::max(1.0, crowd) * portable_exp(0.35 * random.normal()), 0.05, 0.5);
  PlyRow row;
  row.position = glm::vec3(world_.middle + world_.diagonal * distance * d);
  const double large = portable_log(size * world_.diagonal);
  const double middle = large - random.gamma(2.0, 0.15);
  const double small = large + portable_log(0.02) - 0.2 * random.uniform();
  const glm::dvec3 along = any_perpendicular(d, random);
  shape_row(row, along, d, {large, middle, small}, random);
  row.opacity_logit = logit(random.uniform(0.4, 0.95));
  const double high = std::clamp(-d.y, 0.0, 1.0);
  const double cloud = std::max(0.0, value_noise(options_.seed + 9, 3.0 * d));
  const glm::dvec3 blue = glm::dvec3(0.78, 0.84, 0.9) * (1.0 - high) + glm::dvec3(0.3, 0.5, 0.85) * high;
  const glm::dvec3 colour = d.y > 0.0 ? glm::dvec3(0.35, 0.38, 0.3) : blue * (1.0 - cloud) + glm::dvec3(0.95) * cloud;
  colour_row(row, noise_, colour, std::array{d}, 0, random);
  return row;
}

PlyRow SynthGaussians::far_row(std::uint64_t generation) const {
  // Outliers of an uncut training result: huge Gaussians 100 to 800 diagonals away.
  CounterRandom random(options_.seed, kFar, generation);
  const glm::dvec3 d = random.direction();
  const double distance = 100.0 * portable_exp(random.uniform() * portable_log(8.0));
  PlyRow row;
  row.position = glm::vec3(world_.middle + world_.diagonal * distance * d);
  const double large = portable_log(world_.diagonal * random.uniform(0.5, 1.0));
  const double middle = large - random.gamma(2.0, 0.4);
  const double small = large - random.gamma(2.0, 1.5);
  const glm::dvec3 along = any_perpendicular(d, random);
  shape_row(row, along, d, {large, middle, small}, random);
  std::sort(row.log_scale.begin(), row.log_scale.end());  // far out any axis may be the smallest
  row.opacity_logit = logit(random.uniform(0.05, 0.9));
  colour_row(row, noise_, glm::dvec3(0.6, 0.65, 0.7), std::array{d}, 0, random);
  return row;
}

}  // namespace grtx::frontend
