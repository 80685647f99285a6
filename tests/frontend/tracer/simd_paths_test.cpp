// SPDX-License-Identifier: Apache-2.0
// Every path of vector instructions gives the same bits: node tests, face tests and whole renders.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <random>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/error.h"
#include "grtx/frontend/gaussian/face_intersection.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/tracer/node_intersection.h"

namespace grtx::frontend {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Numbers of every kind that a ray or a node may hold, and some that none should.
class Numbers {
 public:
  float plain(float low, float high) { return low + (high - low) * (static_cast<float>(engine_() >> 8) / 16777216.0f); }
  std::uint32_t bits() { return static_cast<std::uint32_t>(engine_()); }
  float any() {
    static constexpr float kOdd[] = {0.0f, -0.0f, 1e-42f, -1e-42f, 3e38f, -3e38f, kInfinity, -kInfinity, kNan, 1.0f};
    const std::uint32_t choice = bits() % 16;
    if (choice < 3) return kOdd[bits() % std::size(kOdd)];
    if (choice == 3) return std::bit_cast<float>(bits());
    return plain(-2.0f, 2.0f);
  }

 private:
  std::mt19937 engine_{20};
};

/// NaNs count as equal; otherwise the bits decide.
bool same(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (std::isnan(a) && std::isnan(b));
}

TEST(SimdPaths, HoldThePortablePathAndNameEach) {
  EXPECT_EQ(available_simd_paths().front(), SimdPath::portable);
  EXPECT_STREQ(simd_path_name(SimdPath::portable), "portable");
  EXPECT_STREQ(simd_path_name(SimdPath::avx2), "avx2");
  EXPECT_STREQ(simd_path_name(SimdPath::avx512), "avx512");
}

TEST(SimdPaths, ALimitLeavesWhatIsNotAboveIt) {
  using Paths = std::vector<SimdPath>;
  const Paths all{SimdPath::portable, SimdPath::avx2, SimdPath::avx512};
  EXPECT_EQ(limited_simd_paths(all, ""), all);
  EXPECT_EQ(limited_simd_paths(all, "avx512"), all);
  EXPECT_EQ(limited_simd_paths(all, "avx2"), (Paths{SimdPath::portable, SimdPath::avx2}));
  EXPECT_EQ(limited_simd_paths(all, "portable"), Paths{SimdPath::portable});
  // A host that lacks the limit does its best below.
  EXPECT_EQ(limited_simd_paths({SimdPath::portable}, "avx512"), Paths{SimdPath::portable});
  EXPECT_EQ(limited_simd_paths({SimdPath::portable, SimdPath::avx2}, "avx512"),
            (Paths{SimdPath::portable, SimdPath::avx2}));
  EXPECT_THAT([&] { limited_simd_paths(all, "AVX2"); },
              ::testing::ThrowsMessage<Error>(::testing::StrEq("GRTX_SIMD: AVX2: must be portable, avx2 or avx512")));
}

TEST(SimdPaths, NodeTestsAgreeOnRandomBytesAndRays) {
  const InternalLayout packed = internal_layout(traces::NodeSizes(traces::NodeLayout::compressed, 8));
  for (const InternalLayout& layout : {internal_layout(6), internal_layout(8), packed}) {
    const unsigned slots = layout.slots;
    Numbers numbers;
    const NodeTest expected_test = node_test(SimdPath::portable, layout);
    unsigned hits_seen = 0;
    for (int trial = 0; trial < 100000; ++trial) {
      alignas(64) std::uint8_t node[128];
      for (std::uint8_t& byte : node) byte = static_cast<std::uint8_t>(numbers.bits() >> 13);
      for (int axis = 0; axis < 3; ++axis) {
        const float origin = trial % 4 == 0 ? numbers.any() : numbers.plain(-1.0f, 0.0f);
        std::memcpy(node + 4 * axis, &origin, 4);
        if (trial % 4 != 0) node[18 + axis] = static_cast<std::uint8_t>(static_cast<std::int8_t>(numbers.bits() % 4));
      }
      SlabRay ray(glm::vec3(numbers.plain(-3, 3), numbers.plain(-3, 3), numbers.plain(-3, 3)),
                  glm::vec3(numbers.plain(-1, 1), numbers.plain(-1, 1), numbers.plain(-1, 1)));
      if (trial % 3 == 0) {
        ray = SlabRay(glm::vec3(numbers.any(), numbers.any(), numbers.any()),
                      glm::vec3(numbers.any(), numbers.any(), numbers.any()));
      }
      if (trial % 7 == 0) ray.inverse.y = numbers.any();
      const NodeQuery query{trial % 2 == 0 ? 0.0f : numbers.any(), trial % 5 == 0 ? 0.0f : numbers.any()};
      NodeHits expected;
      expected_test(node, 1000, ray, query, expected);
      hits_seen += expected.count;
      for (const SimdPath path : available_simd_paths()) {
        NodeHits hits;
        node_test(path, layout)(node, 1000, ray, query, hits);
        SCOPED_TRACE(std::string(simd_path_name(path)) + " trial " + std::to_string(trial));
        ASSERT_EQ(hits.hit, expected.hit);
        ASSERT_EQ(hits.count, expected.count);
        ASSERT_EQ(hits.info.valid, expected.info.valid);
        ASSERT_EQ(hits.info.wide, expected.info.wide);
        ASSERT_EQ(hits.info.child_base, expected.info.child_base);
        for (unsigned slot = 0; slot < slots; ++slot) {
          ASSERT_TRUE(same(hits.enter[slot], expected.enter[slot])) << slot;
          ASSERT_TRUE(same(hits.exit[slot], expected.exit[slot])) << slot;
          if ((expected.hit >> slot & 1) != 0) {
            ASSERT_EQ(hits.rank[slot], expected.rank[slot]) << slot;
          }
        }
      }
    }
    EXPECT_GT(hits_seen, 10000u) << "rays and nodes must meet";
  }
}

TEST(SimdPaths, NodesOfTheLastBytesAreReadWithinTheNode) {
  // A six-slot node and a packed one end with their 64 bytes: what lies behind must not matter.
  Numbers numbers;
  for (const InternalLayout& layout :
       {internal_layout(6), internal_layout(traces::NodeSizes(traces::NodeLayout::compressed, 8))}) {
    for (const SimdPath path : available_simd_paths()) {
      alignas(64) std::uint8_t nodes[2][128] = {};
      for (unsigned i = 0; i < 64; ++i) nodes[0][i] = nodes[1][i] = static_cast<std::uint8_t>(numbers.bits());
      for (unsigned i = 64; i < 128; ++i) nodes[1][i] = 0xFF;
      const SlabRay ray(glm::vec3(0.1f, 0.2f, -3.0f), glm::vec3(0.1f, -0.2f, 1.0f));
      NodeHits hits[2];
      for (int i = 0; i < 2; ++i) node_test(path, layout)(nodes[i], 0, ray, {}, hits[i]);
      for (unsigned slot = 0; slot < layout.slots; ++slot) {
        EXPECT_TRUE(same(hits[0].enter[slot], hits[1].enter[slot]));
        EXPECT_TRUE(same(hits[0].exit[slot], hits[1].exit[slot]));
      }
    }
  }
}

TEST(SimdPaths, FaceTestsAgreeOnRandomRays) {
  for (const ProxyKind kind : {ProxyKind::icosahedron20, ProxyKind::icosphere80}) {
    const Proxy proxy(kind);
    Numbers numbers;
    unsigned hits_seen = 0;
    for (int trial = 0; trial < 50000; ++trial) {
      const bool odd = trial % 3 == 0;
      const auto number = [&] { return odd ? numbers.any() : numbers.plain(-1.0f, 1.0f); };
      glm::vec3 peak(number(), number(), number());
      glm::vec3 direction(number(), number(), number());
      if (trial % 11 == 0) direction = glm::vec3(0.0f, 0.0f, 1.0f);  // parallel to some faces
      if (trial % 13 == 0) peak = glm::vec3(0.0f);                   // edges and corners are met exactly
      std::uint32_t entry = 77, exit = 78;
      const Interval expected = face_test(SimdPath::portable)(peak, direction, proxy.face_slabs(), entry, exit);
      if (!expected.empty()) ++hits_seen;
      for (const SimdPath path : available_simd_paths()) {
        std::uint32_t got_entry = 77, got_exit = 78;
        const Interval got = face_test(path)(peak, direction, proxy.face_slabs(), got_entry, got_exit);
        ASSERT_EQ(got.empty(), expected.empty()) << trial;
        if (expected.empty()) continue;  // then faces mean nothing
        ASSERT_TRUE(same(got.enter, expected.enter)) << trial;
        ASSERT_TRUE(same(got.exit, expected.exit)) << trial;
        ASSERT_EQ(got_entry, entry) << trial;
        ASSERT_EQ(got_exit, exit) << trial;
      }
    }
    EXPECT_GT(hits_seen, 5000u);
  }
}

TEST(SimdPaths, RendersAgree) {
  const Scene scene = test::random_scene(5, {400, 0.8, -2.0, 1.0, 0.02, 0.95, 2});
  const Camera camera = test::front_camera(24, 24);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri80, AccelKind::tlas_sphere}) {
    for (const unsigned width : {6u, 8u}) {
      TracerOptions options;
      options.checkpoint = width == 8;
      options.simd = SimdPath::portable;
      const RenderResult expected = test::trace_scene(scene, camera, kind, options, width);
      for (const SimdPath path : available_simd_paths()) {
        options.simd = path;
        const RenderResult got = test::trace_scene(scene, camera, kind, options, width);
        EXPECT_EQ(got.image.pixels, expected.image.pixels) << simd_path_name(path);
        EXPECT_EQ(got.sequences, expected.sequences) << simd_path_name(path);
        EXPECT_EQ(got.counters.visits(), expected.counters.visits()) << simd_path_name(path);
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
