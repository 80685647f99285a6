// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/synth/synth_stress.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "grtx/frontend/numbers/counter_random.h"
#include "grtx/frontend/numbers/portable_math.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using Scales = std::array<double, 3>;

constexpr double kShBand0 = 0.28209479177387814;
constexpr double kInradiusScale = 0.6615845382496075;  // icosahedron (0, 1, phi): vertex scale for inscribed radius 1

/// Rows of one stress scene with their own random numbers. Callers draw one number per statement or inside braces,
/// where the order is fixed: compilers may evaluate arguments in any order.
class Rows {
 public:
  explicit Rows(const SynthOptions& options) : options_(options), random_(options.seed, 0x57e55, 0) {}

  CounterRandom& random() { return random_; }
  std::uint64_t size() const { return rows_.size(); }
  std::vector<PlyRow> take() { return std::move(rows_); }

  /// Ordinary parameters, grey to coloured by `hue` in [0, 1]; identity rotation.
  PlyRow& add(glm::dvec3 position, Scales scales, double opacity, double hue) {
    PlyRow row;
    row.position = glm::vec3(position);
    for (std::size_t i = 0; i < 3; ++i) row.log_scale[i] = static_cast<float>(portable_log(scales[i]));
    row.opacity_logit = static_cast<float>(portable_log(opacity / (1.0 - opacity)));
    for (std::size_t c = 0; c < 3; ++c) {
      const double wave = portable_turn(hue + static_cast<double>(c) / 3.0).cosine;
      row.sh[c] = static_cast<float>(0.4 * wave / kShBand0);
    }
    const unsigned coefficients = (options_.sh_degree + 1) * (options_.sh_degree + 1);
    for (std::size_t k = 3; k < std::size_t{3} * coefficients; ++k)
      row.sh[k] = static_cast<float>(0.1 * random_.normal());
    rows_.push_back(row);
    return rows_.back();
  }
  PlyRow& add_turned(glm::dvec3 position, Scales scales, double opacity, double hue) {
    PlyRow& row = add(position, scales, opacity, hue);
    for (float& part : row.rotation) part = static_cast<float>(random_.normal());
    return row;
  }
  void add_raw(const PlyRow& row) { rows_.push_back(row); }

  double uniform(double low = 0.0, double high = 1.0) { return random_.uniform(low, high); }
  /// A point in a ball, denser towards the middle.
  glm::dvec3 in_ball(double radius) {
    const glm::dvec3 d = random_.direction();
    return radius * random_.uniform() * d;
  }
  /// log-uniform between two positive numbers.
  double between(double low, double high) { return low * portable_exp(random_.uniform() * portable_log(high / low)); }

 private:
  const SynthOptions& options_;
  CounterRandom random_;
  std::vector<PlyRow> rows_;
};

std::vector<Camera> front_and_side() {
  return {synth_camera("front", {0, 0, -4}, {0, 0, 0}, 50), synth_camera("side", {3.1, -1.7, 1.9}, {0, 0, 0}, 50)};
}

StressScene one(const SynthOptions& options) {
  Rows rows(options);
  rows.add({0, 0, 0}, {0.5, 0.3, 0.2}, 0.8, 0.1);
  return {rows.take(), front_and_side()};
}

StressScene empty(const SynthOptions&) { return {{}, front_and_side()}; }

/// All Gaussians behind the cameras or outside their pictures.
StressScene nohit(const SynthOptions& options) {
  Rows rows(options);
  while (rows.size() < options.count) {
    const glm::dvec3 at{rows.uniform(-3, 3), rows.uniform(-3, 3), rows.uniform(4, 9)};
    const double hue = rows.uniform();
    rows.add_turned(at, {0.1, 0.05, 0.02}, 0.9, hue);
  }
  return {rows.take(),
          {synth_camera("away", {0, 0, 0}, {0, 0, -1}, 90), synth_camera("below", {0, 6, 6}, {0, 12, 6}, 80)}};
}

/// Copies of one Gaussian in stacks of 1 to 40 behind each other, in columns that start one copy later each: whatever k
/// is, some ray has a tie across each multiple of k. Copies differ in colour only, so a lost or swapped one shows.
StressScene ties(const SynthOptions& options) {
  Rows rows(options);
  constexpr std::uint64_t kColumns = 64;  // an 8 x 8 grid
  for (std::uint64_t stack = 0; rows.size() < options.count; ++stack) {
    for (std::uint64_t column = 0; column < kColumns && rows.size() < options.count; ++column) {
      const double x = 0.35 * (static_cast<double>(column % 8) - 3.5);
      const double y = 0.35 * (static_cast<double>(column / 8) - 3.5);
      const double z = 0.25 * static_cast<double>(stack);
      const std::uint64_t copies = 1 + (stack == 0 ? column : 7 * stack + 11 * column) % 40;
      for (std::uint64_t i = 0; i < copies && rows.size() < options.count; ++i) {
        rows.add({x, y, z}, {0.05, 0.05, 0.05}, 0.04, static_cast<double>(i) / static_cast<double>(copies));
      }
    }
  }
  return {rows.take(), front_and_side()};
}

