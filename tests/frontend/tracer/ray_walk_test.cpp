// The walk by lists of known nodes against a plain recursive one, and whole rays against the walk that records events.
#include "grtx/frontend/tracer/ray_walk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "parameter_names.h"

namespace grtx::frontend {
namespace {

/// What leaves hold in these walks: a hit for one of four, at some t behind its box's entry.
struct Leaves {
  std::uint32_t seed;
  static constexpr float kNone = -1.0f;

  std::uint32_t hash(std::uint32_t address) const {
    std::uint32_t h = (address ^ seed) * 2654435761u;
    return (h ^ h >> 15) * 2246822519u;
  }
  float hit(std::uint32_t address, float enter) const {
    const std::uint32_t h = hash(address);
    return h % 4 == 0 ? enter + static_cast<float>(h >> 8 & 255u) / 512.0f : kNone;
  }
  bool lowers_t_max(std::uint32_t address) const { return hash(address) >> 16 & 1u; }
};

/// One round's visits, as both walks tell them.
struct Round {
  std::uint64_t internal = 0, leaves = 0;
  std::vector<std::uint32_t> first;  ///< addresses visited for the first time, in order
  std::vector<std::uint32_t> hits;   ///< addresses of hits in [t_last, t_max] when visited, in order
  float t_max = 0.0f;
  friend bool operator==(const Round&, const Round&) = default;
};

/// Depth first, near first, straight from the decoded nodes.
class PlainWalk {
 public:
  PlainWalk(const NodeImage& image, const SlabRay& ray, const Leaves& leaves)
      : image_(image), ray_(ray), leaves_(leaves) {}

  Round round(std::uint64_t root, float t_last, float t_max) {
    result_ = {};
    t_last_ = t_last;
    t_max_ = t_max;
    internal(root, 0.0f);
    result_.t_max = t_max_;
    return result_;
  }
  std::uint64_t sticking_out() const { return sticking_out_; }

 private:
  void seen(std::uint64_t address) {
    const auto units = static_cast<std::uint32_t>(address / traces::kNodeUnit);
    if (seen_.insert(units).second) result_.first.push_back(units);
  }
  void internal(std::uint64_t address, float enter) {
    ++result_.internal;
    seen(address);
    const DecodedInternal node = image_.decode_internal(address);
    std::vector<std::tuple<float, unsigned, std::uint64_t>> children;
    std::uint64_t child = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      const Interval t = conservative_interval(ray_, node.boxes[slot]);
      if (!t.empty() && t.exit >= std::max(t_last_, 0.0f)) {
        if (t.enter < enter) ++sticking_out_;
        if (t.enter <= t_max_) children.emplace_back(t.enter, slot, child);
      }
      child += traces::node_bytes(node.kinds[slot], image_.width());
    }
    std::sort(children.begin(), children.end());
    for (const auto& [t, slot, at] : children) {
      if (t > t_max_) continue;
      if (node.kinds[slot] == NodeKind::internal) {
        internal(at, t);
      } else {
        leaf(at, t);
      }
    }
  }
  void leaf(std::uint64_t address, float enter) {
    ++result_.leaves;
    seen(address);
    const auto units = static_cast<std::uint32_t>(address / traces::kNodeUnit);
    const float t = leaves_.hit(units, enter);
    if (t < 0.0f || t < t_last_ || t > t_max_) return;
    result_.hits.push_back(units);
    if (leaves_.lowers_t_max(units)) t_max_ = t;
  }

