// SPDX-License-Identifier: Apache-2.0
// The first invariant: with the exact resume rule no setting of the traversal changes a bit of the image, nor which
// Gaussians a ray blends, in which order. Each scene gets a seeded sample in which every pair of settings occurs;
// GRTX_FULL_INVARIANCE=1 runs the whole product.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <iostream>
#include <random>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "parameter_names.h"

namespace grtx::frontend {
namespace {

constexpr std::array<unsigned, 6> kBufferSizes{1, 2, 4, 8, 16, 64};
constexpr std::array<unsigned, 3> kCapacities{1, 9, 1024};  // the first two overflow

constexpr std::array<unsigned, 4> kBins{0, 2, 8, 32};

/// Numbers of choices: k, checkpointing, child order, t_max update, checkpoint order, replay t_max, capacity, pop test,
/// checkpoint bins, what lies below an instance, when any-hit shaders run, structure.
constexpr std::array<unsigned, 12> kChoices{6, 2, 3, 2, 3, 2, 3, 2, 4, 2, 2, 2};
using Setting = std::array<unsigned, kChoices.size()>;

TracerOptions options_of(const Setting& s) {
  TracerOptions options;
  options.k = kBufferSizes[s[0]];
  options.checkpoint = s[1] == 1;
  options.child_order = static_cast<ChildOrder>(s[2]);
  options.tmax_update = static_cast<TmaxUpdate>(s[3]);
  options.checkpoint_order = static_cast<CheckpointOrder>(s[4]);
  options.replay_tmax = static_cast<ReplayTmax>(s[5]);
  options.checkpoint_capacity = kCapacities[s[6]];
  options.pop_test = static_cast<PopTest>(s[7]);
  options.checkpoint_bins = kBins[s[8]];
  options.below_instance = static_cast<BelowInstance>(s[9]);
  options.any_hit = static_cast<AnyHit>(s[10]);
  return options;
}

std::string text(const Setting& s) {
  std::string result =
      "k, checkpoint, child order, t_max update, checkpoint order, replay t_max, capacity, "
      "pop test, bins, below instance, any hit, structure:";
  for (const unsigned choice : s) result += " " + std::to_string(choice);
  return result;
}

/// Without checkpointing five choices mean nothing, bins have an order of their own, and delayed any-hit shaders leave
/// nothing to checkpoint.
bool redundant(const Setting& s) {
  if (s[8] != 0 && s[4] != 0) return true;
  if (s[10] != 0 && s[1] != 0) return true;
  return s[1] == 0 && (s[4] != 0 || s[5] != 0 || s[6] != 0 || s[8] != 0 || s[9] != 0);
}

std::vector<Setting> all_settings() {
  std::vector<Setting> settings;
  Setting s{};
  for (;;) {
    if (!redundant(s)) settings.push_back(s);
    std::size_t digit = 0;
    while (digit < s.size() && ++s[digit] == kChoices[digit]) s[digit++] = 0;
    if (digit == s.size()) return settings;
  }
}

/// A seeded sample that holds every pair of choices that some setting holds: the best of a few random settings at a
/// time.
std::vector<Setting> covering_sample(unsigned seed) {
  const std::vector<Setting> all = all_settings();
  const auto pair_index = [](std::size_t i, unsigned a, std::size_t j, unsigned b) {
    return ((i * kChoices.size() + j) * 8 + a) * 8 + b;
  };
  std::vector<bool> open(kChoices.size() * kChoices.size() * 64, false);
  std::size_t left = 0;
  const auto each_pair = [&](const Setting& s, auto&& visit) {
    for (std::size_t i = 0; i < s.size(); ++i) {
      for (std::size_t j = i + 1; j < s.size(); ++j) visit(pair_index(i, s[i], j, s[j]));
    }
  };
  for (const Setting& s : all) {
    each_pair(s, [&](std::size_t pair) {
      if (!open[pair]) ++left;
      open[pair] = true;
    });
  }
  std::mt19937 engine(seed);
  std::vector<Setting> sample;
  while (left > 0) {
    const Setting* best = nullptr;
    std::size_t best_gain = 0;
    for (int attempt = 0; attempt < 60; ++attempt) {
      const Setting& s = all[engine() % all.size()];
      std::size_t gain = 0;
      each_pair(s, [&](std::size_t pair) { gain += open[pair]; });
      if (gain > best_gain) {
        best = &s;
        best_gain = gain;
      }
    }
    if (best == nullptr) continue;
    each_pair(*best, [&](std::size_t pair) { open[pair] = false; });
    left -= best_gain;
    sample.push_back(*best);
  }
  return sample;
}

void expect_same(const RenderResult& expected, const RenderResult& actual, const std::string& what) {
  EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u) << what;
  EXPECT_TRUE(expected.sequences == actual.sequences) << what;
}

/// Without the Gaussians whose ellipsoid leaves the origin out but whose polyhedron may hold it: a ray that starts
/// there meets no front face of theirs, so structures of different proxies rightly differ.
Scene without_ambiguous_insides(const Scene& scene, const PreparedGaussians& gaussians, const glm::vec3& origin) {
  Scene kept;
  kept.sh_degree = scene.sh_degree;
  kept.name = scene.name;
  const std::size_t stride = std::size_t{3} * scene.sh_coefficients();
  for (std::size_t g = 0; g < scene.size(); ++g) {
    const GaussianRecord& record = gaussians.record(static_cast<std::uint32_t>(g));
    const glm::dvec3 offset = glm::dvec3(origin) - glm::dvec3(record.mean);
    double distance2 = 0.0;  // in the frame where the ellipsoid is the unit sphere
    for (const glm::vec3& row : record.to_unit) distance2 += std::pow(glm::dot(glm::dvec3(row), offset), 2);
    if (distance2 > 0.999 && distance2 < 1.6) continue;  // an icosahedron's vertices lie at 1.2585
    kept.mean.push_back(scene.mean[g]);
    kept.scale.push_back(scene.scale[g]);
    kept.rotation.push_back(scene.rotation[g]);
    kept.opacity.push_back(scene.opacity[g]);
    kept.sh.insert(kept.sh.end(), scene.sh.begin() + static_cast<std::ptrdiff_t>(g * stride),
                   scene.sh.begin() + static_cast<std::ptrdiff_t>((g + 1) * stride));
  }
  return kept;
}

std::vector<AccelerationStructure> all_structures(const PreparedGaussians& gaussians) {
  std::vector<AccelerationStructure> structures;
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20, AccelKind::ellipsoid, AccelKind::tlas_sphere,
                               AccelKind::tri80, AccelKind::tlas_tri80}) {
    structures.emplace_back(gaussians, AccelOptions{kind, 6, false});
  }
  return structures;
}