StressScene needles(const SynthOptions& options) {
  Rows rows(options);
  while (rows.size() < options.count) {
    const double large = rows.between(0.01, 1.0);
    const double ratio = rows.between(1.0, 1e6);
    const bool flake = rows.uniform() < 0.5;
    const double middle = flake ? large : large / rows.between(1.0, ratio);
    const glm::dvec3 at = rows.in_ball(1.2);
    const double opacity = rows.uniform(0.1, 0.99);
    const double hue = rows.uniform();
    rows.add_turned(at, {large, large / ratio, middle}, opacity, hue);
  }
  return {rows.take(), front_and_side()};
}

StressScene tiny(const SynthOptions& options) {
  Rows rows(options);
  while (rows.size() < options.count) {
    // A third of the extent shrinks with the scales, around the point that the close camera looks at.
    const Scales scales{rows.between(1e-10, 1e-2), rows.between(1e-10, 1e-2), rows.between(1e-10, 1e-2)};
    const bool close = rows.uniform() < 0.3;
    const glm::dvec3 at = rows.in_ball(close ? 30.0 * scales[0] : 1.0);
    const double opacity = rows.uniform(0.3, 0.99);
    const double hue = rows.uniform();
    rows.add_turned(at, scales, opacity, hue);
  }
  std::vector<Camera> cameras = front_and_side();
  cameras.push_back(synth_camera("close", {0, 0, -0.002}, {0, 0, 0}, 50));
  return {rows.take(), cameras};
}

/// One ordinary row for each pair (field, special value), then ordinary rows up to the count.
StressScene params(const SynthOptions& options) {
  Rows rows(options);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float specials[] = {0.0f,
                            -0.0f,
                            1e-45f,
                            1e-38f,
                            -1e-45f,
                            3.4e38f,
                            -3.4e38f,
                            1e30f,
                            1e3f,
                            -1e3f,
                            kInfinity,
                            -kInfinity,
                            std::numeric_limits<float>::quiet_NaN()};
  Rows ordinary(options);
  const auto next = [&] {
    const glm::dvec3 at = ordinary.in_ball(1.0);
    const double hue = ordinary.uniform();
    return ordinary.add_turned(at, {0.1, 0.05, 0.03}, 0.7, hue);
  };
  const std::size_t coefficients = std::size_t{3} * (options.sh_degree + 1) * (options.sh_degree + 1);
  for (const float special : specials) {
    const auto add_special = [&](auto&& field) {
      PlyRow row = next();
      field(row) = special;
      rows.add_raw(row);
    };
    for (int i = 0; i < 3; ++i) add_special([i](PlyRow& row) -> float& { return row.position[i]; });
    for (std::size_t i = 0; i < 3; ++i) add_special([i](PlyRow& row) -> float& { return row.log_scale[i]; });
    for (std::size_t i = 0; i < 4; ++i) add_special([i](PlyRow& row) -> float& { return row.rotation[i]; });
    add_special([](PlyRow& row) -> float& { return row.opacity_logit; });
    for (std::size_t i = 0; i < coefficients; ++i) add_special([i](PlyRow& row) -> float& { return row.sh[i]; });
  }
  // Scales up to the largest float, in all axes and in one. The centres are out of view, else they would hide the rest.
  for (const float log_scale : {40.0f, 45.0f, 60.0f, 80.0f, 85.0f, 86.0f, 88.0f, 89.0f, -40.0f, -80.0f, -104.0f}) {
    for (std::size_t axes = 1; axes <= 3; axes += 2) {
      PlyRow row = next();
      for (std::size_t i = 0; i < axes; ++i) row.log_scale[i] = log_scale;
      row.rotation = {1.0f, 0.0f, 0.0f, 0.0f};
      row.position = {0.0f, 0.0f, axes == 1 ? 1.5f : 3.0f};
      row.opacity_logit = -3.0f;
      rows.add_raw(row);
    }
  }
  PlyRow zero;  // a row of zeros only
  zero.rotation = {0.0f, 0.0f, 0.0f, 0.0f};
  rows.add_raw(zero);
  while (rows.size() < options.count) rows.add_raw(next());
  return {rows.take(), front_and_side()};
}

