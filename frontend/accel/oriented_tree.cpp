#include "grtx/frontend/accel/oriented_tree.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <unordered_map>
#include <vector>

#include "grtx/frontend/gaussian/float4.h"

namespace grtx::frontend {
namespace {

constexpr unsigned kDirections = FrameExtents::kDirections;
constexpr unsigned kLanes = 4;
// A rotated box must be this much smaller than the one of the world's axes.
constexpr double kWorthwhile = 0.97;
// Coordinates beyond it stay in the world's axes: codes of rotated boxes might not reach.
constexpr float kLargestCoordinate = 1e36f;
constexpr std::uint32_t kSubtreeNodes = 2048;  // nodes that one thread orients in one go, at most
constexpr float kHalfUlp = 1.0f / (1 << 24);
constexpr std::size_t kMostVertices = 42;  // of a proxy: the icosphere of 80 faces

Float4 load(const float* values) {
  Float4 result;
  std::memcpy(&result, values, sizeof result);
  return result;
}

// The axes of all rotations, component by component, in the order of FrameExtents.
struct Directions {
  alignas(16) std::array<float, kDirections> x, y, z;
};

const Directions& directions() {
  static const Directions all = [] {
    Directions d;
    for (unsigned r = 0; r < kOrientations; ++r) {
      for (unsigned axis = 0; axis < 3; ++axis) {
        const glm::vec3& row = orientations()[r][axis];
        d.x[axis * kOrientations + r] = row.x;
        d.y[axis * kOrientations + r] = row.y;
        d.z[axis * kOrientations + r] = row.z;
      }
    }
    return d;
  }();
  return all;
}

double half_area(const Box& box) {
  const double x = double{box.upper.x} - double{box.lower.x}, y = double{box.upper.y} - double{box.lower.y},
               z = double{box.upper.z} - double{box.lower.z};
  return x * y + (y + x) * z;
}

class TreeOrienter {
 public:
  TreeOrienter(const Tree& tree, const ExtentsOf& extents_of) : root_(tree.root), extents_of_(extents_of) {}

  std::uint64_t orient() {
    collect(*root_);
    results_.resize(subtrees_.size());
    tbb::parallel_for(std::size_t{0}, subtrees_.size(),
                      [&](std::size_t i) { visit(*subtrees_[i], 0, arenas_.local(), results_[i]); });
    for (std::size_t i = 0; i < subtrees_.size(); ++i) done_.emplace(subtrees_[i], i);
    FrameExtents all;
    visit(*root_, 0, arenas_.local(), all);
    return oriented_.load();
  }

 private:
  using Level = std::array<FrameExtents, traces::kMaxWidth>;
  using Arena = std::deque<Level>;  // a level of the tree each: what is in use stays where it is

  void collect(const TreeNode& node) {
    for (unsigned i = 0; i < node.child_count; ++i) {
      const TreeChild& child = node.children[i];
      if (child.leaf()) continue;
      if (child.node().internals <= kSubtreeNodes) {
        subtrees_.push_back(&child.node());
      } else {
        collect(child.node());
      }
    }
  }

  // extents: of all below the node.
  void visit(const TreeNode& node, std::size_t depth, Arena& arena, FrameExtents& extents) {
    if (depth == arena.size()) arena.emplace_back();
    Level& level = arena[depth];
    for (unsigned i = 0; i < node.child_count; ++i) {
      const TreeChild& child = node.children[i];
      if (child.leaf()) {
        extents_of_(child.primitive(), level[i]);
      } else if (const auto found = done_.find(&child.node()); found != done_.end()) {
        level[i] = results_[found->second];
      } else {
        visit(child.node(), depth + 1, arena, level[i]);
      }
    }
    if (&node != root_) choose(node, level);
    if (node.child_count == 0) return;
    extents = level[0];
    for (unsigned i = 1; i < node.child_count; ++i) extents.extend(level[i]);
  }