/// All structures under peak keys agree; returns the number of renders.
std::size_t expect_proxies_agree(const Scene& all, const Camera& camera, bool full) {
  const Scene scene =
      without_ambiguous_insides(all, PreparedGaussians(all, true), glm::vec3(camera.position - all.offset));
  Camera moved = camera;  // the smaller scene has no offset
  moved.position = glm::dvec3(glm::vec3(camera.position - all.offset));
  const PreparedGaussians gaussians(scene, true);
  const std::vector<AccelerationStructure> structures = all_structures(gaussians);
  TracerOptions options;
  options.sort_key = SortKey::peak;
  const RenderResult expected = test::trace_scene(scene, moved, structures[0], gaussians, options);
  std::size_t renders = 0;
  for (const AccelerationStructure& accel : structures) {
    for (const bool checkpoint : {false, true}) {
      for (const unsigned k :
           full ? std::vector<unsigned>(kBufferSizes.begin(), kBufferSizes.end()) : std::vector<unsigned>{4u}) {
        options.checkpoint = checkpoint;
        options.k = k;
        expect_same(expected, test::trace_scene(scene, moved, accel, gaussians, options),
                    "peak keys, " + accel_name(accel.options().kind) + ", k " + std::to_string(k));
        ++renders;
      }
    }
  }
  return renders;
}

