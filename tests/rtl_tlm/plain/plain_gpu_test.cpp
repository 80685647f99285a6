// SPDX-License-Identifier: Apache-2.0
// The SystemC model against the plain one: gpu.cycles and every counter of every unit, on random traces with random
// small machines and on a trained scene. GRTX_PLAIN_TRACES: how many random traces (docs/guide/testing.md).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "frontend/tracer/random_scene.h"
#include "grtx/base/child_process.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "paths.h"
#include "real_scene_files.h"
#include "rtl_tlm/plain/gpu.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/traced_view.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using traces::testing::random_trace;
using traces::testing::RandomOptions;

/// What is derived from counters by formulas of its own, and what depends on the host.
bool is_left_out(const std::string& name) {
  return name.starts_with("host.") || name.starts_with("gpu.bound.") || name.starts_with("gpu.energy");
}

/// name -> value in the SystemC model.
std::map<std::string, double> systemc(const std::string& path, const GpuConfig& config) {
  ChildProcess child("simulation", [&] {
    const SimulationResult result = simulate(path, config, {});
    ordered_json stats = result.document.at("stats");
    if (!result.violations.empty()) stats["violation: " + result.violations[0]] = {{"value", 1}};
    return stats.dump();
  });
  std::map<std::string, double> values;
  const ordered_json stats = ordered_json::parse(child.result());
  for (const auto& [name, entry] : stats.items()) {
    if (!is_left_out(name)) values[name] = entry.at("value").get<double>();
  }
  return values;
}

/// Both models on the trace of this file; a statistic that one of them does not report counts as 0. Returns what
/// differs, a line each.
std::string differences(const std::string& path, const GpuConfig& config) {
  const traces::Reader reader(path);
  std::vector<traces::RayGroup> groups(reader.group_count());
  for (std::size_t g = 0; g < groups.size(); ++g) reader.read(g, groups[g]);
  std::map<std::string, std::pair<double, double>> both;
  for (const auto& [name, value] : systemc(path, config)) both[name].first = value;
  const plain::Statistics found = plain::run(config, reader.header(), groups, reader.totals().max_evictions_per_ray);
  for (const auto& [name, value] : found.values) both[name].second = value;
  std::string all;
  for (const auto& [name, values] : both) {
    const auto [a, b] = values;
    const double rounding = 1e-12 * std::max(std::abs(a), std::abs(b));  // of means and rates; counts are exact
    if (std::abs(a - b) > rounding) all += fmt::format("{}: SystemC {}, plain {}\n", name, a, b);
  }
  return all;
}

class PlainGpu : public ::testing::TestWithParam<unsigned> {};

// Each instance takes its share of the random traces: seeds i, i + 8, i + 16, …
constexpr unsigned kPlainShares = 8;

TEST_P(PlainGpu, AgreesOnRandomTracesAndMachines) {
  const char* const wanted = std::getenv("GRTX_PLAIN_TRACES");
  const unsigned traces = wanted != nullptr ? static_cast<unsigned>(std::stoul(wanted)) : 80;
  for (unsigned seed = GetParam(); seed < traces; seed += kPlainShares) {
    test::Random random(seed);
    RandomOptions options = test::random_options(random, seed);
    GpuConfig config = test::random_machine(random);
    test::make_possible(config, options);
    const unsigned leaves = random.upto(5);
    options.procedural = leaves < 3 && options.layout == traces::NodeLayout::quantised;  // their size differs
    auto trace = random_trace(options);
    // Secondary groups follow the primary ones.
    std::stable_sort(trace.groups.begin(), trace.groups.end(),
                     [](const auto& a, const auto& b) { return a.kind < b.kind; });
    for (std::uint32_t g = 0; g < trace.groups.size(); ++g) trace.groups[g].index = g;
    if (leaves < 3) {
      test::make_procedural(trace, leaves < 2);
      if (leaves < 2) config.rt.any_hit_unit.enabled = false;  // hits of boxes come from a shader
    }
    const traces::testing::TemporaryFile file("plain");
    traces::testing::write_trace(file.path(), trace.header, trace.groups);
    EXPECT_EQ(differences(file.path(), config), "") << describe(options) << "\n" << config_json(config).dump();
  }
}
INSTANTIATE_TEST_SUITE_P(Shares, PlainGpu, ::testing::Range(0U, kPlainShares));

TEST(PlainGpuScene, AgreesOnATrainedSceneInAllDesigns) {
  const std::string path = grtx::test::real_scene_path("playbot_L4");
  const std::string cameras = grtx::test::real_cameras_path("playbot");
  if (path.empty() || cameras.empty()) GTEST_SKIP() << "no trained scenes: name their folder in GRTX_SCENES";
  const frontend::Scene scene = frontend::load_scene(path);
  const frontend::Camera camera = frontend::load_cameras(cameras)[0];
  for (const auto kind : {frontend::AccelKind::tri20, frontend::AccelKind::tlas_tri20}) {
    for (const bool checkpoint : {false, true}) {
      const traces::testing::TemporaryFile file("plain");
      test::write_view(file.path(), scene, camera, 32, 16, kind, checkpoint);
      // One design is enough for machines that differ in what all designs share.
      const bool all = checkpoint && kind == frontend::AccelKind::tlas_tri20;
      for (const char* machine : {"table1", "deep_stack", "intersection_only"}) {
        const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/" + machine + ".toml", {});
        EXPECT_EQ(differences(file.path(), config), "")
            << frontend::accel_name(kind) << (checkpoint ? " with checkpoints, " : ", ") << machine;
        if (!all) break;
      }
    }
  }
}