  const NodeImage& image_;
  const SlabRay ray_;
  const Leaves leaves_;
  std::set<std::uint32_t> seen_;
  Round result_;
  float t_last_ = 0.0f, t_max_ = 0.0f;
  std::uint64_t sticking_out_ = 0;
};

/// The same round by lists. entries: the entry t of leaves, which this walk does not tell.
Round round_by_lists(RayWalk& walk, const SlabRay& ray, const Leaves& leaves,
                     const std::map<std::uint32_t, float>& entries, std::vector<std::uint32_t>& numbers, float t_last,
                     float t_max) {
  Round result;
  const auto take = [&](std::uint32_t leaf, float t) {
    result.hits.push_back(leaf);
    if (!leaves.lowers_t_max(leaf)) return;
    t_max = t;
    walk.set_t_max(t_max);
  };
  walk.begin_round(std::max(t_last, 0.0f), t_last, t_max);
  for (;;) {
    switch (walk.step()) {
      case RayWalk::Stop::node:
        ++result.internal;
        result.first.push_back(walk.address());
        walk.open(ray);
        break;
      case RayWalk::Stop::leaf: {
        ++result.leaves;
        const std::uint32_t leaf = walk.address();
        result.first.push_back(leaf);
        const float t = leaves.hit(leaf, entries.at(leaf));
        if (t < 0.0f) {
          walk.leaf_done();
          break;
        }
        numbers.push_back(leaf);
        walk.leaf_hit(t, static_cast<std::uint32_t>(numbers.size() - 1));
        if (t >= t_last && t <= t_max) take(leaf, t);
        break;
      }
      case RayWalk::Stop::hit: {
        const std::uint32_t leaf = numbers[walk.hit()];
        take(leaf, leaves.hit(leaf, entries.at(leaf)));
        break;
      }
      case RayWalk::Stop::end:
        result.internal += walk.repeated_internal();
        result.leaves += walk.repeated_leaves();
        result.t_max = t_max;
        return result;
    }
  }
}

/// Entry t of every leaf, whether the ray meets it or not.
void leaf_entries(const NodeImage& image, const SlabRay& ray, std::uint64_t address,
                  std::map<std::uint32_t, float>& entries) {
  const DecodedInternal node = image.decode_internal(address);
  std::uint64_t child = node.child_base;
  for (unsigned slot = 0; slot < node.child_count; ++slot) {
    if (node.kinds[slot] == NodeKind::internal) {
      leaf_entries(image, ray, child, entries);
    } else {
      entries[static_cast<std::uint32_t>(child / traces::kNodeUnit)] =
          conservative_interval(ray, node.boxes[slot]).enter;
    }
    child += traces::node_bytes(node.kinds[slot], image.width());
  }
}

struct Tree {
  AccelKind kind;
  unsigned width;
  unsigned box_bits;
  friend void PrintTo(const Tree& t, std::ostream* out) {
    *out << accel_name(t.kind) << ", width " << t.width << ", box bits " << t.box_bits;
  }
};

class RayWalkOf : public testing::TestWithParam<Tree> {};

TEST_P(RayWalkOf, VisitsWhatAPlainWalkVisits) {
  const Scene scene = test::random_scene(31, {.count = 40, .log_scale_mean = -1.5});
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {GetParam().kind, GetParam().width, false, GetParam().box_bits});
  const auto root = static_cast<std::uint32_t>(accel.root() / traces::kNodeUnit);
  std::mt19937 engine(7);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * (static_cast<float>(engine() >> 8) / 16777216.0f);
  };
  const auto within = [&](float most) {
    glm::vec3 v;
    for (int k = 2; k >= 0; --k) v[k] = uniform(-most, most);  // a statement each: a call's arguments have no order
    return v;
  };
  const std::vector<SimdPath>& paths = available_simd_paths();
  std::uint64_t sticking_out = 0;                     // of one plain walk a ray, however many paths the host has
  std::vector<std::uint64_t> repeated(paths.size());  // by path
  for (int trial = 0; trial < 60; ++trial) {
    const glm::vec3 origin = within(3.0f), to = within(0.6f);
    glm::vec3 direction = glm::normalize(to - origin);
    if (trial % 10 == 0) direction = glm::vec3(0.0f, 0.0f, origin.z > 0.0f ? -1.0f : 1.0f);
    const SlabRay ray(origin, direction);
    const Leaves leaves{static_cast<std::uint32_t>(engine())};
    std::map<std::uint32_t, float> entries;
    leaf_entries(accel.image(), ray, accel.root(), entries);
    std::vector<float> ends;  // t_last of the rounds
    for (int i = 0; i < 5; ++i) ends.push_back(uniform(0.0f, 6.0f));
    std::sort(ends.begin(), ends.end());
    ends.insert(ends.begin(), -1.0f);
    for (std::size_t p = 0; p < paths.size(); ++p) {
      PlainWalk plain(accel.image(), ray, leaves);
      RayWalk walk(accel.image(), walk_kernels(paths[p], accel.image().layout()));
      walk.begin_ray(root);
      std::vector<std::uint32_t> numbers;
      for (std::size_t i = 0; i < ends.size(); ++i) {
        const float t_max = i % 2 == 0 ? std::numeric_limits<float>::infinity() : ends[i] + 2.0f;
        const Round expected = plain.round(accel.root(), ends[i], t_max);
        const Round got = round_by_lists(walk, ray, leaves, entries, numbers, ends[i], t_max);
        ASSERT_EQ(got, expected) << simd_path_name(paths[p]) << ", ray " << trial << ", round " << i;
        repeated[p] += walk.repeated_internal() + walk.repeated_leaves();
      }
      if (p == 0) sticking_out += plain.sticking_out();
    }
  }
  EXPECT_THAT(repeated, testing::Each(testing::Gt(5000u)));
  // Nodes that need a visited parent to be visited.
  EXPECT_GT(sticking_out, GetParam().box_bits < 8 ? 300u : 3u);
}

