// SPDX-License-Identifier: Apache-2.0
// Prints the tables of docs/model/numerics.md: fp32 against fp64 for six ray-Gaussian formulas and for the
// tracer's own hit function, on random rays near the Gaussians of generated scenes and of those named on the command
// line:
//   ray_gaussian_formulas [--rays N] [SCENE CAMERAS.json]...
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/formulas.h"
#include "grtx/base/error.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/numbers/counter_random.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"

namespace grtx::bench {
namespace {

using namespace frontend;  // a program, not a header

constexpr std::size_t kForms = 7;
constexpr std::array<const char*, kForms> kNames{"F1", "F2", "F3", "F4", "F5", "F6", "tracer"};
constexpr double kAlphaLimit = 1.0 / 255.0;

struct Errors {
  std::vector<double> d2, t, alpha;  ///< absolute; t relative to the distance of the mean
  std::size_t missed = 0;            ///< accepted in fp64, not in fp32
  std::size_t added = 0;             ///< the other way round
};

struct Row {
  std::string scene;
  std::size_t rays = 0;
  std::array<Errors, kForms> errors;
};

double alpha_of(double opacity, double d2) { return std::min(0.99, opacity * std::exp(-0.5 * d2)); }
/// NaN and infinite d2 are misses.
bool accepts(double opacity, double kappa, double d2) {
  return d2 <= kappa * kappa && alpha_of(opacity, d2) >= kAlphaLimit;
}

Pair pair_of(const Scene& scene, std::uint32_t g, const glm::vec3& origin, const glm::vec3& direction) {
  Pair pair;
  pair.origin = origin;
  pair.direction = direction;
  pair.mean = scene.mean[g];
  pair.opacity = static_cast<double>(scene.opacity[g]);
  pair.kappa = kernel_radius(pair.opacity, true);
  const glm::dmat3 r = glm::mat3_cast(glm::normalize(glm::dquat(scene.rotation[g])));
  const glm::dvec3 scale(scene.scale[g]);
  glm::dmat3 m, q(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) {
      m[k][axis] = r[axis][k] / scale[axis];
      for (int j = 0; j < 3; ++j) q[k][j] += r[axis][k] * r[axis][j] / (scale[axis] * scale[axis]);
    }
  }
  pair.to_sigma = glm::mat3(m);
  pair.precision = glm::mat3(q);
  pair.translation = glm::vec3(-(m * glm::dvec3(pair.mean)));
  return pair;
}

/// From a camera towards a random point of a random Gaussian's ellipsoid, a tenth beyond its proxy's radius at most.
Row measure(const std::string& name, const Scene& scene, const std::vector<Camera>& cameras, std::size_t rays) {
  Row row;
  row.scene = name;
  const PreparedGaussians gaussians(scene, true);
  for (std::size_t i = 0; i < rays && scene.size() > 0; ++i) {
    CounterRandom random(1, 0xbe9c4, i);
    const auto g = static_cast<std::uint32_t>(random.uniform() * static_cast<double>(scene.size()));
    const Camera& camera = cameras[static_cast<std::size_t>(random.uniform() * static_cast<double>(cameras.size()))];
    const glm::vec3 origin(camera.position - scene.offset);
    const double kappa = kernel_radius(static_cast<double>(scene.opacity[g]), true);
    const double radius = 1.1 * kappa * std::cbrt(random.uniform());
    const glm::dvec3 local = glm::dvec3(scene.scale[g]) * (radius * random.direction());
    const glm::dvec3 target = glm::dvec3(scene.mean[g]) + glm::dquat(scene.rotation[g]) * local;
    const glm::dvec3 toward = target - glm::dvec3(origin);
    const double distance = glm::length(toward);
    if (!(distance > 0.0 && distance < 1e18)) continue;
    const Pair pair = pair_of(scene, g, origin, glm::vec3(toward / distance));
    const Meeting exact = f4<double>(pair);
    const double length = glm::length(glm::dvec3(pair.mean) - glm::dvec3(origin));
    ++row.rays;

    const UnitRay unit = to_unit_ray(TraceRay(origin, pair.direction), gaussians.record(g));
    const double kappa2 = static_cast<double>(gaussians.record(g).kappa2);
    const float half = std::sqrt((1.0f - unit.d2) / unit.length2);
    const Meeting traced{static_cast<double>(unit.d2) * kappa2, static_cast<double>(unit.t_peak),
                         static_cast<double>(unit.t_peak - half)};
    const std::array<Meeting, kForms> found{f1<float>(pair), f2<float>(pair), f3<float>(pair), f4<float>(pair),
                                            f5<float>(pair), f6<float>(pair), traced};
    const bool hit = accepts(pair.opacity, kappa, exact.d2);
    for (std::size_t f = 0; f < kForms; ++f) {
      Errors& e = row.errors[f];
      const bool also = accepts(pair.opacity, kappa, found[f].d2);
      e.missed += hit && !also;
      e.added += !hit && also;
      if (!hit) continue;
      const auto clean = [](double error) { return std::isfinite(error) ? std::abs(error) : 1e300; };
      e.d2.push_back(clean(found[f].d2 - exact.d2));
      e.alpha.push_back(clean(alpha_of(pair.opacity, found[f].d2) - alpha_of(pair.opacity, exact.d2)));
      // Near the rim of the ellipsoid the entry is ill-conditioned for everybody.
      if (exact.d2 < 0.98 * kappa * kappa) e.t.push_back(clean((found[f].entry - exact.entry) / length));
    }
  }
  return row;
}

std::string figure(double error) { return error >= 1e300 ? "inf" : fmt::format("{:.1e}", error); }

std::string summary(std::vector<double> errors) {
  if (errors.empty()) return "-";
  std::sort(errors.begin(), errors.end());
  const auto rank = static_cast<std::size_t>(0.999 * static_cast<double>(errors.size() - 1));
  return figure(errors[rank]) + " / " + figure(errors.back());
}

template <typename Cell>
void print_table(const char* title, const std::vector<Row>& rows, Cell&& cell) {
  fmt::print("\n{}\n\n| scene | rays |", title);
  for (const char* name : kNames) fmt::print(" {} |", name);
  fmt::print("\n|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    fmt::print("| {} | {} |", row.scene, row.rays);
    for (const Errors& e : row.errors) fmt::print(" {} |", cell(e));
    fmt::print("\n");
  }
}

int run(const std::vector<std::string>& arguments) {
  std::size_t rays = 100000;
  std::vector<Row> rows;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--rays" && i + 1 < arguments.size()) {
      rays = std::strtoull(arguments[++i].c_str(), nullptr, 10);
    } else {
      files.push_back(arguments[i]);
    }
  }
  if (files.size() % 2 != 0) throw Error("command line", "", "each scene needs its cameras: SCENE CAMERAS.json");
  for (std::size_t i = 0; i < files.size(); i += 2) {
    const std::string name = std::filesystem::path(files[i]).stem().string();
    rows.push_back(measure(name, load_scene(files[i]), load_cameras(files[i + 1]), rays));
  }
  const std::string stem =
      (std::filesystem::temp_directory_path() / ("grtx_ray_gaussian_formulas_" + std::to_string(::getpid()))).string();
  for (const std::string& preset : synth_presets()) {
    synthesise({preset, 20000, 1, 0}, stem + ".ply");
    const Scene scene = load_scene(stem + ".ply");
    if (scene.size() > 0) rows.push_back(measure(preset, scene, load_cameras(stem + ".cameras.json"), rays));
  }
  std::filesystem::remove(stem + ".ply");
  std::filesystem::remove(stem + ".cameras.json");
  print_table("Error of d2 in sigma^2, 99.9th percentile / largest:", rows,
              [](const Errors& e) { return summary(e.d2); });
  print_table("Error of alpha, 99.9th percentile / largest:", rows, [](const Errors& e) { return summary(e.alpha); });
  print_table("Error of the entry t over the distance of the mean, 99.9th percentile / largest:", rows,
              [](const Errors& e) { return summary(e.t); });
  print_table("Wrong decisions, missed / added:", rows,
              [](const Errors& e) { return fmt::format("{} / {}", e.missed, e.added); });
  return 0;
}

}  // namespace
}  // namespace grtx::bench

int main(int argc, char** argv) {
  try {
    return grtx::bench::run(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const grtx::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
