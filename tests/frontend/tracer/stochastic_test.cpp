// Stochastic tracing: unbiased, its error falls with the square root of the samples, the same for every structure; its
// trace is checked, and changed ones are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <string>

#include "error_of.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/coin.h"
#include "grtx/traces/codec/check_group.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "traces/temporary_file.h"

namespace grtx::frontend {
namespace {

TracerOptions stochastic(unsigned samples, std::uint32_t seed = 1) {
  TracerOptions options;
  options.k = 1;
  options.tracing = Tracing::stochastic;
  options.samples = samples;
  options.sample_seed = seed;
  return options;
}

double rms(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::dvec3 d = glm::dvec3(a.pixels[i]) - glm::dvec3(b.pixels[i]);
    sum += glm::dot(d, d);
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(a.pixels.size())));
}

TEST(Stochastic, ImageDoesNotDependOnTheStructureOrTheOrderOfVisits) {
  const Scene scene = test::random_scene(61, {120, 0.8, -1.8, 1.0, 0.02, 0.95, 1});
  const Camera camera = test::front_camera(12, 10);
  for (const auto kinds : {std::array{AccelKind::tri20, AccelKind::tlas_tri20},
                           std::array{AccelKind::ellipsoid, AccelKind::tlas_sphere}}) {
    const RenderResult expected = test::trace_scene(scene, camera, kinds[0], stochastic(5));
    ASSERT_GT(expected.counters.blended, 100u);
    for (const AccelKind kind : kinds) {
      for (const ChildOrder order : {ChildOrder::near_first, ChildOrder::slot, ChildOrder::vulkan_sim}) {
        for (const PopTest pop_test : {PopTest::on, PopTest::off}) {
          TracerOptions options = stochastic(5);
          options.child_order = order;
          options.pop_test = pop_test;
          const RenderResult actual = test::trace_scene(scene, camera, kind, options);
          EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u) << accel_name(kind);
          EXPECT_TRUE(expected.sequences == actual.sequences) << accel_name(kind);
        }
      }
    }
  }
}

TEST(Stochastic, ErrorFallsWithTheRootOfTheSamplesAndHasNoBias) {
  const Scene scene = test::random_scene(62, {150, 0.8, -1.8, 1.0, 0.02, 0.95, 1});
  const Camera camera = test::front_camera(16, 16);
  TracerOptions exact;
  exact.ert = 0.0f;  // early termination is a bias of the exact image
  const Image expected = test::trace_scene(scene, camera, AccelKind::ellipsoid, exact).image;
  const double few = rms(expected, test::trace_scene(scene, camera, AccelKind::ellipsoid, stochastic(16)).image);
  const double many = rms(expected, test::trace_scene(scene, camera, AccelKind::ellipsoid, stochastic(4096)).image);
  EXPECT_NEAR(few / many, 16.0, 2.5);
  // Another seed is another image of the same error.
  const Image other = test::trace_scene(scene, camera, AccelKind::ellipsoid, stochastic(16, 2)).image;
  EXPECT_NEAR(rms(expected, other) / few, 1.0, 0.25);
  EXPECT_GT(rms(other, test::trace_scene(scene, camera, AccelKind::ellipsoid, stochastic(16)).image), few);
}

TEST(Stochastic, OneGaussianStopsItsAlphaOfTheSamples) {
  Scene scene = test::random_scene(63, {1, 0.0, -0.5, 0.0, 0.6, 0.6, 0});
  const Camera camera = test::front_camera(8, 8);
  TracerOptions exact;
  const RenderResult expected = test::trace_scene(scene, camera, AccelKind::ellipsoid, exact);
  constexpr unsigned kSamples = 20000;
  const RenderResult sampled = test::trace_scene(scene, camera, AccelKind::ellipsoid, stochastic(kSamples));
  // One Gaussian, one colour: a pixel is alpha times what the ray sees of it.
  unsigned seen = 0;
  for (std::size_t i = 0; i < expected.image.pixels.size(); ++i) {
    const float alpha_colour = expected.image.pixels[i].x;
    if (expected.sequences[i].empty()) continue;
    ++seen;
    const double stopped = static_cast<double>(sampled.sequences[i].size()) / kSamples;
    const double colour = sampled.image.pixels[i].x / std::max(stopped, 1e-9);
    const double alpha = alpha_colour / colour;
    EXPECT_NEAR(stopped, alpha, 5 * std::sqrt(alpha * (1 - alpha) / kSamples) + 1e-6) << "pixel " << i;
  }
  EXPECT_GT(seen, 4u);
}

