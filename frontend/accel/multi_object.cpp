// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/multi_object.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <sstream>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/stopwatch.h"
#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/accel/shared_blas.h"
#include "grtx/frontend/accel/tree_packer.h"

namespace grtx::frontend {
namespace {

// World boxes of objects are widened by this share of their largest coordinate: 64 ulp, which covers that corners and
// rays are both transformed in double and rounded to fp32 once.
constexpr float kBoxMargin = 1.0f / (1 << 18);

// Keeps the areas of boxes, which the builder compares, within fp32.
constexpr float kLargestCoordinate = 1e18f;

// Rotation times uniform scale; columns are the object's axes in the world.
glm::dmat3 object_to_world(const Placement& placement) { return glm::mat3_cast(placement.rotate) * placement.scale; }

// The object space's origin in world coordinates: scenes are recentred by their offset.
glm::dvec3 world_position(const Placement& placement, const Scene& scene) {
  return object_to_world(placement) * scene.offset + placement.translate;
}

// Writes the leaf of Gaussian g in its object's TLAS.
void write_gaussian(NodeImage& image, std::uint64_t address, const PreparedGaussians& gaussians, std::uint32_t g,
                    std::uint64_t blas_header, std::uint64_t blas_root) {
  const GaussianRecord& record = gaussians.record(g);
  const glm::vec3 columns[3] = {gaussians.to_world(g, {1, 0, 0}) - record.mean,
                                gaussians.to_world(g, {0, 1, 0}) - record.mean,
                                gaussians.to_world(g, {0, 0, 1}) - record.mean};
  image.write_instance(address, g, blas_header, blas_root, record.to_unit, columns, record.mean);
}

}  // namespace

TraceRay PlacedObject::to_object_ray(const TraceRay& ray) const {
  return TraceRay(glm::vec3(to_object * (glm::dvec3(ray.origin) - position)),
                  glm::vec3(to_object * glm::dvec3(ray.direction)));
}

MultiObjectWorld::MultiObjectWorld(std::vector<Scene> scenes, const std::vector<Placement>& placements,
                                   const AccelOptions& options, Kernel kernel)
    : options_(options), proxy_(proxy_of(options.kind)), patches_(proxy_), placements_(placements) {
  if (!is_two_level(options.kind)) {
    throw Error("--accel", accel_name(options.kind), "cannot hold several objects: use a tlas-* structure");
  }
  if (is_quantised(options.layout)) {
    throw Error("--layout", std::string(name_of(options.layout)), "holds one scene: objects need another layout");
  }
  if (placements.empty()) throw Error("objects", "", "must be at least one");
  const auto start = std::chrono::steady_clock::now();
  take_objects(std::move(scenes), kernel);
  build_structure();
  update();
  build_seconds_ = seconds_since(start);
}

void MultiObjectWorld::take_objects(std::vector<Scene> scenes, Kernel kernel) {
  for (Scene& scene : scenes) {
    objects_.push_back(std::make_unique<SharedObject>(std::move(scene), kernel));
    const Scene& own = objects_.back()->scene;
    objects_.back()->first_record = static_cast<std::uint32_t>(records_);
    records_ += own.size();
    sh_degree_ = std::max(sh_degree_, own.sh_degree);
  }
  for (const Placement& placement : placements_) {
    if (placement.object >= objects_.size()) throw Error("objects", "", "placement of an object that is not there");
    const Scene& scene = objects_[placement.object]->scene;
    gaussians_ += scene.size();
    offset_ += world_position(placement, scene) / static_cast<double>(placements_.size());
  }
  if (std::max(gaussians_, records_) > (std::uint64_t{1} << 31)) {
    throw Error("objects", "", "hold more than 2^31 Gaussians");
  }
}

void MultiObjectWorld::build_structure() {
  const unsigned width = options_.width;
  const traces::NodeSizes sizes(options_.layout, width);
  const SharedBlas blas(proxy_, patches_, options_.layout, width);
  std::vector<Tree> tlases;
  const std::uint64_t n = placements_.size();
  scene_tlas_bytes_ = sizes.header_bytes() + std::max<std::uint64_t>(1, n - 1) * sizes.bytes(NodeKind::internal) +
                      n * sizes.bytes(NodeKind::instance);
  std::uint64_t end = scene_tlas_bytes_;
  for (const auto& object : objects_) {
    tlases.push_back(build_tree(
        object->scene.size(),
        [&](std::size_t i) {
          return object->gaussians.instance_box(static_cast<std::uint32_t>(i), proxy_, options_.corner_bounds);
        },
        width));
    object->bounds = tlases.back().bounds;
    end += packed_bytes(tlases.back(), NodeKind::instance, sizes);
  }
  const std::uint64_t blas_header = end;
  blas_root_ = blas_header + sizes.header_bytes();
  image_ = std::make_unique<NodeImage>(width, end + blas.bytes(), options_.box_bits, options_.layout);
  image_->allocate(scene_tlas_bytes_);
  for (std::size_t i = 0; i < tlases.size(); ++i) {
    SharedObject& object = *objects_[i];
    TreePacker packer(*image_, tlases[i], NodeKind::instance,
                      [&](NodeImage& image, std::uint64_t address, std::uint32_t g) {
                        write_gaussian(image, address, object.gaussians, g, blas_header, blas_root_);
                      });
    object.root = packer.pack(packed_bytes(tlases[i], NodeKind::instance, sizes));
    object.header = object.root - sizes.header_bytes();
  }
  blas.pack(*image_);
  assert(image_->allocated() == image_->size());
}

void MultiObjectWorld::move(const std::vector<Placement>& placements) {
  const bool same = std::equal(placements.begin(), placements.end(), placements_.begin(), placements_.end(),
                               [](const Placement& a, const Placement& b) { return a.object == b.object; });
  if (!same) throw Error("objects", "", "only move: their number and files stay");
  placements_ = placements;
  update();
}

void MultiObjectWorld::update() {
  const auto start = std::chrono::steady_clock::now();
  place();
  write_scene_tlas();
  update_seconds_ = seconds_since(start);
}

void MultiObjectWorld::place() {
  placed_.clear();
  std::uint32_t next = 0;
  for (const Placement& placement : placements_) {
    PlacedObject placed;
    placed.object = objects_[placement.object].get();
    placed.first_gaussian = next;
    next += static_cast<std::uint32_t>(placed.object->scene.size());
    const glm::dmat3 out = object_to_world(placement);
    placed.to_object = glm::transpose(out) * (1.0 / (placement.scale * placement.scale));
    placed.position = world_position(placement, placed.object->scene) - offset_;
    const Box& bounds = placed.object->bounds;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p((corner & 1) != 0 ? bounds.upper.x : bounds.lower.x,
                         (corner & 2) != 0 ? bounds.upper.y : bounds.lower.y,
                         (corner & 4) != 0 ? bounds.upper.z : bounds.lower.z);
      placed.box.extend(glm::vec3(out * p + placed.position));
    }
    if (!(placed.box.largest_coordinate() < kLargestCoordinate)) {
      throw Error("object " + std::to_string(placed_.size()), "",
                  "its place is beyond what fp32 boxes can hold (1e18)");
    }
    placed.box.inflate(placed.box.largest_coordinate() * kBoxMargin);
    placed_.push_back(placed);
  }
}