/// Settings x structures of each proxy, and all structures under peak keys.
void expect_invariant(const Scene& scene, const Camera& camera, unsigned seed) {
  const bool full = std::getenv("GRTX_FULL_INVARIANCE") != nullptr;
  const PreparedGaussians gaussians(scene, true);
  std::size_t renders = 0;
  const std::vector<AccelerationStructure> structures = all_structures(gaussians);
  for (std::size_t proxy = 0; proxy < 3; ++proxy) {
    const RenderResult expected = test::trace_scene(scene, camera, structures[2 * proxy], gaussians, {});
    for (const Setting& s : full ? all_settings() : covering_sample(seed + static_cast<unsigned>(proxy))) {
      const AccelerationStructure& accel = structures[2 * proxy + s.back()];
      expect_same(expected, test::trace_scene(scene, camera, accel, gaussians, options_of(s)),
                  accel_name(accel.options().kind) + " " + text(s));
      ++renders;
      if (testing::Test::HasFailure()) return;
    }
  }
  renders += expect_proxies_agree(scene, camera, full);
  if (full) std::cout << scene.name << ": " << renders << " renders agree\n";
}

struct Scenario {
  const char* name;
  test::RandomSceneOptions scene;
  double distance;
};

std::ostream& operator<<(std::ostream& out, const Scenario& s) { return out << s.name; }

class TracerInvarianceRandom : public testing::TestWithParam<Scenario> {};

TEST_P(TracerInvarianceRandom, EverySettingGivesTheSameImage) {
  const Scene scene = test::random_scene(11, GetParam().scene);
  const Camera camera = test::front_camera(8, 8, GetParam().distance);
  EXPECT_GT(test::trace_scene(scene, camera, AccelKind::tlas_tri20, {}).counters.blended, 100u);
  expect_invariant(scene, camera, 17);
}

INSTANTIATE_TEST_SUITE_P(Scenes, TracerInvarianceRandom,
                         testing::Values(Scenario{"mixed", {60, 0.8, -1.8, 1.0, 0.02, 0.95, 2}, 4.0},
                                         Scenario{"needles", {70, 0.8, -2.6, 2.2, 0.1, 0.9, 1}, 4.0},
                                         Scenario{"opaque", {60, 0.8, -1.8, 0.5, 0.9, 1.0, 0}, 3.0},
                                         Scenario{"surrounded", {60, 0.8, -1.2, 0.8, 0.05, 0.5, 1}, 0.2}),
                         test::PrintedName{});

class TracerInvarianceGenerated : public testing::TestWithParam<std::string> {};

TEST_P(TracerInvarianceGenerated, EverySettingGivesTheSameImage) {
  // Scenes whose rays meet nearly every Gaussian are given fewer.
  const bool deep = GetParam() == "stress-onepoint" || GetParam() == "stress-copies" || GetParam() == "stress-inside" ||
                    GetParam() == "stress-needles";
  const test::GeneratedScene generated = test::generated_scene(GetParam(), deep ? 60 : 300, 0);
  const std::size_t view = GetParam() == "stress-tiny" ? 2 : GetParam() == "stress-far" ? 3 : 0;
  expect_invariant(generated.scene, test::small_view(generated, view, 8), 5);
}

INSTANTIATE_TEST_SUITE_P(Presets, TracerInvarianceGenerated, testing::ValuesIn(synth_presets()),
                         test::preset_test_name);

TEST(TracerInvariance, OverflowHappensAndIsCounted) {
  const Scene scene = test::random_scene(3);
  TracerOptions options;
  options.k = 2;
  options.checkpoint = true;
  options.checkpoint_capacity = 4;
  const RenderResult result = test::trace_scene(scene, test::front_camera(16, 16), AccelKind::tri20, options);
  EXPECT_GT(result.counters.checkpoint_overflows, 0u);
  EXPECT_LE(result.counters.checkpoints_max_per_ray, 4u);
}

