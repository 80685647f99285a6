// SPDX-License-Identifier: Apache-2.0
// Brute force: every Gaussian is considered for every ray. Two cheap tests only skip what provably cannot be hit: a
// bounding ball is tested against the cone around a tile of rays, then against the ray itself.
#include "grtx/frontend/reference/reference.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <numeric>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/frontend/reference/reference_optics.h"
#include "grtx/frontend/reference/reference_sh.h"
#include "grtx/frontend/reference/reference_solid.h"
#include "grtx/frontend/scene/float_rounding.h"

namespace grtx::frontend {
namespace {

constexpr double kMaxAlpha = 0.99;         // 3DGRT, 3DGS
constexpr double kMinAlpha = 1.0 / 255.0;  // 3DGRT, 3DGS
constexpr double kMinResponse = 0.0113;    // 3DGRT: the proxy ends where o * response falls to this
constexpr double kMaxRatio = 0.97;         // 3DGRT: floor of the radius for nearly transparent Gaussians
constexpr unsigned kTile = kReferenceTile;
// Near misses are candidates, too: those beyond the limits of d2 and alpha by up to this share.
constexpr double kNearRadius2 = 1.05;
constexpr double kNearAlpha = 0.95;

struct Ray {
  glm::dvec3 origin;
  glm::dvec3 direction;  ///< about unit length; zero where the projection has no ray
};

struct Gaussian {
  glm::dvec3 mean;
  glm::dmat3 to_local;  ///< world offset to sigma units: S^-1 R^T
  double opacity;
  double kappa;  ///< proxy's inscribed radius, sigma
  double ball;   ///< world radius of a ball around the proxy, rounded up
};

/// Rotation matrix of a quaternion that is normalised again in double.
glm::dmat3 rotation_of(const glm::quat& q) {
  const double norm = std::sqrt(static_cast<double>(q.w) * q.w + static_cast<double>(q.x) * q.x +
                                static_cast<double>(q.y) * q.y + static_cast<double>(q.z) * q.z);
  const double w = q.w / norm;
  const double x = q.x / norm;
  const double y = q.y / norm;
  const double z = q.z / norm;
  glm::dmat3 r;  // columns
  r[0] = {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)};
  r[1] = {2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)};
  r[2] = {2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)};
  return r;
}

std::vector<Gaussian> prepare(const Scene& scene, const ReferenceOptions& options) {
  const double circumradius = reference_circumradius(options.proxy);
  std::vector<Gaussian> gaussians(scene.size());
  for (std::size_t i = 0; i < scene.size(); ++i) {
    Gaussian& g = gaussians[i];
    g.mean = glm::dvec3(scene.mean[i]);
    const glm::dvec3 scale(scene.scale[i]);
    const glm::dmat3 r = rotation_of(scene.rotation[i]);
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 3; ++k) g.to_local[k][axis] = r[axis][k] / scale[axis];  // row `axis` of S^-1 R^T
    }
    g.opacity = scene.opacity[i];
    g.kappa = options.adaptive_radius ? 3.0 * std::pow(std::log(std::min(kMinResponse / g.opacity, kMaxRatio)) / -4.5,
                                                       1.0 / options.kernel_degree)
                                      : 3.0;
    g.ball = g.kappa * circumradius * std::max({scale.x, scale.y, scale.z}) * std::sqrt(kNearRadius2) * (1.0 + 1e-9);
  }
  return gaussians;
}

struct Interval {
  double entry;
  double exit;
};

/// Where the line lo + s ld is inside the proxy. `dt`, `d2`, `a`: peak position, its squared distance, ld . ld.
Interval proxy_interval(const std::vector<ReferenceSlab>& slabs, double kappa, const glm::dvec3& lo,
                        const glm::dvec3& ld, double dt, double d2, double a) {
  if (slabs.empty()) {
    const double half = std::sqrt(std::max(0.0, kappa * kappa - d2) / a);
    return {dt - half, dt + half};
  }
  Interval inside{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const ReferenceSlab& slab : slabs) {
    const double offset = glm::dot(slab.normal, lo);
    const double slope = glm::dot(slab.normal, ld);
    if (slope == 0.0) continue;  // parallel; the ray of a hit runs between the planes, since d2 <= kappa^2
    const double reach = kappa * slab.distance;
    const double toward = std::copysign(reach, slope);
    inside.entry = std::max(inside.entry, (-toward - offset) / slope);
    inside.exit = std::min(inside.exit, (toward - offset) / slope);
  }
  return inside;
}