TEST(PlainGpuColours, AgreesWhereAColourIsMadeOnceInAFrame) {
  using frontend::AccelKind;
  const std::vector<std::string> walk = {"rt.traversal=warp", "rt.warp_buffer.spill=true", "rt.gaussian.enabled=true",
                                         "rt.any_hit_unit.enabled=true", "gpu.sms=2"};
  const frontend::Scene scene = grtx::test::random_scene(72, {.count = 400, .log_scale_mean = -1.8, .sh_degree = 3});
  for (const AccelKind accel : {AccelKind::tlas_tri20, AccelKind::ellipsoid}) {
    frontend::TracerOptions options;
    options.sh_direction = frontend::ShDirection::centre;
    options.colour = frontend::ColourPer::frame;
    const traces::testing::TemporaryFile file("plain");
    test::write_view(file.path(), scene, grtx::test::front_camera(16, 8, 1.2), 16, 8, accel, options);
    const traces::Reader reader(file.path());
    EXPECT_EQ(reader.header().colour, traces::ColourPer::frame);
    EXPECT_NO_THROW(traces::check(reader, true));
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/table1.toml",
                                         accel == AccelKind::ellipsoid ? walk : std::vector<std::string>{});
    EXPECT_EQ(differences(file.path(), config), "") << frontend::accel_name(accel);
    const double made = systemc(file.path(), config).at("gpu.simt.colours_made");
    EXPECT_GT(made, 0.0);
    EXPECT_LT(made, 0.5 * static_cast<double>(reader.totals().blended));
  }
}

// Traces whose hits hide others: shaders that compute alphas, heaps from which entries leave, warps that walk together.
TEST(PlainGpuBound, AgreesWhereHitsHideOthers) {
  using frontend::AccelKind;
  const std::vector<std::string> heaps = {"rt.gaussian.enabled=true", "rt.any_hit_unit.enabled=true"};
  const std::vector<std::string> walk = {"rt.traversal=warp", "rt.warp_buffer.spill=true", "rt.warp_stack.ahead=4"};
  std::vector<std::string> both = heaps;
  both.insert(both.end(), walk.begin(), walk.end());
  struct Case {
    AccelKind accel;
    bool checkpoint;
    unsigned k, ahead;
    std::vector<std::string> settings;
  };
  const Case cases[] = {{AccelKind::tri20, false, 8, 1, {"rt.any_hit.timeout=3"}},
                        {AccelKind::tlas_tri20, false, 16, 1, {"simt.k_buffer_layout=by_ray"}},
                        {AccelKind::tri20, true, 4, 1, {"simt.eviction_layout=by_lane"}},
                        {AccelKind::tlas_tri20, true, 8, 1, {}},
                        {AccelKind::box, false, 32, 1, {"simt.cost.any_hit_bound=0"}},
                        {AccelKind::tlas_box, true, 8, 1, {"simt.dependent_loads=false"}},
                        {AccelKind::ellipsoid, false, 16, 1, heaps},
                        {AccelKind::tlas_sphere, true, 6, 1, heaps},
                        {AccelKind::ellipsoid, false, 64, 8, both},
                        {AccelKind::tri20, false, 16, 4, walk}};
  const frontend::Scene scene =
      grtx::test::random_scene(71, {.count = 400, .log_scale_mean = -1.8, .opacity_high = 0.99, .sh_degree = 1});
  for (const Case& c : cases) {
    frontend::TracerOptions options;
    options.opacity_bound = frontend::OpacityBound::on;
    options.checkpoint = c.checkpoint;
    options.k = c.k;
    options.ahead = c.ahead;
    const traces::testing::TemporaryFile file("plain");
    test::write_view(file.path(), scene, grtx::test::front_camera(32, 16, 1.2), 32, 16, c.accel, options);
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/table1.toml", c.settings);
    const std::string what = frontend::accel_name(c.accel) + fmt::format(" k {} ahead {}", c.k, c.ahead);
    EXPECT_EQ(differences(file.path(), config), "") << what;
    const traces::Reader reader(file.path());
    traces::RayGroup group;
    std::uint64_t hidden = 0;
    for (std::uint64_t g = 0; g < reader.group_count(); ++g) {
      reader.read(g, group);
      for (const traces::Ray& ray : group.rays) {
        for (const traces::Event& event : ray.events) hidden += event.hidden();
      }
    }
    EXPECT_GT(hidden, 0u) << what;
  }
}

TEST(PlainGpuList, AgreesOnListsLongAndShort) {
  const frontend::Scene scene = grtx::test::random_scene(66, {.count = 400, .sh_degree = 1});
  frontend::TracerOptions options;
  options.tracing = frontend::Tracing::list;
  for (const unsigned capacity : {12U, 2048U}) {
    options.k = options.list_capacity = capacity;
    const traces::testing::TemporaryFile file("plain");
    test::write_view(file.path(), scene, grtx::test::front_camera(32, 16, 2.0), 32, 16, frontend::AccelKind::tlas_box,
                     options);
    for (const char* batch : {"simt.list_batch=32", "simt.list_batch=3"}) {
      const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/table1.toml", {batch});
      EXPECT_EQ(differences(file.path(), config), "") << capacity << " " << batch;
    }
  }
}

}  // namespace
}  // namespace grtx::sim
