// Layout obb: the table of rotations, what the boxes of a node contain, and that a hit's t lies in the interval of
// every box above it (docs/model/node-image.md).
#include "grtx/frontend/accel/oriented_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <random>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/tracer/node_intersection.h"

namespace grtx::frontend {
namespace {

TEST(Orientations, AreDistinctRotationsAfterTheIdentity) {
  const auto& all = orientations();
  EXPECT_EQ(all[0], (Orientation{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}));
  double likest = 0.0;
  for (unsigned r = 0; r < kOrientations; ++r) {
    for (unsigned i = 0; i < 3; ++i) {
      for (unsigned j = 0; j < 3; ++j) {
        const double dot = glm::dot(glm::dvec3(all[r][i]), glm::dvec3(all[r][j]));
        EXPECT_NEAR(dot, i == j ? 1.0 : 0.0, 2e-3) << r;
        EXPECT_EQ(std::ldexp(all[r][i][static_cast<int>(j)], 10),
                  std::round(std::ldexp(all[r][i][static_cast<int>(j)], 10)));
      }
    }
    // Two boxes are alike when each axis of one lies along an axis of the other: the least of the three best cosines.
    for (unsigned other = 0; other < r; ++other) {
      double least = 1.0;
      for (const glm::vec3& row : all[r]) {
        double best = 0.0;
        for (const glm::vec3& axis : all[other]) {
          best = std::max(best, std::fabs(glm::dot(glm::dvec3(row), glm::dvec3(axis))));
        }
        least = std::min(least, best);
      }
      likest = std::max(likest, least);
    }
  }
  EXPECT_LT(likest, std::cos(0.12));  // no two are closer than 7 degrees
}

// A random rotation is near one of the table.
TEST(Orientations, CoverAllRotations) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  double worst = 1.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const glm::dvec3 a = glm::normalize(glm::dvec3{normal(engine), normal(engine), normal(engine)});
    const glm::dvec3 b = glm::normalize(glm::cross(a, glm::dvec3{normal(engine), normal(engine), normal(engine)}));
    const glm::dvec3 axes[3] = {a, b, glm::cross(a, b)};
    double nearest = 0.0;
    for (const Orientation& rows : orientations()) {
      double least = 1.0;
      for (const glm::vec3& row : rows) {
        double best = 0.0;
        for (const glm::dvec3& axis : axes) best = std::max(best, std::fabs(glm::dot(glm::dvec3(row), axis)));
        least = std::min(least, best);
      }
      nearest = std::max(nearest, least);
    }
    worst = std::min(worst, nearest);
  }
  EXPECT_GT(worst, std::cos(0.35));  // 20 degrees
}

struct Case {
  AccelKind kind;
  unsigned width;
  friend void PrintTo(const Case& c, std::ostream* out) { *out << accel_name(c.kind) << ", width " << c.width; }
};

class OrientedTree : public testing::TestWithParam<Case> {
 protected:
  static test::RandomSceneOptions needles() {
    test::RandomSceneOptions options{.count = 300, .log_scale_mean = -4.5};
    return options;
  }
};

// Every point of a Gaussian's proxy lies in the decoded boxes above its leaf, in the frame of each node.
struct PointWalk {
  const AccelerationStructure& accel;
  const PreparedGaussians& gaussians;
  std::uint64_t oriented = 0, leaves = 0;