/// One ray and one Gaussian; alpha = 0 when they are far apart. Form F4: the ray is rebased to the foot of the
/// perpendicular from the centre before the local transform, so that only small numbers are stretched by 1 / scale.
ReferenceCandidate intersect(const Ray& ray, const Gaussian& g, const std::vector<ReferenceSlab>& slabs,
                             const ReferenceOptions& options) {
  const ReferenceCandidate miss;
  const glm::dvec3 m = g.mean - ray.origin;
  const double tc = glm::dot(m, ray.direction) / glm::dot(ray.direction, ray.direction);
  const glm::dvec3 p = ray.direction * tc - m;
  // A point of the line inside the proxy is inside its ball, so the line's nearest point to the centre is, too.
  // 1e-12 |m| exceeds the rounding of p by a factor of 1000.
  const double bound = g.ball + 1e-12 * (std::abs(m.x) + std::abs(m.y) + std::abs(m.z));
  if (!(glm::dot(p, p) <= bound * bound)) return miss;
  const glm::dvec3 lo = g.to_local * p;
  const glm::dvec3 ld = g.to_local * ray.direction;
  const double a = glm::dot(ld, ld);
  const double dt = -glm::dot(lo, ld) / a;
  const glm::dvec3 nearest = lo + dt * ld;
  const double d2 = glm::dot(nearest, nearest);
  if (!(d2 <= kNearRadius2 * g.kappa * g.kappa)) return miss;
  const double alpha =
      std::min(kMaxAlpha, g.opacity * std::exp(-4.5 * std::pow(d2 / 9.0, 0.5 * options.kernel_degree)));
  if (!(alpha >= kNearAlpha * kMinAlpha)) return miss;
  const Interval inside = proxy_interval(slabs, g.kappa, lo, ld, dt, d2, a);
  ReferenceCandidate result;
  result.alpha = alpha;
  result.radius = std::sqrt(d2) / g.kappa;
  result.entry = tc + inside.entry;
  result.exit = tc + inside.exit;
  result.t = options.sort_by_peak ? tc + dt : result.entry;
  bool ahead = result.entry > 0.0 && result.t > 0.0;
  if (!(result.entry > 0.0) && options.count_inside && result.entry < 0.0 && result.exit > 0.0 && tc + dt > 0.0) {
    ahead = true;
    if (!options.sort_by_peak) result.t = 0.0;
  }
  result.hit = ahead && d2 <= g.kappa * g.kappa && alpha >= kMinAlpha;
  return result;
}

/// Finds the Gaussians whose balls a ray of a tile may hit.
class TileCone {
 public:
  /// All rays share one origin.
  explicit TileCone(const std::vector<Ray>& rays) : origin_(rays.front().origin) {
    for (const Ray& ray : rays) axis_ += ray.direction;
    const double length = glm::length(axis_);
    if (!(length > 0.0)) return;
    axis_ /= length;
    for (const Ray& ray : rays) {
      if (ray.direction == glm::dvec3(0.0)) continue;
      if (!(glm::dot(axis_, ray.direction) > 0.0)) return;  // wider than a half space: no test
      sine_ = std::max(sine_, glm::length(glm::cross(axis_, ray.direction)) / glm::length(ray.direction));
    }
    sine_ += 1e-12;  // rounding of the axis and of the sines
    if (sine_ >= 0.99) return;
    cosine_ = std::sqrt(1.0 - sine_ * sine_);
    usable_ = true;
  }

  /// False only when no ray of the tile can meet the ball. Proof: let phi be the angle between the axis and the centre
  /// m, theta the cone's half angle. The cone's distance from m is |m| sin(phi - theta) for 0 <= phi - theta <= 90
  /// degrees and |m| beyond that, so it is at least |m| sin(phi - theta) wherever that is positive. With
  /// |m| sin(phi) = |m x axis| and |m| cos(phi) = m . axis this is |m x axis| cos(theta) - (m . axis) sin(theta). When
  /// it exceeds the radius, no point of any forward half-line in the cone lies in the ball, hence none in the proxy,
  /// and a hit needs such a point: its entry, or (inside = count) its peak, at t > 0.
  bool may_meet(const Gaussian& g) const {
    if (!usable_) return true;
    const glm::dvec3 m = g.mean - origin_;
    const glm::dvec3 across = glm::cross(m, axis_);
    const double distance = std::sqrt(glm::dot(across, across)) * cosine_ - glm::dot(m, axis_) * sine_;
    const double slack = 1e-12 * (std::abs(m.x) + std::abs(m.y) + std::abs(m.z));  // 1000 times the rounding above
    return !(distance > g.ball + slack);
  }

