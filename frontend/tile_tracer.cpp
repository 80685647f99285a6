#include "frontend/tile_tracer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/progress.h"
#include "frontend/gaussian_math.h"
#include "frontend/response_precision.h"

namespace grtx::frontend {
namespace {

TileTests tests_of(const TracerOptions& options) {
  TileTests tests = tile_tests(options.simd);
  // Rounding to 16 bits may lift an alpha to the threshold: one by one.
  if (options.response_precision != ResponsePrecision::fp32) tests.hit = tile_tests(SimdPath::portable).hit;
  return tests;
}

void prefetch_lines(const void* first, unsigned lines) {
  for (unsigned i = 0; i < lines; ++i) __builtin_prefetch(static_cast<const char*>(first) + std::size_t{64} * i);
}

/// By (t, id). A bucket holds few hits of a ray.
void sort_hits(TileHit* hits, unsigned count) {
  if (count > 24) {
    std::sort(hits, hits + count, [](const TileHit& a, const TileHit& b) { return a.order < b.order; });
    return;
  }
  for (unsigned i = 1; i < count; ++i) {
    const TileHit hit = hits[i];
    unsigned at = i;
    for (; at > 0 && hit.order < hits[at - 1].order; --at) hits[at] = hits[at - 1];
    hits[at] = hit;
  }
}

}  // namespace

TileTracer::TileTracer(const Scene& scene, const PreparedGaussians& gaussians, const TileStructure& structure,
                       const TracerOptions& options)
    : scene_(scene),
      gaussians_(gaussians),
      structure_(structure),
      options_(options),
      tests_(tests_of(options)),
      test_faces_(face_test(options.simd)),
      sphere_(structure.proxy().is_sphere() && options.sort_key == SortKey::entry),
      sh_lines_((12 * structure.coefficients() + 63) / 64) {}

/// Depths grow by a constant factor from bucket to bucket: bits of non-negative floats count like their logarithms.
void TileTracer::begin(const TileRays& tile) {
  float near_t = std::numeric_limits<float>::infinity(), far_t = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    far_t += std::max(std::fabs(structure_.bounds().lower[axis] - tile.origin[axis]),
                      std::fabs(structure_.bounds().upper[axis] - tile.origin[axis]));
  }
  near_t = far_t;
  for (int axis = 0; axis < 3; ++axis) {
    const float gap = std::max(structure_.bounds().lower[axis] - tile.origin[axis],
                               tile.origin[axis] - structure_.bounds().upper[axis]);
    near_t = axis == 0 ? gap : std::max(near_t, gap);
  }
  constexpr float kFirst = 1.0f / (1 << 16);
  const std::uint32_t last = std::bit_cast<std::uint32_t>(far_t);
  first_depth_ = std::bit_cast<std::uint32_t>(std::max(near_t, far_t * kFirst));
  depth_shift_ = 16;
  while (last > first_depth_ && (last - first_depth_) >> depth_shift_ >= kBuckets - 2) ++depth_shift_;
  buckets_.fill({});
  occupied_.fill(0);
  children_.clear();
  queued_hits_.clear();
  alive_ = tile.live;
  lights_.fill({});
  if (options_.sh_direction == ShDirection::ray) {
    for (std::uint64_t rest = alive_; rest != 0; rest &= rest - 1) {
      const auto r = static_cast<unsigned>(std::countr_zero(rest));
      basis_[r] = sh_basis(tile.rays[r].direction, scene_.sh_degree);
    }
  }
}

unsigned TileTracer::bucket_of(float t) const {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(t);
  if (bits < first_depth_) return 0;
  return std::min((bits - first_depth_) >> depth_shift_, kBuckets - 2) + 1;
}

unsigned TileTracer::next_bucket(unsigned from) const {
  for (unsigned word = from / 64; word < occupied_.size(); ++word) {
    const std::uint64_t left = word == from / 64 ? occupied_[word] >> (from % 64) << (from % 64) : occupied_[word];
    if (left != 0) return 64 * word + static_cast<unsigned>(std::countr_zero(left));
  }
  return kBuckets;
}

const std::array<TileLight, kTileRays>& TileTracer::trace(const TileRays& tile) {
  begin(tile);
  ++counters_.tiles;
  counters_.rays += static_cast<std::uint64_t>(std::popcount(tile.live));
  if (alive_ == 0) return lights_;
  children_.push_back({0, 0, kNone});
  buckets_[0].nodes = 0;
  mark(0);
  for (unsigned b = next_bucket(0); b < kBuckets && alive_ != 0; b = next_bucket(b + 1)) {
    walk_nodes(tile, b);
    test_gaussians(tile, b);
    blend_bucket(tile, b);
  }
  return lights_;
}

