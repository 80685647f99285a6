// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tiles/tile_tracer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/response_precision.h"

namespace grtx::frontend {
namespace {

TileTests tests_of(const TracerOptions& options) {
  TileTests tests = tile_tests(options.simd);
  // Rounding to 16 bits may raise an alpha to the threshold: these hits are decided one by one.
  if (options.response_precision != ResponsePrecision::fp32) {
    tests.vector = tile_tests(SimdPath::portable).vector;
    tests.pairs = tile_tests(SimdPath::portable).pairs;
  }
  return tests;
}

void prefetch_lines(const void* first, unsigned lines) {
  for (unsigned i = 0; i < lines; ++i) __builtin_prefetch(static_cast<const char*>(first) + std::size_t{64} * i);
}

/// Every second bit of `code`, beginning with the lowest.
std::uint32_t even_bits(std::uint32_t code) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < 16; ++i) bits |= (code >> (2 * i) & 1u) << i;
  return bits;
}

/// Tiles of an image (row in the upper 16 bits, column in the lower) in Z order, so that neighbours find data in the
/// caches.
std::vector<std::uint32_t> tiles_along_a_curve(unsigned width, unsigned height) {
  const unsigned across = (width + kTileEdge - 1) / kTileEdge;
  const unsigned down = (height + kTileEdge - 1) / kTileEdge;
  const std::uint64_t edge = std::bit_ceil(std::uint64_t{std::max(across, down)});
  std::vector<std::uint32_t> tiles;
  tiles.reserve(std::size_t{across} * down);
  for (std::uint64_t code = 0; code < edge * edge; ++code) {
    const std::uint32_t x = even_bits(static_cast<std::uint32_t>(code));
    const std::uint32_t y = even_bits(static_cast<std::uint32_t>(code >> 1));
    if (x < across && y < down) tiles.push_back(y << 16 | x);
  }
  return tiles;
}

}  // namespace

const declare::CounterTable<TileCounters>& TileCounters::table() {
  using C = TileCounters;
  static const auto table = declare::CounterTable<C>()
                                .sum(&C::rays, "rays", "rays", "rays traced")
                                .sum(&C::blended, "blended", "hits", "hits blended into a pixel")
                                .sum(&C::terminated, "terminated", "rays", "rays ended by early ray termination")
                                .sum(&C::tiles, "tiles.count", "tiles", "tiles of 8x8 rays")
                                .sum(&C::nodes, "tiles.nodes", "nodes", "internal nodes tested against a tile")
                                .sum(&C::gaussians, "tiles.gaussians", "Gaussians", "outlines tested against a tile")
                                .sum(&C::candidates, "tiles.candidates", "rays", "that the outlines left")
                                .sum(&C::hit_tests, "tiles.hit_tests", "tests", "of up to eight of them at once")
                                .sum(&C::hits, "tiles.hits", "hits", "found with an alpha of at least 1/255");
  return table;
}

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
  const auto last = std::bit_cast<std::int32_t>(far_t);
  depths_.first = std::bit_cast<std::int32_t>(std::max(near_t, far_t * kFirst));
  depths_.shift = 17;
  while (last > depths_.first && (last - depths_.first) >> depths_.shift >= static_cast<int>(TileDepths::kBuckets) - 2)
    ++depths_.shift;
  for (unsigned b = next_bucket(0); b < TileDepths::kBuckets; b = next_bucket(b + 1)) buckets_[b] = {};
  occupied_.fill(0);
  children_.clear();
  queued_hits_.clear();
  alive_ = tile.live;
  lights_.fill({});
  if (options_.sh_direction == ShDirection::ray) {
    for (std::uint64_t rest = alive_; rest != 0; rest &= rest - 1) {
      const auto r = static_cast<unsigned>(std::countr_zero(rest));
      const auto basis = sh_basis(tile.rays[r].direction, scene_.sh_degree);
      for (unsigned j = 0; j < structure_.coefficients(); ++j)
        basis_[r / kTileLanes].values[j][r % kTileLanes] = basis[j];
    }
  }
}

unsigned TileTracer::next_bucket(unsigned from) const {
  for (unsigned word = from / 64; word < occupied_.size(); ++word) {
    const std::uint64_t left = word == from / 64 ? occupied_[word] >> (from % 64) << (from % 64) : occupied_[word];
    if (left != 0) return 64 * word + static_cast<unsigned>(std::countr_zero(left));
  }
  return TileDepths::kBuckets;
}

