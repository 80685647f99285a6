// SPDX-License-Identifier: Apache-2.0
// A platform's memory holds what a launch reads, and at its end the picture that the tracer has drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

#include "error_of.h"
#include "grtx/base/child_process.h"
#include "grtx/base/colour_byte.h"
#include "grtx/base/fp16.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/scene_memory.h"
#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/platform/shared_memory.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using test::SharedMemory;
using ::testing::HasSubstr;
using traces::testing::TemporaryFile;

constexpr unsigned kWidth = 16, kHeight = 8;

/// A small room, read from a file that is gone again.
struct Room {
  Room() {
    const TemporaryFile base("room");
    const std::string path = base.path() + ".ply", cameras = frontend::synth_cameras_path(path);
    frontend::synthesise({.preset = "room", .count = 300, .seed = 3, .sh_degree = 1}, path);
    scene = frontend::load_scene(path);
    camera = frontend::load_cameras(cameras).front().resized(kWidth, kHeight);
    std::remove(path.c_str());
    std::remove(cameras.c_str());
  }
  frontend::Scene scene;
  frontend::Camera camera;
};

/// A view of it, traced into files.
struct View {
  explicit View(frontend::AccelKind kind, const Room& room = {}) : tracer(room.scene, room.camera) {
    tracer.build({kind});
    traced = tracer.trace({}, {.threads = 1}, trace.path());
    frontend::write_scene_memory(contents.path(), trace.path(), tracer, traced);
  }
  TemporaryFile trace{"trace"}, contents{"contents"};
  frontend::ViewTracer tracer;
  frontend::TracedView traced;
};

/// A GPU on a memory that others have filled, and a script.
struct Desk final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = Desk;
  using Script = std::function<void(Desk&)>;
  Desk(const sc_core::sc_module_name& name, const GpuComponent::Options& options, Script what)
      : sc_module(name), gpu("gpu", options), launcher("launcher", {}), script(std::move(what)) {
    launcher.socket.bind(gpu.registers);
    launcher.interrupt.bind(line);
    gpu.interrupt.bind(line);
    SC_THREAD(run);
  }
  void run() { script(*this); }
  std::uint32_t launch(const Picture& picture) {
    launcher.write(GpuRegister::picture, static_cast<std::uint32_t>(picture.address));
    launcher.write(GpuRegister::picture_high, static_cast<std::uint32_t>(picture.address >> 32));
    launcher.write(GpuRegister::pitch, picture.pitch);
    launcher.write(GpuRegister::format, static_cast<std::uint32_t>(picture.format));
    return launcher.launch({});
  }
  std::vector<unsigned char>& bytes() { return dynamic_cast<SharedMemory&>(gpu.memory()).contents.bytes; }
  /// As many bytes of the GPU's memory, from an address of the map on.
  std::string at(std::uint64_t address, std::uint64_t count) {
    return {reinterpret_cast<const char*>(bytes().data()) + address, count};
  }

  sc_core::sc_signal<bool> line{"line"};
  GpuComponent gpu;
  test::Launcher launcher;
  Script script;
};

GpuComponent::Options options_of(const View& view) {
  GpuComponent::Options options;
  options.machine.sms = 2;
  options.traces = {view.trace.path()};
  options.contents = {view.contents.path()};
  options.memory = [](Gpu& gpu, const BuildOptions&) { return std::make_unique<SharedMemory>(gpu); };
  return options;
}

/// Runs in a process of its own; the script's checks are of this test.
void on_a_desk(const GpuComponent::Options& options, const Desk::Script& script) {
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_DO_NOTHING);
    Desk desk("desk", options, script);
    sc_core::sc_start();
    return std::string(::testing::Test::HasFailure() ? "failed" : "passed");
  });
  EXPECT_EQ(child.result(), "passed");
}

void expect_bytes(Desk& desk, const char* region, const std::string& wanted) {
  for (const auto& extent : desk.gpu.gpu().map().extents()) {
    if (extent.name != region) continue;
    EXPECT_EQ(extent.bytes, wanted.size()) << region;
    EXPECT_TRUE(desk.at(extent.base, extent.bytes) == wanted) << region;
    return;
  }
  ADD_FAILURE() << "no region " << region;
}