 private:
  glm::dvec3 origin_;
  glm::dvec3 axis_{0.0};
  double sine_ = 0.0;
  double cosine_ = 0.0;
  bool usable_ = false;
};

class Renderer {
 public:
  Renderer(const Scene& scene, const Camera& camera, const ReferenceOptions& options)
      : scene_(scene),
        camera_(camera),
        options_(options),
        slabs_(reference_slabs(options.proxy)),
        gaussians_(prepare(scene, options)),
        optics_(options.objects, scene.offset),
        // The tracer starts from fp32 rays. Rounding them here, too, measures its arithmetic and not its input.
        origin_(round_to_float(camera.position - scene.offset)) {
    if (options.objects.empty()) return;
    everything_.resize(scene.size());
    std::iota(everything_.begin(), everything_.end(), 0u);
  }

  ReferenceResult render() const {
    ReferenceResult result;
    result.image = Image(camera_.width, camera_.height);
    if (options_.keep_sequences) result.sequences.resize(result.image.pixels.size());
    if (options_.keep_candidates) result.candidates.resize(result.image.pixels.size());
    const std::vector<unsigned> columns = chosen(camera_.width), rows = chosen(camera_.height);
    const std::size_t tiles = columns.size() * rows.size();
    if (options_.tiles_a_side != 0) result.rendered = pixels_of(columns, rows);
    Progress progress("reference", std::uint64_t{tiles} * kTile * kTile, "rays", options_.quiet);
    const auto most = static_cast<unsigned>(tbb::info::default_concurrency());
    tbb::task_arena arena(static_cast<int>(options_.threads == 0 ? most : std::min(options_.threads, most)));
    arena.execute([&] {
      tbb::parallel_for(std::size_t{0}, tiles, [&](std::size_t tile) {
        progress.add(render_tile(columns[tile % columns.size()], rows[tile / columns.size()], result));
      });
    });
    return result;
  }

 private:
  /// First pixels of the tiles to render along a side of so many pixels.
  std::vector<unsigned> chosen(unsigned pixels) const {
    const unsigned all = (pixels + kTile - 1) / kTile;
    const unsigned count = options_.tiles_a_side == 0 ? all : std::min(all, options_.tiles_a_side);
    std::vector<unsigned> first;
    for (unsigned i = 0; i < count; ++i) first.push_back((2 * i + 1) * all / (2 * count) * kTile);
    return first;
  }

  std::vector<std::size_t> pixels_of(const std::vector<unsigned>& columns, const std::vector<unsigned>& rows) const {
    std::vector<std::size_t> pixels;
    for (const unsigned row : rows) {
      for (unsigned y = row; y < std::min(row + kTile, camera_.height); ++y) {
        for (const unsigned column : columns) {
          for (unsigned x = column; x < std::min(column + kTile, camera_.width); ++x) {
            pixels.push_back(std::size_t{y} * camera_.width + x);
          }
        }
      }
    }
    return pixels;
  }

  Ray ray(unsigned x, unsigned y) const { return {origin_, round_to_float(camera_.direction(x, y))}; }

  /// Returns the number of pixels rendered. Tiles write disjoint pixels, so the result does not depend on the threads.
  std::uint64_t render_tile(unsigned x0, unsigned y0, ReferenceResult& result) const {
    const unsigned x1 = std::min(x0 + kTile, camera_.width);
    const unsigned y1 = std::min(y0 + kTile, camera_.height);
    std::vector<Ray> rays;
    for (unsigned y = y0; y < y1; ++y) {
      for (unsigned x = x0; x < x1; ++x) rays.push_back(ray(x, y));
    }
    const TileCone cone(rays);
    std::vector<std::uint32_t> candidates;
    for (std::size_t i = 0; i < gaussians_.size(); ++i) {
      if (cone.may_meet(gaussians_[i])) candidates.push_back(static_cast<std::uint32_t>(i));
    }
    std::vector<ReferenceCandidate> near;
    std::vector<ReferenceHit> hits;
    std::size_t next = 0;
    for (unsigned y = y0; y < y1; ++y) {
      for (unsigned x = x0; x < x1; ++x) {
        const Ray& current = rays[next++];
        const std::size_t pixel = std::size_t{y} * camera_.width + x;
        auto* sequence = options_.keep_sequences ? &result.sequences[pixel] : nullptr;
        auto* kept = options_.keep_candidates ? &result.candidates[pixel] : nullptr;
        result.image.pixels[pixel] = glm::vec3(shade(current, candidates, near, hits, sequence, kept));
      }
    }
    return rays.size();
  }