const std::array<TileLight, kTileRays>& TileTracer::trace(const TileRays& tile) {
  begin(tile);
  ++counters_.tiles;
  counters_.rays += static_cast<std::uint64_t>(std::popcount(tile.live));
  if (alive_ == 0) return lights_;
  buckets_[0].nodes = children_.add({0, 0xFF, kNone});
  mark(0);
  for (unsigned b = next_bucket(0); b < TileDepths::kBuckets && alive_ != 0; b = next_bucket(b + 1)) {
    find_live_vectors();
    walk_nodes(tile, b);
    test_gaussians(tile, b);
    blend_bucket(b);
  }
  return lights_;
}

void TileTracer::find_live_vectors() {
  live_vectors_ = 0;
  for (unsigned vector = 0; vector < kTileVectors; ++vector) {
    if ((alive_ >> (vector * kTileLanes) & 0xFFu) != 0) live_vectors_ |= 1u << vector;
  }
}

/// Skips nodes and Gaussians that only ended rays may hit.
void TileTracer::walk_nodes(const TileRays& tile, unsigned bucket) {
  work_.clear();
  candidates_.clear();
  std::uint32_t end = kNone;
  for (std::uint32_t i = buckets_[bucket].nodes; i != kNone; i = children_[i].next) {
    end = i;
    if ((children_[i].vectors & live_vectors_) == 0) continue;
    work_.push_back(children_[i].child);
    prefetch_lines(&structure_.node(children_[i].child), 2);
  }
  if (end != kNone) children_.free(buckets_[bucket].nodes, end);
  for (std::size_t at = 0; at < work_.size(); ++at) {
    const TileNode& node = structure_.node(work_[at]);
    const unsigned met = tests_.node(node, tile, depths_, bucket, node_hits_);
    for (unsigned rest = met & node.leaves; rest != 0; rest &= rest - 1) {
      const auto slot = static_cast<unsigned>(std::countr_zero(rest));
      if ((node_hits_.vectors[slot] & live_vectors_) == 0) continue;
      const std::uint32_t b = node_hits_.bucket[slot];
      __builtin_prefetch(&structure_.gaussian(node.child[slot]));
      if (b == bucket) {
        candidates_.push_back({node_hits_.vectors[slot] & live_vectors_, node.child[slot]});
        continue;
      }
      buckets_[b].gaussians = children_.add({node.child[slot], node_hits_.vectors[slot], buckets_[b].gaussians});
      mark(b);
    }
    for (unsigned rest = met & ~node.leaves; rest != 0; rest &= rest - 1) {
      const auto slot = static_cast<unsigned>(std::countr_zero(rest));
      if ((node_hits_.vectors[slot] & live_vectors_) == 0) continue;
      const std::uint32_t b = node_hits_.bucket[slot];
      prefetch_lines(&structure_.node(node.child[slot]), 2);
      if (b == bucket) {
        work_.push_back(node.child[slot]);
        continue;
      }
      buckets_[b].nodes = children_.add({node.child[slot], node_hits_.vectors[slot], buckets_[b].nodes});
      mark(b);
    }
  }
  counters_.nodes += work_.size();
}

void TileTracer::test_gaussians(const TileRays& tile, unsigned bucket) {
  std::uint32_t end = kNone;
  for (std::uint32_t i = buckets_[bucket].gaussians; i != kNone; i = children_[i].next) {
    end = i;
    const unsigned vectors = children_[i].vectors & live_vectors_;
    if (vectors == 0) continue;
    candidates_.push_back({vectors, children_[i].child});
    __builtin_prefetch(&structure_.gaussian(children_[i].child));
  }
  if (end != kNone) children_.free(buckets_[bucket].gaussians, end);
  counters_.gaussians += candidates_.size();
  tests_.outlines(structure_, tile, candidates_.data(), candidates_.size());
  std::size_t left = 0;
  for (const TileCandidate& candidate : candidates_) {
    const std::uint64_t rays = candidate.rays & alive_;
    if (rays == 0) continue;
    __builtin_prefetch(&structure_.box(candidate.gaussian));
    candidates_[left++] = {rays, candidate.gaussian};
  }
  candidates_.resize(left);
  for (const TileCandidate& candidate : candidates_) test_hits(tile, candidate, bucket);
  if (pair_count_ > 0) test_pairs(tile, bucket);
}

/// Tests a vector with enough rays as a whole; other rays are collected into groups of eight pairs.
void TileTracer::test_hits(const TileRays& tile, const TileCandidate& candidate, unsigned bucket) {
  constexpr int kEnough = 4;
  prefetch_lines(structure_.sh(candidate.gaussian), sh_lines_);
  counters_.candidates += static_cast<std::uint64_t>(std::popcount(candidate.rays));
  for (unsigned vector = 0; vector < kTileVectors; ++vector) {
    const auto wanted = static_cast<unsigned>(candidate.rays >> (vector * kTileLanes)) & 0xFFu;
    if (wanted == 0) continue;
    if (std::popcount(wanted) >= kEnough) {
      test_vector(tile, candidate.gaussian, vector, wanted, bucket);
      continue;
    }
    for (unsigned rest = wanted; rest != 0; rest &= rest - 1) {
      pairs_[pair_count_++] = {candidate.gaussian, vector * kTileLanes + static_cast<unsigned>(std::countr_zero(rest))};
      if (pair_count_ == pairs_.size()) test_pairs(tile, bucket);
    }
  }
}