  // Points of the leaf, or of all leaves below.
  std::vector<glm::dvec3> visit(std::uint64_t address, NodeKind kind) {
    const NodeImage& image = accel.image();
    std::vector<glm::dvec3> points;
    if (kind != NodeKind::internal) {
      ++leaves;
      const std::uint32_t leaf = image.leaf_index(static_cast<std::uint32_t>(address / image.sizes().unit()));
      return points_of(leaf, kind);
    }
    const DecodedInternal node = image.decode_internal(address);
    oriented += node.orientation != 0 ? 1 : 0;
    const Orientation& rows = orientations()[node.orientation];
    std::uint64_t child = node.child_base;
    for (unsigned i = 0; i < node.child_count; ++i) {
      for (const glm::dvec3& p : visit(child, node.kinds[i])) {
        for (int axis = 0; axis < 3; ++axis) {
          const double at = glm::dot(glm::dvec3(rows[static_cast<std::size_t>(axis)]), p);
          EXPECT_LE(double{node.boxes[i].lower[axis]}, at);
          EXPECT_GE(double{node.boxes[i].upper[axis]}, at);
        }
        points.push_back(p);
      }
      child += image.sizes().bytes(node.kinds[i]);
    }
    return points;
  }
  std::vector<glm::dvec3> points_of(std::uint32_t leaf, NodeKind kind) const {
    const Proxy& proxy = accel.proxy();
    std::vector<glm::dvec3> points;
    if (proxy.is_sphere()) {
      for (unsigned i = 0; i < 40; ++i) {  // on the unit sphere
        const double z = (2.0 * i + 1.0) / 40.0 - 1.0, angle = 2.399963 * i, radius = std::sqrt(1.0 - z * z);
        points.push_back(world(leaf, {radius * std::cos(angle), radius * std::sin(angle), z}));
      }
      return points;
    }
    if (kind == NodeKind::instance) {
      for (const glm::vec3& v : proxy.vertices()) points.push_back(world(leaf, v));
      return points;
    }
    for (const std::uint16_t v : proxy.triangles()[leaf % proxy.faces()]) {
      points.push_back(world(leaf / proxy.faces(), proxy.vertices()[v]));
    }
    return points;
  }
  glm::dvec3 world(std::uint32_t g, const glm::dvec3& unit) const {
    glm::dvec3 p(gaussians.record(g).mean);
    for (int axis = 0; axis < 3; ++axis) p += glm::dvec3(gaussians.half_axis(g, axis)) * unit[axis];
    return p;
  }
};

TEST_P(OrientedTree, BoxesContainTheProxiesBelow) {
  const Scene scene = test::random_scene(12, needles());
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {GetParam().kind, GetParam().width, false, 8, NodeLayout::obb});
  PointWalk walk{accel, gaussians};
  walk.visit(accel.root(), NodeKind::internal);
  EXPECT_EQ(walk.oriented, accel.counts().oriented);
  EXPECT_GT(walk.oriented, accel.counts().internal / 4) << "rotated boxes must be worth something on these scenes";
  EXPECT_EQ(accel.image().decode_internal(accel.root()).orientation, 0u);
  EXPECT_EQ(walk.leaves,
            scene.size() * (is_two_level(GetParam().kind) || accel.proxy().is_sphere() ? 1u : accel.proxy().faces()));
}

