// SPDX-License-Identifier: Apache-2.0
// Warps of every size and both mappings: the same image and the same work, executed once by the hardware model.
#include <gtest/gtest.h>

#include <filesystem>

#include "grtx/base/child_process.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "paths.h"
#include "rtl_tlm/simulate_priced.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

struct Traced {
  frontend::Image image;
  traces::Totals totals;
  ordered_json stats;
};

class WarpSize : public ::testing::Test {
 protected:
  void SetUp() override {
    base_ = ::testing::TempDir() + "/warp_size_" + std::to_string(::getpid());
    frontend::synthesise({"flat", 800, 5, 1}, base_ + ".ply");
  }
  void TearDown() override {
    for (const char* end : {".ply", ".cameras.json", ".grtx"}) std::filesystem::remove(base_ + end);
  }
  Traced run(unsigned warp_size, bool linear) const {
    const frontend::Scene scene = frontend::load_scene(base_ + ".ply");
    const frontend::Camera camera = frontend::load_cameras(base_ + ".cameras.json")[0].resized(16, 16);
    frontend::TracerOptions options;
    options.checkpoint = true;
    frontend::RenderOptions render;
    render.threads = 1;
    render.warp_size = warp_size;
    render.linear_mapping = linear;
    const frontend::PreparedGaussians gaussians(scene, options.kernel);
    const frontend::AccelerationStructure accel(gaussians, {frontend::AccelKind::tlas_tri20, 6, false});
    Traced result;
    {
      traces::Writer writer(base_ + ".grtx", frontend::trace_header(scene, camera, accel, options, render));
      result.image = frontend::render(scene, gaussians, accel, camera, options, render, &writer).image;
      writer.finish();
    }
    const traces::Reader reader(base_ + ".grtx");
    traces::check(reader, true);
    EXPECT_EQ(reader.header().warp_size, warp_size);
    EXPECT_EQ(reader.group_count(), 256U / warp_size);
    result.totals = reader.totals();
    ChildProcess child("simulation", [&] {
      const SimulationResult simulated = test::simulate_priced(
          base_ + ".grtx", load_config(grtx::paths::source_dir() + "/configs/small.toml", {}), {});
      EXPECT_TRUE(simulated.violations.empty());
      return simulated.violations.empty() ? simulated.document.at("stats").dump() : std::string("{}");
    });
    result.stats = ordered_json::parse(child.result());
    return result;
  }

 private:
  std::string base_;
};

TEST_F(WarpSize, ChangesTimeAndFetchesButNeitherImageNorWork) {
  const Traced reference = run(32, false);
  const auto value = [](const Traced& r, const char* name) {
    return r.stats.at(name).at("value").get<std::uint64_t>();
  };
  std::uint64_t fetches = value(reference, "gpu.rt.node_fetches");
  for (const unsigned warp_size : {16U, 8U, 4U}) {
    const Traced smaller = run(warp_size, false);
    EXPECT_EQ(smaller.image.pixels, reference.image.pixels) << warp_size;
    EXPECT_EQ(smaller.totals, reference.totals) << warp_size;
    EXPECT_EQ(value(smaller, "gpu.rt.node_visits"), reference.totals.visits()) << warp_size;
    EXPECT_EQ(value(smaller, "gpu.simt.warps"), 256U / warp_size);
    // Fewer lanes merge into a fetch.
    EXPECT_GT(value(smaller, "gpu.rt.node_fetches"), fetches) << warp_size;
    fetches = value(smaller, "gpu.rt.node_fetches");
  }
  const Traced linear = run(32, true);
  EXPECT_EQ(linear.image.pixels, reference.image.pixels);
  EXPECT_EQ(linear.totals, reference.totals);
  EXPECT_NE(value(linear, "gpu.cycles"), value(reference, "gpu.cycles"));
}

}  // namespace
}  // namespace grtx::sim