void TileTracer::test_vector(const TileRays& tile, std::uint32_t gaussian, unsigned vector, unsigned wanted,
                             unsigned bucket) {
  ++counters_.hit_tests;
  tests_.vector(structure_.gaussian(gaussian), structure_.box(gaussian).box, tile, vector, wanted, sphere_, hits_);
  const unsigned first = vector * kTileLanes;
  unsigned hit = hits_.hit;
  for (unsigned rest = hits_.unsure; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(rest));
    if (decide(tile, gaussian, first + lane, lane)) hit |= 1u << lane;
  }
  if (hit == 0) return;
  if (options_.sh_direction == ShDirection::ray) {
    tests_.colours(structure_.sh(gaussian), structure_.coefficients(), basis_[vector], hits_);
  } else {
    const glm::vec3 colour = colour_of(tile, gaussian, first);
    for (int c = 0; c < 3; ++c) std::fill_n(hits_.colour[c], kTileLanes, colour[c]);
  }
  for (; hit != 0; hit &= hit - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(hit));
    queue_hit(first + lane, gaussian, lane, {hits_.colour[0][lane], hits_.colour[1][lane], hits_.colour[2][lane]},
              bucket);
  }
}

void TileTracer::test_pairs(const TileRays& tile, unsigned bucket) {
  ++counters_.hit_tests;
  tests_.pairs(structure_, tile, pairs_.data(), pair_count_, sphere_, hits_);
  pair_count_ = 0;
  for (unsigned rest = hits_.hit | hits_.unsure; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(rest));
    const TilePair& pair = pairs_[lane];
    if ((hits_.unsure >> lane & 1) != 0 && !decide(tile, pair.gaussian, pair.ray, lane)) continue;
    queue_hit(pair.ray, pair.gaussian, lane, colour_of(tile, pair.gaussian, pair.ray), bucket);
  }
}

/// Calls the hit function for one ray; stores the hit in a lane.
bool TileTracer::decide(const TileRays& tile, std::uint32_t gaussian, unsigned ray, unsigned lane) {
  const TileGaussian& g = structure_.gaussian(gaussian);
  const UnitRay unit = to_unit_ray(tile.rays[ray], gaussians_.record(g.id));
  if (!(unit.d2 <= 1.0f)) return false;
  const Hit hit = canonical_hit(tile.rays[ray], unit, gaussians_, g.id, structure_.proxy(), options_.sort_key,
                                options_.inside, test_faces_);
  if (hit.kind != HitKind::hit) return false;
  hits_.t[lane] = hit.t;
  hits_.alpha[lane] = options_.response_precision == ResponsePrecision::fp32
                          ? hit_alpha(g.opacity, g.kappa2, hit.d2)
                          : hit_alpha_16(g.opacity, g.kappa2, hit.d2, options_.response_precision);
  return hits_.alpha[lane] > 0.0f;
}

glm::vec3 TileTracer::colour_of(const TileRays& tile, std::uint32_t gaussian, unsigned ray) const {
  const float* sh = structure_.sh(gaussian);
  if (options_.sh_direction == ShDirection::ray) {
    float rgb[4];
    tests_.colour(sh, structure_.coefficients(), basis_[ray / kTileLanes], ray % kTileLanes, rgb);
    return {rgb[0], rgb[1], rgb[2]};
  }
  const auto basis = sh_basis(unit_vector(structure_.gaussian(gaussian).mean - tile.origin), scene_.sh_degree);
  return sh_colour(sh, basis, structure_.coefficients());
}

/// Queues the hit in `lane`.
void TileTracer::queue_hit(unsigned ray, std::uint32_t gaussian, unsigned lane, const glm::vec3& colour,
                           unsigned bucket) {
  ++counters_.hits;
  const float t = hits_.t[lane];
  const unsigned b = std::max(bucket, depths_.bucket_of(t));
  const std::uint64_t order =
      static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(t)) << 32 | structure_.gaussian(gaussian).id;
  buckets_[b].hits =
      queued_hits_.add({order, hits_.alpha[lane], {colour.x, colour.y, colour.z}, ray, buckets_[b].hits});
  mark(b);
}