INSTANTIATE_TEST_SUITE_P(Trees, RayWalkOf,
                         testing::Values(Tree{AccelKind::tri20, 6, 8}, Tree{AccelKind::tri20, 6, 2},
                                         Tree{AccelKind::tri20, 2, 3}, Tree{AccelKind::tri20, 8, 2},
                                         Tree{AccelKind::tri20, 7, 8}, Tree{AccelKind::tri80, 6, 3},
                                         Tree{AccelKind::ellipsoid, 5, 2}),
                         test::PrintedName{});

/// Children whose entry t differ in few of the last bits, or not at all.
TEST(WalkKernels, OrderNearlyEqualChildrenAlike) {
  constexpr std::uint64_t kBytes = 1 << 16;
  for (const unsigned width : {6u, 8u}) {
    NodeImage image(width, kBytes);
    const InternalLayout& layout = image.layout();
    std::mt19937 engine(11);
    const auto random = [&](unsigned below) { return static_cast<unsigned>(engine()) % below; };
    unsigned nearly = 0, equal = 0, sticking_out = 0;
    for (int trial = 0; trial < 20000; ++trial) {
      auto* const node = const_cast<std::uint8_t*>(image.node(512));
      for (unsigned i = 0; i < traces::internal_bytes(width); ++i) node[i] = static_cast<std::uint8_t>(random(256));
      // Boxes one unit in the last place wide, or some, around 1 on one axis; of nearly any size on the others.
      const unsigned axis = random(3);
      for (unsigned a = 0; a < 3; ++a) {
        const float origin = a == axis ? 1.0f + static_cast<float>(random(64)) * 0x1p-23f : -1.0f;
        std::memcpy(node + 4 * a, &origin, 4);
        node[18 + a] = static_cast<std::uint8_t>(a == axis ? -15 + static_cast<int>(random(3)) : 1);
        for (unsigned slot = 0; slot < layout.slots; ++slot) {
          std::uint8_t* const lower = node + layout.bounds + 2 * a * layout.slots + slot;
          *lower = static_cast<std::uint8_t>(a == axis ? random(24) : 0);
          lower[layout.slots] = static_cast<std::uint8_t>(a == axis ? *lower + random(4) : 255);
        }
      }
      const std::int32_t offset = 8;
      std::memcpy(node + 12, &offset, 4);
      for (unsigned slot = 0; slot < layout.slots; ++slot) {
        const unsigned size = random(5) == 0 ? 0 : width == 8 && random(2) == 0 ? 2 : 1;
        const NodeKind kind = random(2) == 0 ? NodeKind::triangle : NodeKind::internal;
        node[layout.child_info + slot] = static_cast<std::uint8_t>(size | static_cast<unsigned>(kind) << 2);
      }
      glm::vec3 direction(0.001f, 0.002f, 0.0015f);
      direction[static_cast<int>(axis)] = 1.0f;
      const SlabRay ray(glm::vec3(0.0f), direction);
      const float bound = 1.0f + static_cast<float>(random(64)) * 0x1p-22f;
      std::vector<WalkState> walks(available_simd_paths().size());
      for (std::size_t i = 0; i < walks.size(); ++i) {
        walks[i].stack.size = 3;
        walk_kernels(available_simd_paths()[i], layout).open(walks[i], image, 8, ray, bound, 1.0f + 0x1p-20f);
        const WalkStack &stack = walks[i].stack, &expected = walks.front().stack;
        ASSERT_EQ(stack.size, expected.size);
        ASSERT_EQ(walks[i].pushed_at, 3u);
        ASSERT_EQ(walks[i].sticking_out, walks.front().sticking_out);
        for (std::uint32_t at = 3; at < stack.size; ++at) {
          ASSERT_EQ(stack.what[at], expected.what[at]) << simd_path_name(available_simd_paths()[i]) << " " << trial;
          ASSERT_EQ(stack.enter[at], expected.enter[at]);
          ASSERT_EQ(stack.exit[at], expected.exit[at]);
          if (at == 3 || i != 0) continue;
          equal += stack.enter[at] == stack.enter[at - 1] ? 1 : 0;
          const auto bits = [&](std::uint32_t place) { return std::bit_cast<std::uint32_t>(stack.enter[place]); };
          nearly += bits(at) != bits(at - 1) && bits(at) / 8 == bits(at - 1) / 8 ? 1 : 0;
        }
      }
      sticking_out += walks.front().sticking_out != 0 ? 1 : 0;
    }
    EXPECT_GT(nearly, 5000u);
    EXPECT_GT(equal, 1000u);
    EXPECT_GT(sticking_out, 1000u);
  }
}