// The bound that all pruning rests on, asked of the very test that the tracer runs: a hit's t lies in the interval of
// each box above its leaf, whatever the ray's origin and however nearly parallel to an axis it is.
TEST_P(OrientedTree, AHitLiesInTheIntervalsOfAllBoxesAboveIt) {
  const Scene scene = test::random_scene(13, needles());
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {GetParam().kind, GetParam().width, false, 8, NodeLayout::obb});
  const NodeImage& image = accel.image();
  const NodeTest test_node = node_test(SimdPath::portable, image.layout());
  std::mt19937 engine(3);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * (static_cast<float>(engine() >> 8) / 16777216.0f);
  };
  std::uint64_t hits_seen = 0, rotated_seen = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto target = static_cast<std::uint32_t>(engine() % scene.size());
    const float far = std::ldexp(1.0f, static_cast<int>(engine() % 14) - 1);
    const glm::vec3 origin{far * uniform(-1, 1), far * uniform(-1, 1), far * uniform(-1, 1)};
    glm::vec3 direction = glm::normalize(gaussians.record(target).mean - origin);
    if (trial % 5 == 0) {  // nearly parallel to an axis
      const auto nearly_zero = [&] {
        const float value = uniform(-1, 1);
        return std::ldexp(value, -static_cast<int>(engine() % 24));
      };
      direction = glm::vec3{nearly_zero(), 1.0f, nearly_zero()};
    }
    const glm::vec3 start = trial % 5 == 0 ? gaussians.record(target).mean - direction * far : origin;
    const TraceRay ray(start, direction);
    const auto t_of = [&](std::uint32_t leaf, NodeKind kind) -> std::optional<float> {
      const bool faces = kind == NodeKind::triangle;
      const std::uint32_t g = faces ? leaf / accel.proxy().faces() : leaf;
      const Hit hit = canonical_hit(ray, to_unit_ray(ray, gaussians.record(g)), gaussians, g, accel.proxy(),
                                    SortKey::entry, InsideRule::skip, face_test(SimdPath::portable));
      if (hit.kind != HitKind::hit || (faces && hit.face != leaf % accel.proxy().faces())) return std::nullopt;
      return hit.t;
    };
    const auto visit = [&](const auto& self, std::uint64_t address) -> std::vector<float> {
      const DecodedInternal node = image.decode_internal(address);
      NodeHits boxes;
      test_node(image.node(address), 0, ray.slabs, {}, boxes);
      std::vector<float> all;
      std::uint64_t child = node.child_base;
      for (unsigned i = 0; i < node.child_count; ++i) {
        std::vector<float> below;
        if (node.kinds[i] == NodeKind::internal) {
          below = self(self, child);
        } else if (const auto t = t_of(image.leaf_index(static_cast<std::uint32_t>(child / 64)), node.kinds[i])) {
          below.push_back(*t);
          ++hits_seen;
        }
        for (const float t : below) {
          EXPECT_TRUE((boxes.hit >> i & 1) != 0) << "trial " << trial;
          EXPECT_LE(boxes.enter[i], t) << "trial " << trial;
          EXPECT_GE(boxes.exit[i], t) << "trial " << trial;
          rotated_seen += node.orientation != 0 ? 1 : 0;
          all.push_back(t);
        }
        child += image.sizes().bytes(node.kinds[i]);
      }
      return all;
    };
    visit(visit, accel.root());
  }
  EXPECT_GT(hits_seen, 300u);
  EXPECT_GT(rotated_seen, 300u);
}

INSTANTIATE_TEST_SUITE_P(Structures, OrientedTree,
                         testing::Values(Case{AccelKind::tri20, 6}, Case{AccelKind::tri80, 8},
                                         Case{AccelKind::ellipsoid, 6}, Case{AccelKind::tlas_tri20, 6},
                                         Case{AccelKind::tlas_sphere, 4}));

// Gaussians whose faces' boxes are where hits may be clamped to: the box itself is what must be contained.
TEST(ProxyExtents, HoldTheWholeBoxWhereTheHitFunctionMayClamp) {
  test::RandomSceneOptions options{.count = 50};
  options.log_scale_mean = 3.0;  // larger than the scene
  const Scene scene = test::random_scene(14, options);
  const PreparedGaussians gaussians(scene, true);
  const Proxy proxy(ProxyKind::icosahedron20);
  const ProxyExtents reach(gaussians, proxy);
  unsigned larger = 0;
  for (std::uint32_t g = 0; g < scene.size(); ++g) {
    const Box box = gaussians.face_box(g, proxy, 3);
    FrameExtents extents;
    reach.of_face(g, 3, extents);
    double span = 0.0, tight = 0.0;
    for (unsigned r = 1; r < kOrientations; ++r) {
      const glm::dvec3 row(orientations()[r][0]);
      double corner = 0.0, vertex_low = 1e30, vertex_high = -1e30;
      for (int axis = 0; axis < 3; ++axis)
        corner += std::fabs(row[axis]) * (double{box.upper[axis]} - double{box.lower[axis]});
      for (const std::uint16_t v : proxy.triangles()[3]) {
        const double at = glm::dot(row, glm::dvec3(gaussians.to_world(g, proxy.vertices()[v])));
        vertex_low = std::min(vertex_low, at);
        vertex_high = std::max(vertex_high, at);
      }
      EXPECT_GE(double{extents.upper[r]} - double{extents.lower[r]}, vertex_high - vertex_low);
      span += double{extents.upper[r]} - double{extents.lower[r]} - corner;
      tight += vertex_high - vertex_low - corner;
    }
    if (span >= 0.0 && tight < 0.0) ++larger;
  }
  EXPECT_GT(larger, 25u);
}

}  // namespace
}  // namespace grtx::frontend