  void choose(const TreeNode& node, const Level& level) {
    float area[kOrientations] = {};
    for (unsigned i = 0; i < node.child_count; ++i) {
      for (unsigned r = 0; r < kOrientations; r += kLanes) {
        Float4 extent[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
          const unsigned at = axis * kOrientations + r;
          extent[axis] = load(&level[i].upper[at]) - load(&level[i].lower[at]);
        }
        store(area + r, 0, load(area + r) + extent[0] * extent[1] + (extent[0] + extent[1]) * extent[2]);
      }
    }
    const auto best = static_cast<unsigned>(std::min_element(area + 1, area + kOrientations) - area);
    double now = 0.0;
    for (unsigned i = 0; i < node.child_count; ++i) now += half_area(node.children[i].box);
    if (!(double{area[best]} < kWorthwhile * now)) return;
    Box boxes[traces::kMaxWidth];
    for (unsigned i = 0; i < node.child_count; ++i) {
      boxes[i] = level[i].box(best);
      if (!(boxes[i].largest_coordinate() < kLargestCoordinate)) return;
    }
    // The tree was allocated as one that changes; who built it hands it on as read only.
    TreeNode& changed = const_cast<TreeNode&>(node);
    changed.orientation = static_cast<std::uint8_t>(best);
    for (unsigned i = 0; i < node.child_count; ++i) changed.children[i].box = boxes[i];
    oriented_.fetch_add(1, std::memory_order_relaxed);
  }

  const TreeNode* const root_;
  const ExtentsOf& extents_of_;
  std::vector<const TreeNode*> subtrees_;
  std::vector<FrameExtents> results_;
  std::unordered_map<const TreeNode*, std::size_t> done_;
  tbb::enumerable_thread_specific<Arena> arenas_;
  std::atomic<std::uint64_t> oriented_{0};
};

void widen(FrameExtents& extents, float margin) {
  for (unsigned i = 0; i < kDirections; i += kLanes) {
    store(&extents.lower[i], 0, load(&extents.lower[i]) - margin);
    store(&extents.upper[i], 0, load(&extents.upper[i]) + margin);
  }
}

void extents_of_points(const glm::vec3* points, unsigned count, FrameExtents& extents) {
  const Directions& d = directions();
  for (unsigned i = 0; i < kDirections; i += kLanes) {
    const Float4 x = load(&d.x[i]), y = load(&d.y[i]), z = load(&d.z[i]);
    Float4 lower = (x * points[0].x + y * points[0].y) + z * points[0].z, upper = lower;
    for (unsigned p = 1; p < count; ++p) {
      const Float4 at = (x * points[p].x + y * points[p].y) + z * points[p].z;
      lower = min(at, lower);
      upper = max(at, upper);
    }
    store(&extents.lower[i], 0, lower);
    store(&extents.upper[i], 0, upper);
  }
}

void extents_of_ellipsoid(const glm::vec3& mean, const glm::vec3 (&columns)[3], FrameExtents& extents) {
  const Directions& d = directions();
  for (unsigned i = 0; i < kDirections; ++i) {
    const float at = (d.x[i] * mean.x + d.y[i] * mean.y) + d.z[i] * mean.z;
    float squares = 0.0f;
    for (const glm::vec3& column : columns) {
      const float along = (d.x[i] * column.x + d.y[i] * column.y) + d.z[i] * column.z;
      squares += along * along;
    }
    const float half = std::sqrt(squares);
    extents.lower[i] = at - half;
    extents.upper[i] = at + half;
  }
}

void extents_of_box(const Box& box, FrameExtents& extents) {
  glm::vec3 corners[8];
  for (unsigned i = 0; i < 8; ++i) {
    corners[i] = {(i & 1) != 0 ? box.upper.x : box.lower.x, (i & 2) != 0 ? box.upper.y : box.lower.y,
                  (i & 4) != 0 ? box.upper.z : box.lower.z};
  }
  extents_of_points(corners, 8, extents);
}

float length_of(const glm::vec3& v) { return std::sqrt((v.x * v.x + v.y * v.y) + v.z * v.z); }

// A Gaussian's part of the bounds in docs/model/node-image.md.
struct Reach {
  glm::vec3 columns[3];  // of unit space to world differences
  float mean;            // distance from the origin
  float radius;          // of a sphere around the proxy
  float error;           // of a hit, in half ulps of the radius