void TileTracer::walk_nodes(const TileRays& tile, unsigned bucket) {
  work_.clear();
  for (std::uint32_t i = buckets_[bucket].nodes; i != kNone; i = children_[i].next) {
    work_.push_back(children_[i].child);
    prefetch_lines(&structure_.node(children_[i].child), 4);
  }
  counters_.nodes += work_.size();
  for (std::size_t at = 0; at < work_.size(); ++at) {
    const TileNode& node = structure_.node(work_[at]);
    for (unsigned rest = tests_.node(node, tile, node_hits_); rest != 0; rest &= rest - 1) {
      const auto slot = static_cast<unsigned>(std::countr_zero(rest));
      const std::uint32_t child = node.child[slot];
      const unsigned b = std::max(bucket, bucket_of(node_hits_.enter[slot]));
      if ((child & kTileLeaf) != 0) {
        __builtin_prefetch(&structure_.gaussian(child & ~kTileLeaf), 0, 2);
        children_.push_back({child & ~kTileLeaf, node_hits_.vectors[slot], buckets_[b].gaussians});
        buckets_[b].gaussians = static_cast<std::uint32_t>(children_.size() - 1);
      } else if (b == bucket) {
        prefetch_lines(&structure_.node(child), 4);
        work_.push_back(child);
        ++counters_.nodes;
        continue;
      } else {
        prefetch_lines(&structure_.node(child), 4);
        children_.push_back({child, 0, buckets_[b].nodes});
        buckets_[b].nodes = static_cast<std::uint32_t>(children_.size() - 1);
      }
      mark(b);
    }
  }
}

void TileTracer::test_gaussians(const TileRays& tile, unsigned bucket) {
  candidates_.clear();
  for (std::uint32_t i = buckets_[bucket].gaussians; i != kNone; i = children_[i].next) {
    candidates_.push_back({children_[i].vectors, children_[i].child});
    __builtin_prefetch(&structure_.gaussian(children_[i].child));
  }
  counters_.gaussians += candidates_.size();
  std::size_t left = 0;
  for (const Candidate& queued : candidates_) {
    const std::uint64_t rays =
        tests_.outline(structure_.gaussian(queued.gaussian), tile, static_cast<unsigned>(queued.rays)) & alive_;
    if (rays == 0) continue;
    __builtin_prefetch(&structure_.box(queued.gaussian));
    candidates_[left++] = {rays, queued.gaussian};
  }
  candidates_.resize(left);
  for (const Candidate& candidate : candidates_) test_hits(tile, candidate, bucket);
}

void TileTracer::test_hits(const TileRays& tile, const Candidate& candidate, unsigned bucket) {
  const TileGaussian& g = structure_.gaussian(candidate.gaussian);
  const Box& box = structure_.box(candidate.gaussian).box;
  prefetch_lines(structure_.sh(candidate.gaussian), sh_lines_);
  counters_.candidates += static_cast<std::uint64_t>(std::popcount(candidate.rays));
  TileHits hits;
  for (unsigned vector = 0; vector < kTileVectors; ++vector) {
    const auto wanted = static_cast<unsigned>(candidate.rays >> (vector * kTileLanes)) & 0xFFu;
    if (wanted == 0) continue;
    ++counters_.hit_tests;
    tests_.hit(g, box, tile, vector, wanted, sphere_, hits);
    for (unsigned rest = hits.hit; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<unsigned>(std::countr_zero(rest));
      add_hit(vector * kTileLanes + lane, hits.t[lane], hits.alpha[lane], g.id, candidate.gaussian, bucket);
    }
    for (unsigned rest = hits.unsure; rest != 0; rest &= rest - 1) {
      decide(tile, candidate.gaussian, vector * kTileLanes + static_cast<unsigned>(std::countr_zero(rest)), bucket);
    }
  }
}

void TileTracer::decide(const TileRays& tile, std::uint32_t gaussian, unsigned ray, unsigned bucket) {
  const TileGaussian& g = structure_.gaussian(gaussian);
  const UnitRay unit = to_unit_ray(tile.rays[ray], gaussians_.record(g.id));
  if (!(unit.d2 <= 1.0f)) return;
  const Hit hit = canonical_hit(tile.rays[ray], unit, gaussians_, g.id, structure_.proxy(), options_.sort_key,
                                options_.inside, test_faces_);
  if (hit.kind != HitKind::hit) return;
  const float alpha = options_.response_precision == ResponsePrecision::fp32
                          ? hit_alpha(g.opacity, g.kappa2, hit.d2)
                          : hit_alpha_16(g.opacity, g.kappa2, hit.d2, options_.response_precision);
  if (alpha > 0.0f) add_hit(ray, hit.t, alpha, g.id, gaussian, bucket);
}

void TileTracer::add_hit(unsigned ray, float t, float alpha, std::uint32_t id, std::uint32_t gaussian,
                         unsigned bucket) {
  ++counters_.hits;
  const unsigned b = std::max(bucket, bucket_of(t));
  const std::uint64_t order = static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(t)) << 32 | id;
  queued_hits_.push_back({{order, alpha, gaussian}, ray, buckets_[b].hits});
  buckets_[b].hits = static_cast<std::uint32_t>(queued_hits_.size() - 1);
  mark(b);
}