void TileTracer::blend_bucket(unsigned bucket) {
  const std::uint32_t first = buckets_[bucket].hits;
  if (first == kNone) return;
  // Groups the hits by ray with a counting sort.
  std::array<std::uint32_t, kTileRays> end{};
  std::uint64_t rays = 0;
  std::uint32_t total = 0, last = first;
  for (std::uint32_t i = first; i != kNone; i = queued_hits_[i].next) {
    const std::uint32_t ray = queued_hits_[i].ray;
    ++end[ray];
    rays |= std::uint64_t{1} << ray;
    ++total;
    last = i;
  }
  std::uint32_t sum = 0;
  for (std::uint64_t rest = rays; rest != 0; rest &= rest - 1) {
    std::uint32_t& place = end[static_cast<unsigned>(std::countr_zero(rest))];
    const std::uint32_t count = place;
    place = sum;
    sum += count;
  }
  if (ordered_.size() < total) ordered_.resize(total);
  for (std::uint32_t i = first; i != kNone; i = queued_hits_[i].next) {
    const QueuedHit& hit = queued_hits_[i];
    ordered_[end[hit.ray]++] = {hit.order, i};
  }
  OrderedHit* begin_of_ray = ordered_.data();
  for (std::uint64_t rest = rays; rest != 0; rest &= rest - 1) {
    const auto ray = static_cast<unsigned>(std::countr_zero(rest));
    OrderedHit* const end_of_ray = ordered_.data() + end[ray];
    if ((alive_ >> ray & 1) != 0) blend_ray(ray, begin_of_ray, static_cast<unsigned>(end_of_ray - begin_of_ray));
    begin_of_ray = end_of_ray;
  }
  queued_hits_.free(first, last);
}

/// Sorts by (t, id). Usually there are few: a bucket has few hits per ray.
void TileTracer::sort_hits(OrderedHit* hits, unsigned count) {
  if (count > 24) {
    std::sort(hits, hits + count, [](const OrderedHit& a, const OrderedHit& b) { return a.order < b.order; });
    return;
  }
  for (unsigned i = 1; i < count; ++i) {
    const OrderedHit hit = hits[i];
    unsigned at = i;
    for (; at > 0 && hit.order < hits[at - 1].order; --at) hits[at] = hits[at - 1];
    hits[at] = hit;
  }
}

void TileTracer::blend_ray(unsigned ray, OrderedHit* hits, unsigned count) {
  sort_hits(hits, count);
  TileLight light = lights_[ray];
  for (unsigned i = 0; i < count; ++i) {
    const QueuedHit& hit = queued_hits_[hits[i].hit];
    const float weight = hit.alpha * light.transmittance;
    light.colour += weight * glm::vec3(hit.colour[0], hit.colour[1], hit.colour[2]);
    light.transmittance *= 1.0f - hit.alpha;
    ++counters_.blended;
    if (light.transmittance < options_.ert) {
      alive_ &= ~(std::uint64_t{1} << ray);
      ++counters_.terminated;
      break;
    }
  }
  lights_[ray] = light;
}

void check_tile_options(const TracerOptions& options) {
  if (options.resume == Resume::strict) {
    throw Error("--tracing", "tiles", "has no rounds that could lose a tie: it needs --resume exact");
  }
  if (options.triangle_test == TriangleTest::world) {
    throw Error("--tracing", "tiles", "knows no stored triangles: it needs --triangle-test canonical");
  }
  if (options.any_hit == AnyHit::delayed) {
    throw Error("--any-hit", "delayed", "runs behind a round's traversal: it needs --tracing multi");
  }
  if (options.ahead > 1) throw Error("--ahead", std::to_string(options.ahead), "needs --tracing multi");
  if (options.ert_check == ErtCheck::round) {
    throw Error("--ert-check", "round", "needs rounds, which --tracing tiles does not have");
  }
  if (options.kernel.degree != 2) {
    throw Error("--tracing", "tiles", "knows the normal distribution only: it needs --kernel-degree 2");
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
  const std::vector<std::uint32_t> tiles = tiles_along_a_curve(camera.width, camera.height);
  tbb::enumerable_thread_specific<TileTracer> tracers([&] { return TileTracer(scene, gaussians, structure, options); });
  Progress progress("tracing tiles", result.image.pixels.size(), " rays", render.quiet);
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(render.threads == 0 ? tbb::task_arena::automatic : static_cast<int>(render.threads));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, tiles.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          TileTracer& tracer = tracers.local();
          for (std::size_t i = range.begin(); i != range.end(); ++i) {
            const TileRays tile(camera, origin, (tiles[i] & 0xFFFFu) * kTileEdge, (tiles[i] >> 16) * kTileEdge);
            const auto& lights = tracer.trace(tile);
            for (std::uint64_t rest = tile.live; rest != 0; rest &= rest - 1) {
              const auto r = static_cast<unsigned>(std::countr_zero(rest));
              result.image.pixels[tile.pixel[r]] = lights[r].colour;
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
