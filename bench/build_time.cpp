// What building an acceleration structure costs beside a bare rtcBuildBVH over the same boxes, whose callbacks only
// allocate. Ours includes the boxes, the tree and the packing of the node image; the bare one neither the making of its
// boxes nor the device, nor giving back its memory. Both take turns.
//
//   build/bench/bench/build_time SCENE [SCENE ...] [--accel tri20 --runs 3]
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/stopwatch.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/scene/scene_io.h"

namespace grtx::bench {
namespace {

using namespace grtx::frontend;

constexpr unsigned kWidth = 6;

struct Node {
  RTCBounds bounds[kWidth];
  void* child[kWidth];
};

/// Seconds of rtcBuildBVH alone; `boxes` is used up.
double bare_build(std::vector<RTCBuildPrimitive>& boxes) {
  const std::unique_ptr<RTCDeviceTy, void (*)(RTCDevice)> device(rtcNewDevice(nullptr), rtcReleaseDevice);
  const std::unique_ptr<RTCBVHTy, void (*)(RTCBVH)> bvh(rtcNewBVH(device.get()), rtcReleaseBVH);
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.byteSize = sizeof arguments;
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = kWidth;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 1;
  arguments.bvh = bvh.get();
  arguments.primitives = boxes.data();
  arguments.primitiveCount = arguments.primitiveArrayCapacity = boxes.size();
  arguments.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void*) {
    return rtcThreadLocalAlloc(allocator, sizeof(Node), 16);
  };
  arguments.setNodeChildren = [](void* node, void** children, unsigned count, void*) {
    std::copy_n(children, count, static_cast<Node*>(node)->child);
  };
  arguments.setNodeBounds = [](void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<Node*>(node)->bounds[i] = *bounds[i];
  };
  arguments.createLeaf = [](RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitive, std::size_t, void*) {
    auto* leaf = static_cast<unsigned*>(rtcThreadLocalAlloc(allocator, sizeof(unsigned), 4));
    *leaf = primitive->primID;
    return static_cast<void*>(leaf);
  };
  const auto start = std::chrono::steady_clock::now();
  if (rtcBuildBVH(&arguments) == nullptr) throw Error("build_time", "", "rtcBuildBVH failed");
  return seconds_since(start);
}

std::vector<RTCBuildPrimitive> boxes_of(const PreparedGaussians& gaussians, const AccelOptions& options) {
  const Proxy proxy(proxy_of(options.kind));
  const bool two_level = is_two_level(options.kind);
  const std::size_t faces = two_level || proxy.is_sphere() ? 1 : proxy.faces();
  std::vector<RTCBuildPrimitive> boxes(gaussians.size() * faces);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const auto g = static_cast<std::uint32_t>(i / faces);
    const Box b = two_level ? gaussians.instance_box(g, proxy, options.corner_bounds)
                            : gaussians.face_box(g, proxy, static_cast<unsigned>(i % faces));
    boxes[i] = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, static_cast<unsigned>(i)};
  }
  return boxes;
}

void measure(const std::string& file, AccelKind kind, unsigned runs) {
  const Scene scene = load_scene(file);
  const PreparedGaussians gaussians(scene, true);
  const AccelOptions options{kind, kWidth, false};
  double bare = 1e30, ours = 1e30, embree = 0;
  std::uint64_t bytes = 0;
  for (unsigned run = 0; run < runs; ++run) {
    {
      std::vector<RTCBuildPrimitive> boxes = boxes_of(gaussians, options);
      bare = std::min(bare, bare_build(boxes));
    }
    const auto start = std::chrono::steady_clock::now();
    const AccelerationStructure accel(gaussians, options);
    const double seconds = seconds_since(start);
    if (seconds < ours) {
      ours = seconds;
      embree = accel.build_seconds();
    }
    bytes = accel.image().size();
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print(
      "{:<40} {:>12} {:>10} Gaussians  ours/bare {:.2f} (rtcBuildBVH of it {:.2f})  image {:.0f} MB  peak {:.0f} MB\n",
      file, accel_name(kind), gaussians.size(), ours / bare, embree / bare, static_cast<double>(bytes) * 1e-6,
      static_cast<double>(usage.ru_maxrss) * 1e-3);
}

}  // namespace
}  // namespace grtx::bench

int main(int argc, char** argv) {
  CLI::App app("Time of building against a bare rtcBuildBVH");
  std::vector<std::string> files;
  std::string accel = "tri20";
  unsigned runs = 3;
  app.add_option("scenes", files, "Scenes")->required();
  app.add_option("--accel", accel, "Acceleration structure")->capture_default_str();
  app.add_option("--runs", runs, "Builds of each; the best counts")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    for (const std::string& file : files) grtx::bench::measure(file, grtx::frontend::accel_from_name(accel), runs);
  } catch (const std::exception& error) {
    std::fputs((std::string(error.what()) + "\n").c_str(), stderr);
    return 2;
  }
  return 0;
}
