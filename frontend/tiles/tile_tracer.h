// SPDX-License-Identifier: Apache-2.0
// Tile tracing: an image-only mode for camera rays. A tile of 8x8 rays walks the structure once, nearest first, instead
// of each ray in rounds; hits are blended as soon as no nearer one can come. The image is bit for bit RayTracer's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/base/declare/counter_table.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tiles/tile_intersection.h"
#include "grtx/frontend/tiles/tile_rays.h"
#include "grtx/frontend/tiles/tile_structure.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/tracer_options.h"

namespace grtx::frontend {

/// Sums, so they do not depend on the number of threads.
struct TileCounters {
  std::uint64_t rays = 0, blended = 0, terminated = 0;
  std::uint64_t tiles = 0, nodes = 0, gaussians = 0, candidates = 0, hit_tests = 0, hits = 0;
  static const declare::CounterTable<TileCounters>& table();
  void add(const TileCounters& o) { table().add(*this, o); }
};

/// Light gathered by a ray.
struct TileLight {
  glm::vec3 colour{0.0f};
  float transmittance = 1.0f;
};

/// One per thread.
class TileTracer {
 public:
  /// structure: of these Gaussians and of the proxy whose hit rule applies. Uses of the options: ert, sort_key, inside,
  /// sh_direction, response_precision and simd; the others change no image, or check_tile_options() refuses them.
  TileTracer(const Scene& scene, const PreparedGaussians& gaussians, const TileStructure& structure,
             const TracerOptions& options);

  /// Computes the light of the tile's live rays; result: by ray.
  const std::array<TileLight, kTileRays>& trace(const TileRays& tile);
  const TileCounters& counters() const { return counters_; }

 private:
  static constexpr std::uint32_t kNone = ~0u;

  struct QueuedChild {
    std::uint32_t child;
    std::uint32_t vectors;  ///< mask of vectors with rays that may hit it
    std::uint32_t next;
  };
  /// Linked lists of elements (`next`). Freed elements are reused first, so that those in use stay close together.
  template <typename T>
  class Pool {
   public:
    T& operator[](std::uint32_t index) { return elements_[index]; }
    std::uint32_t add(const T& element) {
      const std::uint32_t index = free_;
      if (index == kNone) {
        elements_.push_back(element);
        return static_cast<std::uint32_t>(elements_.size() - 1);
      }
      free_ = elements_[index].next;
      elements_[index] = element;
      return index;
    }
    /// Frees the list from `first` to `last`, one or more elements.
    void free(std::uint32_t first, std::uint32_t last) {
      elements_[last].next = free_;
      free_ = first;
    }
    void clear() {
      elements_.clear();
      free_ = kNone;
    }

   private:
    std::vector<T> elements_;
    std::uint32_t free_ = kNone;
  };

  /// A hit that waits until its bucket is blended.
  struct QueuedHit {
    std::uint64_t order;  ///< bits of t (never negative), then id: compares as (t, id)
    float alpha;
    float colour[3];
    std::uint32_t ray;
    std::uint32_t next;
  };
  /// A queued hit with its sort key.
  struct OrderedHit {
    std::uint64_t order;
    std::uint32_t hit;
  };
  struct Bucket {
    std::uint32_t nodes = kNone;
    std::uint32_t gaussians = kNone;
    std::uint32_t hits = kNone;
  };

  void begin(const TileRays& tile);
  void mark(unsigned bucket) { occupied_[bucket / 64] |= std::uint64_t{1} << (bucket % 64); }
  unsigned next_bucket(unsigned from) const;
  void find_live_vectors();
  void walk_nodes(const TileRays& tile, unsigned bucket);
  void test_gaussians(const TileRays& tile, unsigned bucket);
  void test_hits(const TileRays& tile, const TileCandidate& candidate, unsigned bucket);
  void test_vector(const TileRays& tile, std::uint32_t gaussian, unsigned vector, unsigned wanted, unsigned bucket);
  void test_pairs(const TileRays& tile, unsigned bucket);
  bool decide(const TileRays& tile, std::uint32_t gaussian, unsigned ray, unsigned lane);
  glm::vec3 colour_of(const TileRays& tile, std::uint32_t gaussian, unsigned ray) const;
  void queue_hit(unsigned ray, std::uint32_t gaussian, unsigned lane, const glm::vec3& colour, unsigned bucket);
  void blend_bucket(unsigned bucket);
  void blend_ray(unsigned ray, OrderedHit* hits, unsigned count);
  static void sort_hits(OrderedHit* hits, unsigned count);

  const Scene& scene_;
  const PreparedGaussians& gaussians_;
  const TileStructure& structure_;
  const TracerOptions options_;
  const TileTests tests_;
  const FaceTest test_faces_;
  const bool sphere_;  ///< spheres with entry keys: hits are decided eight at a time

  const unsigned sh_lines_;

  std::uint64_t alive_ = 0;    ///< mask of rays that continue
  unsigned live_vectors_ = 0;  ///< mask of vectors with such a ray
  TileDepths depths_;
  std::array<Bucket, TileDepths::kBuckets> buckets_{};
  std::array<std::uint64_t, TileDepths::kBuckets / 64> occupied_{};
  Pool<QueuedChild> children_;
  Pool<QueuedHit> queued_hits_;
  std::vector<std::uint32_t> work_;
  TileNodeHits node_hits_;
  TileHits hits_;
  std::vector<TileCandidate> candidates_;
  std::array<TilePair, kTileLanes> pairs_;
  unsigned pair_count_ = 0;
  std::vector<OrderedHit> ordered_;
  std::array<TileLight, kTileRays> lights_;
  std::array<TileBasis, kTileVectors> basis_;
  TileCounters counters_;
};

/// Throws Error when tile tracing cannot give the image of these options.
void check_tile_options(const TracerOptions& options);

struct TileResult {
  Image image;
  TileCounters counters;
  double seconds = 0.0;  ///< tracing alone
};

/// Renders a view; the image is the same for any number of threads. Uses of RenderOptions: threads and quiet.
TileResult render_tiles(const Scene& scene, const PreparedGaussians& gaussians, const TileStructure& structure,
                        const Camera& camera, const TracerOptions& options, const RenderOptions& render);

}  // namespace grtx::frontend
