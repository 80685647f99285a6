// What a user would write with Embree's own BVHs: a multi-round k-buffer tracer over user geometry, a triangle mesh, or
// instances, with the hits collected in Embree's callbacks. Same hits, order and blending rules as the project's
// tracer; nothing of its structures or traversal.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::bench {

inline constexpr unsigned kMostEntries = 64;

/// The k nearest hits beyond the last round's farthest, by (t, id), each Gaussian once.
class NearestHits {
 public:
  struct Entry {
    float t;
    std::uint32_t id;
    bool operator<(const Entry& o) const { return t < o.t || (t == o.t && id < o.id); }
    bool operator==(const Entry&) const = default;
  };

  void begin_ray(unsigned k) {
    k_ = k;
    last_ = {-1.0f, 0};
    count_ = 0;
  }
  void begin_round() {
    if (count_ > 0) last_ = entries_[count_ - 1];
    count_ = 0;
  }
  bool full() const { return count_ == k_; }
  unsigned size() const { return count_; }
  const Entry& operator[](unsigned i) const { return entries_[i]; }
  float nearest_new() const { return std::max(0.0f, std::nextafter(last_.t, 0.0f)); }
  /// True when the buffer is full afterwards: nothing beyond its last entry is wanted.
  bool insert(Entry hit) {
    if (!(last_ < hit)) return full();
    unsigned at = count_;
    while (at > 0 && hit < entries_[at - 1]) --at;
    if (at > 0 && entries_[at - 1] == hit) return full();
    if (at == k_) return true;
    if (count_ < k_) ++count_;
    for (unsigned i = count_ - 1; i > at; --i) entries_[i] = entries_[i - 1];
    entries_[at] = hit;
    return full();
  }

 private:
  unsigned k_ = 0;
  unsigned count_ = 0;
  Entry last_{-1.0f, 0};
  std::array<Entry, kMostEntries> entries_{};
};

enum class Peer : std::uint8_t { user_ellipsoid, mesh, mesh_robust, instanced_mesh, instanced_sphere };

inline const std::vector<std::pair<Peer, const char*>>& peers() {
  static const std::vector<std::pair<Peer, const char*>> all = {
      {Peer::user_ellipsoid, "user-ellipsoid"},     {Peer::mesh, "mesh20"},
      {Peer::mesh_robust, "mesh20-robust"},         {Peer::instanced_mesh, "instanced-mesh20"},
      {Peer::instanced_sphere, "instanced-sphere"},
  };
  return all;
}

inline bool has_triangles(Peer peer) {
  return peer == Peer::mesh || peer == Peer::mesh_robust || peer == Peer::instanced_mesh;
}

class EmbreePeer {
 public:
  EmbreePeer(Peer peer, const frontend::Scene& scene, const frontend::PreparedGaussians& gaussians)
      : peer_(peer),
        scene_(scene),
        gaussians_(gaussians),
        proxy_(has_triangles(peer) ? frontend::ProxyKind::icosahedron20 : frontend::ProxyKind::sphere),
        device_(rtcNewDevice("threads=2,set_affinity=0")),
        world_(rtcNewScene(device_)) {
    rtcSetSceneFlags(
        world_, static_cast<RTCSceneFlags>(
                    kFilterFlag | (peer == Peer::mesh || peer == Peer::instanced_mesh || peer == Peer::instanced_sphere
                                       ? RTC_SCENE_FLAG_NONE
                                       : RTC_SCENE_FLAG_ROBUST)));
    rtcSetSceneBuildQuality(world_, RTC_BUILD_QUALITY_HIGH);
    switch (peer) {
      case Peer::user_ellipsoid: {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(scene.size()));
        rtcSetGeometryUserData(geometry, this);
        rtcSetGeometryBoundsFunction(geometry, &bounds_of_ellipsoid, this);
        rtcSetGeometryIntersectFunction(geometry, &intersect_ellipsoid);
        attach(world_, geometry);
        break;
      }
      case Peer::mesh:
      case Peer::mesh_robust:
        attach(world_, mesh());
        break;
      case Peer::instanced_mesh:
      case Peer::instanced_sphere:
        add_instances();
        break;
    }
    rtcCommitScene(world_);
    if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE) {
      throw std::runtime_error("Embree error " + std::to_string(static_cast<int>(error)));
    }
  }
  EmbreePeer(const EmbreePeer&) = delete;
  EmbreePeer& operator=(const EmbreePeer&) = delete;
  ~EmbreePeer() {
    rtcReleaseScene(world_);
    if (shared_ != nullptr) rtcReleaseScene(shared_);
    rtcReleaseDevice(device_);
  }

  /// One thread, in 8x4 tiles. ert: transmittance threshold.
  frontend::Image render(const frontend::Camera& camera, unsigned k, float ert) const {
    frontend::Image image(camera.width, camera.height);
    const glm::vec3 origin(camera.position - scene_.offset);
    for (const auto& tile : frontend::map_pixels(camera.width, camera.height, false)) {
      for (const std::uint32_t pixel : tile) {
        const glm::vec3 direction(camera.direction(pixel % camera.width, pixel / camera.width));
        if (direction != glm::vec3(0.0f)) image.pixels[pixel] = trace(origin, direction, k, ert);
      }
    }
    return image;
  }

 private:
  // Embree 4 moved what a query is asked with from its context to arguments.