TEST(Stochastic, CoinsAreFairAndIndependentOfTheirNeighbours) {
  Coin coin(7);
  coin.begin_ray(TraceRay(glm::vec3(1, 2, 3), glm::vec3(0, 0, 1)));
  for (const float alpha : {0.0f, 1.0f / 255.0f, 0.3f, 0.99f}) {
    unsigned stops = 0, both = 0, same_sample = 0;
    constexpr unsigned kTosses = 100000;
    for (unsigned i = 0; i < kTosses; ++i) {
      coin.begin_sample(i);
      const bool a = coin.stops(5, alpha), b = coin.stops(6, alpha);
      stops += a ? 1 : 0;
      same_sample += a && b ? 1 : 0;
      coin.begin_sample(i + 1);
      both += a && coin.stops(5, alpha) ? 1 : 0;
    }
    const auto within = [&](unsigned count, double p) {
      EXPECT_NEAR(count, kTosses * p, 5 * std::sqrt(kTosses * p * (1 - p)) + 1e-9) << alpha;
    };
    within(stops, alpha);
    within(both, static_cast<double>(alpha) * alpha);
    within(same_sample, static_cast<double>(alpha) * alpha);
  }
}

class StochasticTrace : public ::testing::Test {
 protected:
  void SetUp() override {
    const Scene scene = test::random_scene(64, {120, 0.8, -1.8, 1.0, 0.02, 0.95, 1});
    const Camera camera = test::front_camera(8, 4);
    const TracerOptions options = stochastic(3);
    const PreparedGaussians gaussians(scene, options.kernel);
    const AccelerationStructure accel(gaussians, {AccelKind::tlas_tri20, 6, false});
    RenderOptions render{.threads = 1};
    header_ = trace_header(scene, camera, accel, options, render);
    traces::Writer writer(file_.path(), header_);
    result_ = frontend::render(scene, gaussians, accel, camera, options, render, &writer);
    writer.finish();
    const traces::Reader reader(file_.path());
    reader.read(0, group_);
  }
  /// What check_group() says of the group after `change`; "" when it is consistent.
  std::string fault(const std::function<void(traces::RayGroup&)>& change) const {
    traces::RayGroup changed = group_;
    change(changed);
    return grtx::test::error_of([&] { traces::check_group("trace", header_, changed); });
  }
  /// The first ray with an any-hit call, and the place of its event.
  static std::pair<traces::Ray*, traces::Event*> first_call(traces::RayGroup& group) {
    for (traces::Ray& ray : group.rays) {
      for (traces::Event& event : ray.events) {
        if (event.kind() == traces::EventKind::visit_leaf && traces::calls_any_hit(event.outcome())) {
          return {&ray, &event};
        }
      }
    }
    return {};
  }
  traces::testing::TemporaryFile file_{"stochastic"};
  traces::Header header_;
  traces::RayGroup group_;
  RenderResult result_;
};

TEST_F(StochasticTrace, HoldsARoundASampleAndWhatTheShaderLookedAt) {
  EXPECT_EQ(fault([](auto&) {}), "");
  std::uint64_t calls = 0, processed = 0, blended = 0, rounds = 0;
  for (const traces::Ray& ray : group_.rays) {
    EXPECT_TRUE(ray.rounds.size() == 3 || ray.rounds.size() == 1);  // one: it misses the scene
    rounds += ray.rounds.size();
    for (const traces::Event& e : ray.events) {
      calls += e.kind() == traces::EventKind::visit_leaf && traces::calls_any_hit(e.outcome()) ? 1 : 0;
    }
    processed += ray.processed.size();
    for (const traces::Processed& p : ray.processed) blended += p.blended;
  }
  EXPECT_EQ(calls, processed);
  EXPECT_EQ(calls, result_.counters.any_hit_calls());
  EXPECT_EQ(blended, result_.counters.blended);
  EXPECT_EQ(rounds, result_.counters.rounds);
  EXPECT_GT(calls, blended);
}

TEST_F(StochasticTrace, OtherwiseIsRefused) {
  EXPECT_NE(fault([](auto& g) { first_call(g).second->detail = static_cast<std::uint8_t>(traces::LeafOutcome::miss); }),
            "");
  EXPECT_NE(
      fault([](auto& g) { first_call(g).second->detail = static_cast<std::uint8_t>(traces::LeafOutcome::rejected); }),
      "");
  EXPECT_NE(fault([](auto& g) {
              for (traces::Processed& p : first_call(g).first->processed) p.blended = 1;
            }),
            "");
  EXPECT_NE(fault([](auto& g) { first_call(g).first->rounds[0].k_count ^= 1; }), "");
  EXPECT_NE(fault([](auto& g) { first_call(g).first->rounds[0].terminated = true; }), "");
}

}  // namespace
}  // namespace grtx::frontend