void TileTracer::blend_bucket(const TileRays& tile, unsigned bucket) {
  if (buckets_[bucket].hits == kNone) return;
  // Hits of one ray next to each other: count, then place.
  std::array<std::uint32_t, kTileRays> end{};
  std::uint64_t rays = 0;
  std::uint32_t total = 0;
  for (std::uint32_t i = buckets_[bucket].hits; i != kNone; i = queued_hits_[i].next) {
    const std::uint32_t ray = queued_hits_[i].ray;
    ++end[ray];
    rays |= std::uint64_t{1} << ray;
    ++total;
  }
  rays &= alive_;
  std::uint32_t sum = 0;
  for (std::uint32_t& e : end) {
    const std::uint32_t count = e;
    e = sum;
    sum += count;
  }
  if (sorted_.size() < total) sorted_.resize(total);
  for (std::uint32_t i = buckets_[bucket].hits; i != kNone; i = queued_hits_[i].next) {
    sorted_[end[queued_hits_[i].ray]++] = queued_hits_[i].hit;
  }
  for (std::uint64_t rest = rays; rest != 0; rest &= rest - 1) {
    const auto ray = static_cast<unsigned>(std::countr_zero(rest));
    const std::uint32_t first = ray == 0 ? 0 : end[ray - 1];
    blend_ray(tile, ray, &sorted_[first], end[ray] - first);
  }
}

void TileTracer::blend_ray(const TileRays& tile, unsigned ray, TileHit* hits, unsigned count) {
  sort_hits(hits, count);
  TileLight& light = lights_[ray];
  unsigned done = 0;
  if (options_.sh_direction == ShDirection::ray) {
    done = tests_.blend(hits, count, basis_[ray].data(), structure_, options_.ert, light);
  } else {
    while (done < count) {
      const glm::vec3 to_centre = gaussians_.record(static_cast<std::uint32_t>(hits[done].order)).mean - tile.origin;
      basis_[ray] = sh_basis(to_centre / std::sqrt(glm::dot(to_centre, to_centre)), scene_.sh_degree);
      tests_.blend(hits + done, 1, basis_[ray].data(), structure_, options_.ert, light);
      ++done;
      if (light.transmittance < options_.ert) break;
    }
  }
  counters_.blended += done;
  if (light.transmittance < options_.ert) {
    alive_ &= ~(std::uint64_t{1} << ray);
    ++counters_.terminated;
  }
}

void check_tile_options(const TracerOptions& options) {
  if (options.resume == Resume::strict) {
    throw Error("--tracing", "tiles", "has no rounds that could lose a tie: it needs --resume exact");
  }
  if (options.triangle_test == TriangleTest::world) {
    throw Error("--tracing", "tiles", "knows no stored triangles: it needs --triangle-test canonical");
  }
  if (options.checkpoint) {
    throw Error("--tracing", "tiles", "has no rounds to resume: checkpointing needs --tracing multi");
  }
}

TileResult render_tiles(const Scene& scene, const PreparedGaussians& gaussians, const TileStructure& structure,
                        const Camera& camera, const TracerOptions& options, const RenderOptions& render) {
  check_tile_options(options);
  TileResult result;
  result.image = Image(camera.width, camera.height);
  const glm::vec3 origin(camera.position - scene.offset);
  const unsigned across = (camera.width + kTileEdge - 1) / kTileEdge;
  const unsigned down = (camera.height + kTileEdge - 1) / kTileEdge;
  tbb::enumerable_thread_specific<TileTracer> tracers([&] { return TileTracer(scene, gaussians, structure, options); });
  Progress progress("tracing tiles", result.image.pixels.size(), " rays", render.quiet);
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(render.threads == 0 ? tbb::task_arena::automatic : static_cast<int>(render.threads));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, std::size_t{across} * down, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          TileTracer& tracer = tracers.local();
          for (std::size_t i = range.begin(); i != range.end(); ++i) {
            const TileRays tile(camera, origin, static_cast<unsigned>(i % across) * kTileEdge,
                                static_cast<unsigned>(i / across) * kTileEdge);
            const auto& lights = tracer.trace(tile);
            for (std::uint64_t rest = tile.live; rest != 0; rest &= rest - 1) {
              const auto r = static_cast<unsigned>(std::countr_zero(rest));
              const float* c = lights[r].colour;
              result.image.pixels[tile.pixel[r]] = glm::vec3(c[0], c[1], c[2]);
            }
            progress.add(static_cast<std::uint64_t>(std::popcount(tile.live)));
          }
        },
        tbb::simple_partitioner());
  });
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  progress.finish();
  for (const TileTracer& tracer : tracers) result.counters.add(tracer.counters());
  return result;
}

}  // namespace grtx::frontend