/// All that the tracer counts, but for events that nobody asked for.
std::vector<std::uint64_t> counts(const TracerCounters& c) {
  return {c.rays,
          c.rounds,
          c.visits_internal,
          c.visits_leaf,
          c.any_hit_inserted,
          c.any_hit_evicted,
          c.any_hit_rejected,
          c.any_hit_ignored,
          c.processed,
          c.blended,
          c.ties_lost,
          c.inside_skipped,
          c.terminated,
          c.skipped_retests,
          c.skipped_dead_colours,
          c.skipped_sh_bands,
          c.skipped_scene_misses};
}

TEST(RayWalk, GivesRaysTheColoursAndCountsOfTheWalkThatRecords) {
  Scene scene = test::random_scene(90, {.count = 250, .log_scale_mean = -2.0, .opacity_high = 0.99});
  for (std::size_t i = 0; i < scene.size(); i += 9) scene.opacity[i] = 0.0030f;
  for (std::size_t i = 1; i < scene.size(); i += 9) {  // pairs that tie
    scene.mean[i] = scene.mean[i - 1];
    scene.scale[i] = scene.scale[i - 1];
    scene.rotation[i] = scene.rotation[i - 1];
  }
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(16, 16, 1.2);  // inside the scene
  for (unsigned variant = 0; variant < 48; ++variant) {
    static constexpr AccelKind kKinds[] = {AccelKind::tri20, AccelKind::tri80, AccelKind::ellipsoid};
    static constexpr unsigned kWidths[] = {6, 2, 8, 4};
    static constexpr unsigned kBits[] = {8, 2, 4};
    const AccelKind kind = kKinds[variant % 3];
    const AccelerationStructure accel(gaussians, {kind, kWidths[variant % 4], false, kBits[variant / 3 % 3]});
    TracerOptions options;
    options.k = 1u << variant % 5;
    options.sort_key = variant % 7 == 1 ? SortKey::peak : SortKey::entry;
    options.resume = variant % 5 == 2 ? Resume::strict : Resume::exact;
    options.tmax_update = variant % 4 == 3 ? TmaxUpdate::kth : TmaxUpdate::reported;
    options.inside = variant % 6 == 5 ? InsideRule::count : InsideRule::skip;
    options.ert = variant % 3 == 1 ? 0.0f : 0.001f;
    options.simd = available_simd_paths()[variant / 7 % available_simd_paths().size()];
    SCOPED_TRACE(accel_name(kind) + " variant " + std::to_string(variant));
    RayTracer by_lists(scene, gaussians, accel, options), recording(scene, gaussians, accel, options);
    Footprint touched(accel.image()), expected_touched(accel.image());
    VisitTracker tracker(touched), expected_tracker(expected_touched);
    by_lists.track_visits(&tracker);
    recording.track_visits(&expected_tracker);
    NullRecorder nobody;
    GroupRecorder recorder(accel.image());
    recorder.begin_group(0, traces::RayKind::primary);
    for (std::uint32_t pixel = 0; pixel < camera.width * camera.height; ++pixel) {
      const TraceRay ray(glm::vec3(camera.position), glm::vec3(camera.direction(pixel % 16, pixel / 16)));
      const float limit = pixel % 3 == 0 ? 1.3f : std::numeric_limits<float>::infinity();
      recorder.begin_ray(pixel);
      const RayResult got = by_lists.trace(ray, nobody, 1.0f, limit);
      const RayResult expected = recording.trace(ray, recorder, 1.0f, limit);
      ASSERT_EQ(got.colour, expected.colour) << pixel;
      ASSERT_EQ(got.transmittance, expected.transmittance) << pixel;
      ASSERT_EQ(counts(by_lists.counters()), counts(recording.counters())) << pixel;
    }
    EXPECT_GT(by_lists.counters().skipped_retests, 0u);
    EXPECT_EQ(tracker.unique(), expected_tracker.unique());
    EXPECT_EQ(touched.bytes(), expected_touched.bytes());
  }
}

}  // namespace
}  // namespace grtx::frontend