TEST(TracerInvariance, AFullBinOverflowsOnlyWhenAllBeforeItAreFull) {
  const Scene scene = test::random_scene(3);
  TracerOptions options;
  options.k = 2;
  options.checkpoint = true;
  options.checkpoint_capacity = 1;
  options.checkpoint_bins = 4;
  const Camera camera = test::front_camera(16, 16);
  const RenderResult full = test::trace_scene(scene, camera, AccelKind::tri20, options);
  EXPECT_GT(full.counters.checkpoint_overflows, 0u);
  EXPECT_LE(full.counters.checkpoints_max_per_ray, 5u);
  options.checkpoint_capacity = 1024;
  const RenderResult roomy = test::trace_scene(scene, camera, AccelKind::tri20, options);
  EXPECT_EQ(roomy.counters.checkpoint_overflows, 0u);
  options.checkpoint_capacity = static_cast<unsigned>(roomy.counters.checkpoints_max_per_ray) * 3 / 4;
  EXPECT_EQ(test::trace_scene(scene, camera, AccelKind::tri20, options).counters.checkpoint_overflows, 0u)
      << "a bin gives what it has no room for to the one before it";
}

TEST(TracerInvariance, BinsReadLessThanTwoBuffers) {
  const Scene scene = test::random_scene(3);
  TracerOptions options;
  options.k = 2;
  options.checkpoint = true;
  const Camera camera = test::front_camera(16, 16);
  const TracerCounters buffers = test::trace_scene(scene, camera, AccelKind::tri20, options).counters;
  options.checkpoint_bins = 8;
  const TracerCounters bins = test::trace_scene(scene, camera, AccelKind::tri20, options).counters;
  EXPECT_LT(bins.checkpoints_read, buffers.checkpoints_read);
  EXPECT_LT(bins.checkpoints_written, buffers.checkpoints_written);
}

TEST(TracerInvariance, AFinishedInstanceLeavesNoEntryBelowIt) {
  const Scene scene = test::random_scene(3);
  TracerOptions options;
  options.k = 2;
  options.checkpoint = true;
  const Camera camera = test::front_camera(16, 16);
  const TracerCounters cut = test::trace_scene(scene, camera, AccelKind::tlas_tri20, options).counters;
  options.below_instance = BelowInstance::finish;
  const TracerCounters finished = test::trace_scene(scene, camera, AccelKind::tlas_tri20, options).counters;
  EXPECT_LT(finished.checkpoints_written, cut.checkpoints_written);
  EXPECT_LT(finished.visits_instance, cut.visits_instance) << "no instance is entered a second time";
}

TEST(TracerInvariance, WidthAndBoundsDoNotMatter) {
  const Scene scene = test::random_scene(5);
  const Camera camera = test::front_camera(16, 16);
  const RenderResult expected = test::trace_scene(scene, camera, AccelKind::tri20, {});
  for (unsigned width = 2; width <= 8; ++width) {
    expect_same(expected, test::trace_scene(scene, camera, AccelKind::tri20, {}, width),
                "tri20 width " + std::to_string(width));
    for (const bool corners : {false, true}) {
      expect_same(expected, test::trace_scene(scene, camera, AccelKind::tlas_tri20, {}, width, corners),
                  "tlas-tri20 width " + std::to_string(width));
    }
  }
}

TEST(TracerInvariance, StrictResumeLosesTiesAndCountsThem) {
  const test::GeneratedScene generated = test::generated_scene("stress-copies", 100, 0);
  const Camera camera = test::small_view(generated, 0, 8);
  TracerOptions options;
  options.k = 4;
  const RenderResult exact = test::trace_scene(generated.scene, camera, AccelKind::tlas_tri20, options);
  options.resume = Resume::strict;
  const RenderResult strict = test::trace_scene(generated.scene, camera, AccelKind::tlas_tri20, options);
  EXPECT_EQ(exact.counters.ties_lost, 0u);
  EXPECT_GT(strict.counters.ties_lost, 0u);
  EXPECT_LT(strict.counters.blended, exact.counters.blended);
}

}  // namespace
}  // namespace grtx::frontend