  /// The light along the path of a camera ray: each piece up to the surface that ends it, dimmed by those before it.
  glm::dvec3 shade(const Ray& camera_ray, const std::vector<std::uint32_t>& candidates,
                   std::vector<ReferenceCandidate>& near, std::vector<ReferenceHit>& hits,
                   std::vector<ReferenceHit>* sequence, std::vector<ReferenceCandidate>* kept) const {
    glm::dvec3 rgb(0.0);
    double transmittance = 1.0;
    const std::vector<std::uint32_t>* seen = &candidates;
    for (const ReferencePiece& piece : optics_.path(camera_ray.origin, camera_ray.direction)) {
      if (transmittance < options_.ert) break;
      // The tracer's rays are fp32; rounding them measures its arithmetic and not its input.
      const Ray current{round_to_float(piece.origin), round_to_float(piece.direction)};
      collect(current, *seen, near, static_cast<double>(static_cast<float>(piece.length)));
      hits.clear();
      for (const ReferenceCandidate& c : near) {
        if (c.hit) hits.push_back({c.gaussian, c.t, c.alpha});
      }
      const std::size_t blended = blend(current, hits, rgb, transmittance);
      if (sequence != nullptr) {
        sequence->insert(sequence->end(), hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(blended));
      }
      if (kept != nullptr) kept->insert(kept->end(), near.begin(), near.end());
      seen = &everything_;  // the tile's cone holds for its camera rays only
    }
    return rgb;
  }

  /// All hits and near misses of the ray up to `length`, in the order (t, id).
  void collect(const Ray& current, const std::vector<std::uint32_t>& candidates, std::vector<ReferenceCandidate>& near,
               double length) const {
    near.clear();
    if (current.direction == glm::dvec3(0.0)) return;
    for (const std::uint32_t id : candidates) {
      ReferenceCandidate candidate = intersect(current, gaussians_[id], slabs_, options_);
      if (candidate.alpha <= 0.0 || !(candidate.hit || options_.keep_candidates) || candidate.t > length) continue;
      candidate.gaussian = id;
      near.push_back(candidate);
    }
    std::sort(near.begin(), near.end(), [](const ReferenceCandidate& a, const ReferenceCandidate& b) {
      return a.t != b.t ? a.t < b.t : a.gaussian < b.gaussian;
    });
  }

  /// Front to back until transmittance falls below the threshold; returns how many hits were blended.
  std::size_t blend(const Ray& current, const std::vector<ReferenceHit>& hits, glm::dvec3& rgb,
                    double& transmittance) const {
    const std::size_t stride = std::size_t{3} * scene_.sh_coefficients();
    std::size_t blended = 0;
    while (blended < hits.size() && !(transmittance < options_.ert)) {
      const ReferenceHit& hit = hits[blended++];
      const glm::dvec3 direction =
          options_.sh_from_centre ? glm::normalize(gaussians_[hit.gaussian].mean - current.origin) : current.direction;
      const float* sh = scene_.sh.data() + hit.gaussian * stride;
      rgb += transmittance * hit.alpha * reference_colour(sh, scene_.sh_degree, direction);
      transmittance *= 1.0 - hit.alpha;
    }
    return blended;
  }

  const Scene& scene_;
  const Camera& camera_;
  const ReferenceOptions& options_;
  const std::vector<ReferenceSlab> slabs_;
  const std::vector<Gaussian> gaussians_;
  const ReferenceOptics optics_;
  std::vector<std::uint32_t> everything_;
  const glm::dvec3 origin_;
};

}  // namespace

ReferenceResult render_reference(const Scene& scene, const Camera& camera, const ReferenceOptions& options) {
  if (options.count_inside && options.proxy != ReferenceProxy::sphere) {
    throw Error("inside", "count", "needs the sphere proxy: front faces of triangles are not met from inside");
  }
  if (scene.sh_degree > 4) throw Error(scene.name, "SH degree", "must be 0 to 4");
  return Renderer(scene, camera, options).render();
}

}  // namespace grtx::frontend