/// Position i on a square grid in the plane z = 0 that both usual cameras see, then on grids in planes behind it.
glm::dvec3 grid_place(std::uint64_t i) {
  constexpr std::uint64_t kSide = 12;
  return {0.25 * (static_cast<double>(i % kSide) - 5.5), 0.25 * (static_cast<double>(i / kSide % kSide) - 5.5),
          0.3 * static_cast<double>(i / (kSide * kSide))};
}

/// Quaternions of all lengths: the same two Gaussians again and again, rotated by the same two quaternions.
StressScene quaternions(const SynthOptions& options) {
  Rows rows(options);
  constexpr std::array<float, 4> kTurns[] = {{0.5f, -0.5f, 0.5f, 0.5f}, {0.8f, 0.2f, -0.1f, 0.55f}};
  // Powers of two, so that the scaled quaternion differs from the unit one by its exponent alone.
  constexpr int kExponents[] = {0, 1, -1, 10, -10, 30, -30, 60, -39, 100, -100, 126, -126, -140};
  constexpr std::uint64_t kLengths = std::size(kExponents) + 1;
  for (std::uint64_t i = 0; rows.size() < options.count; ++i) {
    const std::uint64_t length = i % kLengths;
    PlyRow& row = rows.add(grid_place(i), {0.1, 0.03, 0.01}, 0.6, 0.07 * static_cast<double>(length));
    row.rotation = kTurns[i / kLengths % 2];
    for (float& part : row.rotation) {
      part = length == std::size(kExponents) ? 0.0f : std::ldexp(part, kExponents[length]);
    }
  }
  return {rows.take(), front_and_side()};
}

/// Opacities at and beyond every limit: logits +-infinity, NaN, saturated, and on both sides of 1/255 (least alpha),
/// 0.0113 / 0.97 (floor of the kernel radius) and 0.99 (largest alpha).
StressScene opacity(const SynthOptions& options) {
  Rows rows(options);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<float> logits{-kInfinity, kInfinity, std::numeric_limits<float>::quiet_NaN(),
                            -1000.0f,   -104.0f,   -88.0f,
                            -17.0f,     17.0f,     88.0f,
                            1000.0f,    3.4e38f,   -3.4e38f,
                            0.0f,       -0.0f,     1e-45f};
  for (const double limit : {1.0 / 255.0, 0.0113 / 0.97, 0.0113, 0.99}) {
    const auto logit = static_cast<float>(portable_log(limit / (1.0 - limit)));
    for (const float factor : {0.999f, 0.999999f, 1.0f, 1.000001f, 1.001f}) logits.push_back(logit * factor);
  }
  for (std::uint64_t i = 0; rows.size() < options.count; ++i) {
    rows.add(grid_place(i), {0.1, 0.06, 0.04}, 0.5, 0.03 * static_cast<double>(i % logits.size())).opacity_logit =
        logits[i % logits.size()];
  }
  return {rows.take(), front_and_side()};
}

/// One Gaussian, `count` times: equal boxes for the builder, equal keys for every hit of a ray. Only ids order them.
StressScene copies(const SynthOptions& options) {
  Rows rows(options);
  while (rows.size() < options.count) {
    PlyRow& row = rows.add({0.1, -0.2, 0.3}, {0.4, 0.3, 0.2}, 0.06, 0.37 * static_cast<double>(rows.size()));
    row.rotation = {0.9f, 0.1f, -0.3f, 0.2f};
  }
  return {rows.take(), front_and_side()};
}

/// Four equal clusters at 1e3, 1e4, 1e5 and 1e6 from the origin, with a camera before each.
StressScene far(const SynthOptions& options) {
  Rows rows(options);
  const glm::dvec3 middles[] = {{1e3, 0, 0}, {0, 1e4, 0}, {0, 0, -1e5}, {-6e5, 6e5, 529150}};
  while (rows.size() < options.count) {
    const glm::dvec3 at = middles[rows.size() % 4] + rows.in_ball(1.0);
    const double hue = rows.uniform();
    rows.add_turned(at, {0.15, 0.1, 0.03}, 0.7, hue);
  }
  std::vector<Camera> cameras;
  for (const glm::dvec3& middle : middles)
    cameras.push_back(synth_camera("far", middle - glm::dvec3(0, 0, 4), middle, 50));
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].name += std::to_string(i + 3);
  return {rows.take(), cameras};
}