#if RTC_VERSION_MAJOR >= 4
  using Context = RTCRayQueryContext;
  static constexpr RTCSceneFlags kFilterFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
  using Context = RTCIntersectContext;
  static constexpr RTCSceneFlags kFilterFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif
  struct Query : Context {
    frontend::TraceRay ray;
    NearestHits hits;
    Peer peer = Peer::mesh;
    unsigned faces = 20;
  };

  glm::vec3 trace(const glm::vec3& origin, const glm::vec3& direction, unsigned k, float ert) const {
    Query query;
    query.ray = frontend::TraceRay(origin, direction);
    query.peer = peer_;
    query.hits.begin_ray(k);
#if RTC_VERSION_MAJOR >= 4
    rtcInitRayQueryContext(&query);
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &query;
    arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
    if (has_triangles(peer_)) {
      arguments.flags = static_cast<RTCRayQueryFlags>(arguments.flags | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
      arguments.filter = &filter_triangle;
    }
    const auto intersect = [&](RTCRayHit& hit) { rtcIntersect1(world_, &hit, &arguments); };
#else
    rtcInitIntersectContext(&query);
    query.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    if (has_triangles(peer_)) query.filter = &filter_triangle;
    const auto intersect = [&](RTCRayHit& hit) { rtcIntersect1(world_, &query, &hit); };
#endif
    const auto basis = frontend::sh_basis(direction, scene_.sh_degree);
    const unsigned coefficients = scene_.sh_coefficients();
    glm::vec3 colour(0.0f);
    float transmittance = 1.0f;
    for (;;) {
      query.hits.begin_round();
      RTCRayHit hit;
      std::memset(&hit, 0, sizeof hit);
      hit.ray = {origin.x,
                 origin.y,
                 origin.z,
                 query.hits.nearest_new(),
                 direction.x,
                 direction.y,
                 direction.z,
                 0.0f,
                 std::numeric_limits<float>::infinity(),
                 ~0u,
                 0,
                 0};
      hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      intersect(hit);
      for (unsigned i = 0; i < query.hits.size(); ++i) {
        const std::uint32_t id = query.hits[i].id;
        const frontend::GaussianRecord& g = gaussians_.record(id);
        const float alpha = frontend::hit_alpha(g.opacity, g.kappa2, frontend::to_unit_ray(query.ray, g).d2);
        if (!(alpha > 0.0f)) continue;
        colour += (alpha * transmittance) *
                  frontend::sh_colour(&scene_.sh[static_cast<std::size_t>(id) * coefficients * 3], basis, coefficients);
        transmittance *= 1.0f - alpha;
        if (transmittance < ert) return colour;
      }
      if (!query.hits.full()) return colour;
    }
  }

  static void attach(RTCScene scene, RTCGeometry geometry) {
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  RTCGeometry triangles(const std::vector<glm::vec3>& vertices, const std::vector<std::uint32_t>& indices) const {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                      vertices.size());
    std::memcpy(v, vertices.data(), vertices.size() * sizeof(glm::vec3));
    void* i = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, indices.size() / 3);
    std::memcpy(i, indices.data(), indices.size() * 4);
    return geometry;
  }

  RTCGeometry mesh() const {
    std::vector<glm::vec3> vertices;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t g = 0; g < scene_.size(); ++g) {
      const auto first = static_cast<std::uint32_t>(vertices.size());
      for (const glm::vec3& v : proxy_.vertices()) vertices.push_back(gaussians_.to_world(g, v));
      for (const auto& t : proxy_.triangles()) {
        for (const std::uint16_t corner : t) indices.push_back(first + corner);
      }
    }
    return triangles(vertices, indices);
  }

  void add_instances() {
    shared_ = rtcNewScene(device_);
    rtcSetSceneFlags(shared_, kFilterFlag);
    if (peer_ == Peer::instanced_mesh) {
      std::vector<std::uint32_t> indices;
      for (const auto& t : proxy_.triangles()) indices.insert(indices.end(), t.begin(), t.end());
      attach(shared_, triangles(proxy_.vertices(), indices));
    } else {
      RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
      rtcSetGeometryUserPrimitiveCount(geometry, 1);
      rtcSetGeometryBoundsFunction(geometry, &bounds_of_unit_sphere, nullptr);
      rtcSetGeometryIntersectFunction(geometry, &intersect_unit_sphere);
      attach(shared_, geometry);
    }
    rtcCommitScene(shared_);
    for (std::uint32_t g = 0; g < scene_.size(); ++g) {
      RTCGeometry instance = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(instance, shared_);
      const glm::vec3 mean = gaussians_.record(g).mean;
      float columns[12];
      for (int c = 0; c < 3; ++c) {
        glm::vec3 axis(0.0f);
        axis[c] = 1.0f;
        const glm::vec3 tip = gaussians_.to_world(g, axis) - mean;
        for (int i = 0; i < 3; ++i) columns[3 * c + i] = tip[i];
      }
      for (int i = 0; i < 3; ++i) columns[9 + i] = mean[i];
      rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
      rtcCommitGeometry(instance);
      rtcAttachGeometryByID(world_, instance, g);
      rtcReleaseGeometry(instance);
    }
  }

  // Reports a hit to Embree only to shorten the ray.
  static void filter_triangle(const RTCFilterFunctionNArguments* a) {
    auto& query = *static_cast<Query*>(a->context);
    auto* ray = reinterpret_cast<RTCRay*>(a->ray);
    const auto* hit = reinterpret_cast<const RTCHit*>(a->hit);
    a->valid[0] = 0;
    // Embree's normal of an instanced triangle is in object space, as the ray is here.
    const float facing = (hit->Ng_x * ray->dir_x + hit->Ng_y * ray->dir_y) + hit->Ng_z * ray->dir_z;
    if (!(facing < 0.0f)) return;
    const std::uint32_t id = query.peer == Peer::instanced_mesh ? query.instID[0] : hit->primID / query.faces;
    if (query.hits.insert({ray->tfar, id})) shorten(query, *ray, a->valid[0]);
  }

  static void shorten(const Query& query, RTCRay& ray, int& valid) {
    const float last = query.hits[query.hits.size() - 1].t;
    if (!(last <= ray.tfar)) return;
    ray.tfar = std::nextafter(last, std::numeric_limits<float>::infinity());  // ties of the last still count
    valid = -1;
  }

  static void bounds_of_ellipsoid(const RTCBoundsFunctionArguments* a) {
    const auto& self = *static_cast<const EmbreePeer*>(a->geometryUserPtr);
    const frontend::Box box = self.gaussians_.instance_box(a->primID, self.proxy_, false);
    *a->bounds_o = {box.lower.x, box.lower.y, box.lower.z, 0.0f, box.upper.x, box.upper.y, box.upper.z, 0.0f};
  }
  static void bounds_of_unit_sphere(const RTCBoundsFunctionArguments* a) {
    *a->bounds_o = {-1.0f, -1.0f, -1.0f, 0.0f, 1.0f, 1.0f, 1.0f, 0.0f};
  }

  static void intersect_ellipsoid(const RTCIntersectFunctionNArguments* a) {
    if (a->valid[0] == 0) return;
    auto& query = *static_cast<Query*>(a->context);
    const auto& self = *static_cast<const EmbreePeer*>(a->geometryUserPtr);
    report(query, *a, a->primID, frontend::to_unit_ray(query.ray, self.gaussians_.record(a->primID)));
  }
  static void intersect_unit_sphere(const RTCIntersectFunctionNArguments* a) {
    if (a->valid[0] == 0) return;
    auto& query = *static_cast<Query*>(a->context);
    const RTCRay& ray = reinterpret_cast<const RTCRayHit*>(a->rayhit)->ray;
    const glm::vec3 o(ray.org_x, ray.org_y, ray.org_z), d(ray.dir_x, ray.dir_y, ray.dir_z);
    frontend::UnitRay unit;
    unit.length2 = (d.x * d.x + d.y * d.y) + d.z * d.z;
    unit.t_peak = -((o.x * d.x + o.y * d.y) + o.z * d.z) / unit.length2;
    const glm::vec3 peak = o + unit.t_peak * d;
    unit.d2 = (peak.x * peak.x + peak.y * peak.y) + peak.z * peak.z;
    report(query, *a, query.instID[0], unit);
  }
  static void report(Query& query, const RTCIntersectFunctionNArguments& a, std::uint32_t id,
                     const frontend::UnitRay& unit) {
    if (!(unit.d2 <= 1.0f)) return;
    const float t = unit.t_peak - std::sqrt((1.0f - unit.d2) / unit.length2);
    RTCRay& ray = reinterpret_cast<RTCRayHit*>(a.rayhit)->ray;
    if (!(t > 0.0f) || t > ray.tfar) return;
    int ignored = 0;
    if (query.hits.insert({t, id})) shorten(query, ray, ignored);
  }

  Peer peer_;
  const frontend::Scene& scene_;
  const frontend::PreparedGaussians& gaussians_;
  frontend::Proxy proxy_;
  RTCDevice device_;
  RTCScene world_;
  RTCScene shared_ = nullptr;
};

}  // namespace grtx::bench