template <typename T>
std::string text_of(const T* values, std::size_t count) {
  return {reinterpret_cast<const char*>(values), count * sizeof(T)};
}

TEST(FunctionalMemory, HoldsNodesRecordsAndPixelsWhereTheMapSays) {
  const View view(frontend::AccelKind::tlas_tri20);
  on_a_desk(options_of(view), [&](Desk& desk) {
    EXPECT_EQ(desk.launch({}), 0u);
    const frontend::NodeImage& image = view.tracer.accel().image();
    const frontend::Scene& scene = view.tracer.scene();
    expect_bytes(desk, "node_image", text_of(image.data(), image.size()));
    expect_bytes(desk, "sh", text_of(scene.sh.data(), scene.sh.size()));
    std::vector<float> records, pixels;
    for (std::size_t g = 0; g < scene.size(); ++g) {
      for (int i = 0; i < 3; ++i) records.push_back(scene.mean[g][i]);
      for (int i = 0; i < 3; ++i) records.push_back(scene.scale[g][i]);
      const glm::quat& r = scene.rotation[g];
      for (const float value : {r.x, r.y, r.z, r.w, scene.opacity[g], 0.0f}) records.push_back(value);
    }
    expect_bytes(desk, "gaussian", text_of(records.data(), records.size()));
    for (const glm::vec3& p : view.traced.result.image.pixels) {
      for (const float value : {p.r, p.g, p.b, 0.0f}) pixels.push_back(value);
    }
    expect_bytes(desk, "pixel", text_of(pixels.data(), pixels.size()));
  });
}

TEST(FunctionalMemory, WritesThePictureOfTheTracerWhereTheRegistersSay) {
  const View view(frontend::AccelKind::tlas_tri20);
  on_a_desk(options_of(view), [&](Desk& desk) {
    const std::uint64_t address = desk.gpu.gpu().memory_bytes() + 100;
    for (const auto& [format, bytes] : {std::pair(PictureFormat::rgba8, 4u), std::pair(PictureFormat::rgba16f, 8u)}) {
      const std::uint32_t pitch = bytes * kWidth + 24;
      const std::string before = desk.at(address, pitch * kHeight);
      EXPECT_EQ(desk.launch({format, address, pitch}), 0u);
      const std::string after = desk.at(address, pitch * kHeight);
      bool coloured = false;
      for (unsigned y = 0; y < kHeight; ++y) {
        for (unsigned x = 0; x < kWidth; ++x) {
          const glm::vec3& p = view.traced.result.image.at(x, y);
          std::string pixel;
          for (const float value : {p.r, p.g, p.b, 1.0f}) {
            if (format == PictureFormat::rgba8) {
              pixel.push_back(static_cast<char>(colour_byte(value)));
            } else {
              pixel.push_back(static_cast<char>(fp16_bits(value) & 0xFF));
              pixel.push_back(static_cast<char>(fp16_bits(value) >> 8));
            }
          }
          coloured = coloured || colour_byte(p.g) > 20;
          EXPECT_EQ(after.substr(y * pitch + x * bytes, bytes), pixel) << x << ' ' << y;
        }
        const std::size_t behind = y * pitch + kWidth * bytes;  // the row's end stays as it was
        EXPECT_EQ(after.substr(behind, 24), before.substr(behind, 24));
      }
      EXPECT_TRUE(coloured);
    }
  });
}

/// Row `row` of the matrix at `unit`, times (x, 1).
double on_row(const std::string& shapes, std::uint64_t unit, int row, const glm::dvec3& x) {
  float a[4];
  std::memcpy(a, shapes.data() + unit * 48 + static_cast<std::size_t>(row) * 16, sizeof a);
  return static_cast<double>(a[0]) * x.x + static_cast<double>(a[1]) * x.y + static_cast<double>(a[2]) * x.z +
         static_cast<double>(a[3]);
}