void MultiObjectWorld::write_scene_tlas() {
  const Tree tree = build_tree(
      placed_.size(), [&](std::size_t i) { return placed_[i].box; }, options_.width);
  update_bytes_ = packed_bytes(tree, NodeKind::instance, image_->sizes());
  assert(update_bytes_ <= scene_tlas_bytes_);
  scene_leaves_.resize(placed_.size());
  TreePacker(*image_, tree, NodeKind::instance, [&](NodeImage& image, std::uint64_t address, std::uint32_t index) {
    const PlacedObject& placed = placed_[index];
    scene_leaves_[index] = {address, placements_[index].object};
    const glm::dmat3 rows = glm::transpose(placed.to_object);
    const glm::dmat3 out = object_to_world(placements_[index]);
    const glm::vec3 to_object[3] = {glm::vec3(rows[0]), glm::vec3(rows[1]), glm::vec3(rows[2])};
    const glm::vec3 to_world[3] = {glm::vec3(out[0]), glm::vec3(out[1]), glm::vec3(out[2])};
    image.write_instance(address, index, placed.object->header, placed.object->root, to_object, to_world,
                         glm::vec3(placed.position));
  }).pack_at(0);
  std::sort(scene_leaves_.begin(), scene_leaves_.end(),
            [](const traces::SceneLeaf& a, const traces::SceneLeaf& b) { return a.address < b.address; });
}

const PlacedObject& MultiObjectWorld::owner(std::uint32_t id) const {
  const auto after = std::upper_bound(placed_.begin(), placed_.end(), id,
                                      [](std::uint32_t i, const PlacedObject& p) { return i < p.first_gaussian; });
  return *(after - 1);
}

std::string MultiObjectWorld::hash() const {
  std::ostringstream text;
  text << std::hexfloat;  // exact to the bit
  for (const Placement& p : placements_) {
    text << objects_[p.object]->scene.hash;
    for (const double value :
         {p.translate.x, p.translate.y, p.translate.z, p.rotate.w, p.rotate.x, p.rotate.y, p.rotate.z, p.scale}) {
      text << ' ' << value;
    }
    text << '\n';
  }
  return hex(xxh3(text.str()));
}

Scene flatten(const MultiObjectWorld& world, const std::vector<Placement>& placements) {
  Scene flat;
  flat.name = "flattened";
  flat.hash = world.hash();
  flat.offset = world.offset();
  for (const auto& object : world.objects()) flat.sh_degree = std::max(flat.sh_degree, object->scene.sh_degree);
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const Placement& placement = placements[i];
    const Scene& scene = world.objects()[placement.object]->scene;
    const bool turned = std::fabs(placement.rotate.w) < 1.0;
    if (scene.sh_degree > 0 && turned) {
      throw Error(scene.name, "object " + std::to_string(i), "SH of degree > 0 cannot be rotated into one scene");
    }
    const glm::dmat3 out = object_to_world(placement);
    const glm::dvec3 position = world_position(placement, scene) - world.offset();
    for (std::size_t g = 0; g < scene.size(); ++g) {
      flat.mean.push_back(glm::vec3(out * glm::dvec3(scene.mean[g]) + position));
      flat.scale.push_back(scene.scale[g] * static_cast<float>(placement.scale));
      flat.rotation.push_back(glm::quat(glm::normalize(placement.rotate * glm::dquat(scene.rotation[g]))));
      flat.opacity.push_back(scene.opacity[g]);
      const std::size_t stride = std::size_t{3} * scene.sh_coefficients();
      const auto sh = scene.sh.begin() + static_cast<std::ptrdiff_t>(g * stride);
      flat.sh.insert(flat.sh.end(), sh, sh + static_cast<std::ptrdiff_t>(stride));
      flat.sh.resize(flat.mean.size() * 3 * flat.sh_coefficients());
    }
  }
  return flat;
}

}  // namespace grtx::frontend