/// Axis-aligned Gaussians on a half-unit grid and cameras whose rays run along axes and through grid planes: with odd
/// resolution the middle rays meet edges and vertices of the polyhedra exactly, and direction components are exactly 0.
StressScene axis(const SynthOptions& options) {
  Rows rows(options);
  const double kappa = std::sqrt(-2.0 * portable_log(0.0113 / 0.5));
  // The first ones have a vertex (0, +-1, phi) or an edge's end on the z axis: the ray x = y = 0 passes through it.
  for (int i = 0; i < 8 && rows.size() < options.count; ++i) {
    const double scale = 0.05 * (i + 1);
    const double offset = (i % 2 == 0 ? 1.0 : -1.0) * scale * kappa * kInradiusScale;
    rows.add({0, i < 4 ? offset : 0.0, -2.0 + 0.5 * i}, {scale, scale, scale}, 0.5, 0.12 * i);
  }
  for (std::uint64_t i = 0; rows.size() < options.count; ++i) {
    const std::uint64_t cell = i % 1331;  // 11^3, then again with other shapes
    const glm::dvec3 at(static_cast<double>(cell % 11) - 5.0, static_cast<double>(cell / 11 % 11) - 5.0,
                        static_cast<double>(cell / 121) - 5.0);
    Scales scales{0.03125, 0.03125, 0.03125};
    scales[(cell + i / 1331) % 3] = 0.125;
    PlyRow& row = rows.add(0.5 * at, scales, 0.3, static_cast<double>(cell % 17) / 17.0);
    const std::size_t half_turn = (cell + 2 * (i / 1331)) % 4;  // identity or 180 degrees about an axis, exactly
    row.rotation = {0.0f, 0.0f, 0.0f, 0.0f};
    row.rotation[half_turn] = 1.0f;
  }
  std::vector<Camera> cameras;
  const glm::dvec3 ends[] = {{0, 0, -6}, {-6, 0, 0}, {0, -6, 0}, {0, 0, 6}, {0.5, 0.5, -6}};
  for (const glm::dvec3& end : ends) {
    Camera camera = synth_camera("axis" + std::to_string(cameras.size()), end,
                                 {end.x == 0.5 ? 0.5 : 0, end.y == 0.5 ? 0.5 : 0, 0}, 60);
    camera.width = camera.height = 129;
    camera.cx = camera.cy = 64.5;
    camera.fx = camera.fy = 128.0;
    cameras.push_back(camera);
  }
  return {rows.take(), cameras};
}

/// The camera is inside half of all proxies.
StressScene inside(const SynthOptions& options) {
  Rows rows(options);
  while (rows.size() < options.count) {
    const bool around = rows.size() % 2 == 0;
    const double scale = around ? rows.between(0.3, 3.0) : rows.between(0.02, 0.1);
    const double distance = around ? rows.uniform(0.0, 0.5) : rows.uniform(1.0, 3.0);
    const double middle = scale * rows.uniform(0.5, 1.0);
    const glm::dvec3 at = distance * rows.random().direction();
    const double opacity = rows.uniform(0.05, 0.9);
    const double hue = rows.uniform();
    rows.add_turned(at, {scale, middle, scale}, opacity, hue);
  }
  return {rows.take(),
          {synth_camera("inside", {0, 0, 0}, {0, 0, 1}, 80), synth_camera("edge", {0.4, 0.1, 0}, {-1, 0, 0.2}, 80)}};
}

StressScene onepoint(const SynthOptions& options) {
  Rows rows(options);
  while (rows.size() < options.count) {
    const Scales scales{rows.between(0.05, 0.5), rows.between(0.05, 0.5), rows.between(0.05, 0.5)};
    const double opacity = rows.uniform(0.01, 0.2);
    const double hue = rows.uniform();
    rows.add_turned({0.25, -0.5, 0.125}, scales, opacity, hue);
  }
  return {rows.take(), front_and_side()};
}

struct Named {
  const char* name;
  StressScene (*make)(const SynthOptions&);
};

constexpr Named kScenes[] = {{"ties", ties},       {"copies", copies},     {"needles", needles},
                             {"tiny", tiny},       {"params", params},     {"quaternions", quaternions},
                             {"opacity", opacity}, {"far", far},           {"axis", axis},
                             {"inside", inside},   {"onepoint", onepoint}, {"empty", empty},
                             {"one", one},         {"nohit", nohit}};

}  // namespace

std::vector<std::string> stress_names() {
  std::vector<std::string> names;
  for (const Named& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

StressScene stress_scene(const std::string& name, const SynthOptions& options) {
  const auto* found =
      std::find_if(std::begin(kScenes), std::end(kScenes), [&](const Named& s) { return s.name == name; });
  assert(found != std::end(kScenes));
  return found->make(options);
}

}  // namespace grtx::frontend