  Reach(const PreparedGaussians& gaussians, const Proxy& proxy, std::uint32_t g) {
    float longest = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      columns[axis] = gaussians.half_axis(g, axis);
      longest = std::max(longest, length_of(columns[axis]));
    }
    mean = length_of(gaussians.record(g).mean);
    radius = longest * std::sqrt(proxy.circumscribed_radius2());
    error = proxy.is_sphere() ? 32.0f : proxy.faces() == 20 ? 40.0f : 64.0f;
  }
  /// By which the hit function may err; see there.
  float hit_error() const { return kHalfUlp * (5.0f * mean + error * radius); }
  /// By which the boxes are widened.
  float margin() const { return kHalfUlp * (16.0f * mean + 128.0f * radius); }
};

}  // namespace

Box FrameExtents::box(unsigned orientation) const {
  Box box;
  for (unsigned axis = 0; axis < 3; ++axis) {
    box.lower[static_cast<int>(axis)] = lower[axis * kOrientations + orientation];
    box.upper[static_cast<int>(axis)] = upper[axis * kOrientations + orientation];
  }
  return box;
}

void FrameExtents::extend(const FrameExtents& other) {
  for (unsigned i = 0; i < kDirections; i += kLanes) {
    store(&lower[i], 0, min(load(&other.lower[i]), load(&lower[i])));
    store(&upper[i], 0, max(load(&other.upper[i]), load(&upper[i])));
  }
}

std::uint64_t orient_tree(const Tree& tree, const ExtentsOf& extents_of) {
  return TreeOrienter(tree, extents_of).orient();
}

void ProxyExtents::of_face(std::uint32_t g, unsigned face, FrameExtents& extents) const {
  if (proxy_.is_sphere()) return of_proxy(g, extents);
  glm::vec3 corners[3];
  Box box;
  for (unsigned i = 0; i < 3; ++i) {
    corners[i] = gaussians_.to_world(g, proxy_.vertices()[proxy_.triangles()[face][i]]);
    box.extend(corners[i]);
  }
  const Reach reach(gaussians_, proxy_, g);
  if (reach.hit_error() <= gaussians_.margin_of(box)) {
    extents_of_points(corners, 3, extents);
  } else {
    extents_of_box(gaussians_.face_box(g, proxy_, face), extents);
  }
  widen(extents, reach.margin());
}

void ProxyExtents::of_proxy(std::uint32_t g, FrameExtents& extents) const {
  const Reach reach(gaussians_, proxy_, g);
  float least = std::numeric_limits<float>::infinity();
  std::array<glm::vec3, kMostVertices> corners;
  unsigned count = 0;
  if (proxy_.is_sphere()) {
    least = gaussians_.margin_of(Box{gaussians_.record(g).mean, gaussians_.record(g).mean});
  } else {
    for (const glm::vec3& v : proxy_.vertices()) corners[count++] = gaussians_.to_world(g, v);
    for (const auto& triangle : proxy_.triangles()) {
      Box box;
      for (const std::uint16_t v : triangle) box.extend(corners[v]);
      least = std::min(least, gaussians_.margin_of(box));
    }
  }
  if (reach.hit_error() > least) {
    extents_of_box(gaussians_.instance_box(g, proxy_, false), extents);
  } else if (proxy_.is_sphere()) {
    extents_of_ellipsoid(gaussians_.record(g).mean, reach.columns, extents);
  } else {
    extents_of_points(corners.data(), count, extents);
  }
  widen(extents, reach.margin());
}

std::uint64_t orient_instances(const Tree& tlas, const PreparedGaussians& gaussians, const Proxy& proxy) {
  const ProxyExtents reach(gaussians, proxy);
  return orient_tree(tlas, [&](std::uint32_t g, FrameExtents& extents) { reach.of_proxy(g, extents); });
}

}  // namespace grtx::frontend