// A point on a half axis of the ellipsoid lies on the unit sphere, and the mean at its centre.
TEST(FunctionalMemory, HoldsTheMatrixOfEachBox) {
  const View view(frontend::AccelKind::box);
  on_a_desk(options_of(view), [&](Desk& desk) {
    EXPECT_EQ(desk.launch({}), 0u);
    const frontend::NodeImage& image = view.tracer.accel().image();
    std::string shapes;
    for (const auto& extent : desk.gpu.gpu().map().extents()) {
      if (extent.name == "shape") shapes = desk.at(extent.base, extent.bytes);
    }
    std::vector<bool> seen(view.tracer.scene().size());
    const std::string none(48, '\0');
    for (std::uint64_t unit = 0; unit * 48 < shapes.size(); ++unit) {
      if (shapes.compare(unit * 48, 48, none) == 0) continue;
      const std::uint32_t g = image.procedural_primitive(unit * image.sizes().unit());
      ASSERT_LT(g, seen.size());
      seen[g] = true;
      const glm::dvec3 mean(view.tracer.gaussians().record(g).mean);
      for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 tip = mean + glm::dvec3(view.tracer.gaussians().half_axis(g, axis));
        double length = 0.0;
        for (int row = 0; row < 3; ++row) {
          EXPECT_NEAR(on_row(shapes, unit, row, mean), 0.0, 1e-2);
          length += std::pow(on_row(shapes, unit, row, tip), 2);
        }
        EXPECT_NEAR(length, 1.0, 0.05);
      }
    }
    EXPECT_TRUE(std::ranges::all_of(seen, [](bool there) { return there; }));
  });
}

TEST(FunctionalMemory, RefusesAPictureThatCannotBeAndTheNextLaunchIsWhole) {
  const View view(frontend::AccelKind::tri20);
  on_a_desk(options_of(view), [&](Desk& desk) {
    constexpr auto kPicture = static_cast<std::uint32_t>(LaunchError::picture);
    EXPECT_EQ(desk.launch({PictureFormat::rgba8, 0, 4 * kWidth - 1}), kPicture);  // rows would overlap
    EXPECT_EQ(desk.launch({static_cast<PictureFormat>(3), 0, 0}), kPicture);      // no such format
    EXPECT_EQ(desk.gpu.results().size(), 0u);
    EXPECT_EQ(desk.launch({PictureFormat::rgba8, desk.bytes().size() - 8, 0}), kPicture);  // beyond the memory
    EXPECT_EQ(desk.gpu.results().size(), 1u);
    EXPECT_EQ(desk.launch({}), 0u);
    EXPECT_EQ(desk.gpu.results().size(), 2u);
  });
}

TEST(FunctionalMemory, WithoutContentsNoPictureIsPromised) {
  const View view(frontend::AccelKind::tri20);
  GpuComponent::Options options = options_of(view);
  options.contents.clear();
  on_a_desk(options, [&](Desk& desk) {
    EXPECT_EQ(desk.launch({PictureFormat::rgba8, 0, 0}), static_cast<std::uint32_t>(LaunchError::picture));
    EXPECT_EQ(desk.launch({}), 0u);
  });
}

TEST(FunctionalMemory, ChangesNoCycle) {
  const View view(frontend::AccelKind::tlas_tri20);
  std::uint64_t cycles[2] = {0, 0};
  for (const bool functional : {false, true}) {
    GpuComponent::Options options = options_of(view);
    options.keep_data = true;
    if (!functional) options.contents.clear();
    ChildProcess child("platform", [&] {
      modules::set_time_resolution_to_fs();
      Desk desk("desk", options, [](Desk& own) { own.launch({}); });
      sc_core::sc_start();
      return std::to_string(desk.gpu.results().front().cycles);
    });
    cycles[functional ? 1 : 0] = std::stoull(child.result());
  }
  EXPECT_GT(cycles[0], 0u);
  EXPECT_EQ(cycles[0], cycles[1]);
}

TEST(FunctionalMemory, RefusesTheContentsOfAnotherTrace) {
  const View view(frontend::AccelKind::tri20), other(frontend::AccelKind::tlas_tri20);
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    GpuComponent::Options options = options_of(view);
    options.contents = {other.contents.path()};
    std::string said = grtx::test::error_of([&] { GpuComponent gpu("gpu", options); });
    options.contents = {view.contents.path(), view.contents.path()};
    said += grtx::test::error_of([&] { GpuComponent gpu("gpu2", options); });
    return said;
  });
  const std::string said = child.result();
  EXPECT_THAT(said, HasSubstr("trace: is not of " + view.trace.path()));
  EXPECT_THAT(said, HasSubstr("contents: must be one file for each trace"));
}

}  // namespace
}  // namespace grtx::sim
