// SPDX-License-Identifier: Apache-2.0
// The SystemC RT unit against the plain one (tests/rtl_tlm/plain), cycle by cycle: every retirement, any-hit batch and
// memory request.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>

#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "real_scene_files.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/rt_unit/plain_rt_bench.h"
#include "traces/random_group.h"

namespace grtx::sim {
namespace {

using namespace test;
using traces::testing::random_trace;
using traces::testing::RandomOptions;

/// Compares two event lists and names the first difference.
template <typename T, typename Print>
void expect_same(const char* what, const std::vector<T>& plain, const std::vector<T>& systemc, Print&& print) {
  const std::size_t common = std::min(plain.size(), systemc.size());
  for (std::size_t i = 0; i < common; ++i) {
    if (plain[i] == systemc[i]) continue;
    ADD_FAILURE() << what << " " << i << ": plain " << print(plain[i]) << ", SystemC " << print(systemc[i]);
    return;
  }
  EXPECT_EQ(plain.size(), systemc.size()) << what;
}

/// Returns how many requests for stack entries there were.
std::size_t expect_agreement(const traces::Header& header, const std::vector<traces::RayGroup>& groups,
                             BenchOptions options) {
  options.resident_warps = std::max<std::size_t>(options.resident_warps, groups.size());
  RtBench bench(header, options);
  PlainRtBench plain(header, options);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const bool any = std::any_of(groups[g].rays.begin(), groups[g].rays.end(),
                                 [](const traces::Ray& ray) { return !ray.rounds.empty(); });
    if (!any) continue;
    bench.launch(groups[g], static_cast<std::uint16_t>(g));
    plain.launch(groups[g], static_cast<unsigned>(g));
  }
  bench.run(50'000'000);
  plain.run(50'000'000);
  std::vector<PlainRtBench::Done> dones;
  for (const auto& d : bench.dones) dones.push_back({d.slot, d.round, d.cycle});
  std::vector<PlainRtBench::Batch> batches;
  for (const auto& b : bench.batches) batches.push_back({b.batch.slot, b.batch.round, b.batch.lanes, b.cycle});
  using fmt::format;
  for (unsigned c = 0; c < 4; ++c) {
    std::vector<PlainRtBench::Request> requests;
    for (const auto& r : bench.requests[c]) requests.push_back({r.request.address, r.request.write, r.cycle});
    const char* names[] = {"node request", "checkpoint request", "prefetch request", "stack request"};
    expect_same(names[c], plain.requests[c], requests, [](const PlainRtBench::Request& r) {
      return format("cycle {} {} {:#x}", r.cycle, r.write ? "write" : "read", r.address);
    });
  }
  expect_same("any-hit batch", plain.batches, batches, [](const PlainRtBench::Batch& b) {
    return format("cycle {} slot {} round {} lanes {:#x}", b.cycle, b.slot, b.round, b.lanes);
  });
  expect_same("retirement", plain.dones, dones, [](const PlainRtBench::Done& d) {
    return format("cycle {} slot {} round {}", d.cycle, d.slot, d.round);
  });
  return plain.requests[3].size();
}

/// Any configuration, from roomy to starved.
BenchOptions random_configuration(std::mt19937& random) {
  const auto one_of = [&](std::initializer_list<unsigned> values) {
    return *(values.begin() + std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random));
  };
  BenchOptions options;
  options.memory_latency = one_of({2, 3, 20, 117});
  options.any_hit_cycles = one_of({1, 10, 60});
  modules::RtUnitConfig& rt = options.rt;
  rt.warp_buffer.entries = one_of({1, 2, 4, 8});
  const char* policies[] = {"oldest_first", "round_robin", "greedy_then_oldest"};
  rt.scheduler.policy = policies[one_of({0, 1, 2})];
  rt.memory.queue = one_of({32, 40, 64});
  rt.memory.merge_in_flight = one_of({0, 1}) != 0;
  rt.memory.traffic.instance_leaf_bytes = one_of({64, 128});
  rt.memory.traffic.blas_header_read = one_of({0, 1}) != 0;
  rt.memory.traffic.leaf_descriptor_read = one_of({0, 1}) != 0;
  for (auto* unit : {&rt.ray_box, &rt.ray_triangle, &rt.ray_sphere, &rt.ray_transform}) {
    *unit = {one_of({1, 2, 4, 32}), one_of({1, 4, 13, 37}), one_of({1, 2, 5})};
  }
  rt.box_op_per_child = one_of({0, 1}) != 0;
  rt.any_hit.timeout = one_of({1, 5, 64, 1000});
  rt.checkpoint.lanes = one_of({1, 2, 4, 32});
  rt.checkpoint.write_queue = one_of({2, 3, 16});
  rt.checkpoint.write_combine = one_of({0, 1}) != 0;
  rt.checkpoint.read_buffer = one_of({0, 1}) != 0;
  rt.checkpoint.entry_bytes = one_of({8, 16, 20, 28});
  rt.sibling_prefetch = one_of({0, 1, 1}) != 0;
  rt.prefetcher = {one_of({1, 4}), one_of({2, 32}), one_of({0, 1}) != 0};
  rt.warp_buffer.spill = one_of({0, 1, 1}) != 0;
  rt.warp_buffer.stack_entries = one_of({2, 3, 4, 8});
  if (rt.memory.traffic.leaf_descriptor_read) rt.memory.traffic.descriptor_wait = one_of({0, 0, 1, 4, 40});
  if (rt.memory.traffic.blas_header_read) rt.memory.traffic.header_wait = one_of({0, 0, 1, 8, 40});
  rt.memory.oldest_warp_first = one_of({0, 1}) != 0;
  return options;
}

class RtUnitPlainDirected : public modules::SystemCTest {};

class RtUnitPlain : public modules::SystemCTest, public ::testing::WithParamInterface<unsigned> {};

// 20 x 50 = 1,000 random traces, each with a configuration of its own.
TEST_P(RtUnitPlain, AgreesToTheCycle) {
  for (unsigned i = 0; i < 50 && !HasFailure(); ++i) {
    const unsigned seed = GetParam() * 50 + i;
    std::mt19937 random(seed);
    const auto pick = [&](unsigned most) { return std::uniform_int_distribution<unsigned>(0, most)(random); };
    RandomOptions trace;
    trace.seed = seed;
    trace.groups = 1 + pick(5);
    trace.warp_size = pick(3) == 0 ? 32 : 8;
    trace.bvh_width = 2 + pick(6);
    trace.depth = trace.warp_size * trace.bvh_width > 64 ? 2 : 3;  // wide trees of full warps take long
    trace.k = 1 + pick(7);
    trace.checkpoint = pick(3) != 0;
    trace.capacity = pick(3) == 0 ? 6 : 1000;
    trace.checkpoint_order = pick(2) == 0 ? traces::CheckpointOrder::lifo : traces::CheckpointOrder::fifo;
    trace.two_level = pick(1) != 0;
    if (trace.two_level && seed % 3 == 0) {
      trace.objects = 1 + seed % 4;
      trace.depth = 2;
    }
    trace.blas_root_is_leaf = trace.two_level && pick(4) == 0;
    if (seed % 4 == 3) trace.layout = traces::NodeLayout::compact;
    if (seed % 8 == 6) trace.layout = traces::NodeLayout::compressed;
    if (seed % 8 == 2 && trace.bvh_width <= traces::kQuantisedWidth) trace.layout = traces::NodeLayout::quantised;
    trace.wide = trace.layout == traces::NodeLayout::quantised && (trace.two_level || seed % 16 == 2);
    BenchOptions configuration = random_configuration(random);
    trace.child_order = enum_names(traces::ChildOrder{})[pick(2)].value;
    trace.pop_test = pick(1) == 0 ? traces::PopTest::off : traces::PopTest::on;
    if (trace.pop_test == traces::PopTest::off) {  // four entries of its stack fill a sector
      unsigned& stack = configuration.rt.warp_buffer.stack_entries;
      stack = std::max(stack, 4u);
    }
    SCOPED_TRACE(traces::testing::describe(trace));
    const auto made = random_trace(trace);
    expect_agreement(made.header, made.groups, configuration);
  }
}
// Warps that walk together, on structures of one level.
TEST_P(RtUnitPlain, AgreesToTheCycleWhereWarpsWalkTogether) {
  std::size_t spilled = 0;
  for (unsigned i = 0; i < 50 && !HasFailure(); ++i) {
    const unsigned seed = GetParam() * 50 + i + 5000;
    std::mt19937 random(seed);
    const auto pick = [&](unsigned most) { return std::uniform_int_distribution<unsigned>(0, most)(random); };
    RandomOptions trace;
    trace.seed = seed;
    trace.groups = 1 + pick(5);
    trace.warp_size = pick(2) == 0 ? 32 : 8;
    trace.bvh_width = 2 + pick(6);
    trace.depth = trace.warp_size * trace.bvh_width > 64 ? 2 : 3;
    trace.k = 1 + pick(7);
    trace.checkpoint = false;
    trace.root_is_leaf = pick(20) == 0;
    if (seed % 4 == 3) trace.layout = traces::NodeLayout::compact;
    if (seed % 8 == 6) trace.layout = traces::NodeLayout::compressed;
    if (seed % 8 == 2 && trace.bvh_width <= traces::kQuantisedWidth) trace.layout = traces::NodeLayout::quantised;
    trace.wide = trace.layout == traces::NodeLayout::quantised && (trace.two_level || seed % 16 == 2);
    trace.child_order = enum_names(traces::ChildOrder{})[pick(2)].value;
    trace.pop_test = pick(1) == 0 ? traces::PopTest::off : traces::PopTest::on;
    BenchOptions configuration = random_configuration(random);
    modules::RtUnitConfig& rt = configuration.rt;
    rt.traversal = modules::TraversalWay::warp;
    rt.warp_buffer.spill = true;
    constexpr unsigned kEntries[] = {10, 11, 16, 64}, kAhead[] = {1, 2, 5, 8, 32};
    rt.warp_stack = {kEntries[pick(3)], kAhead[pick(4)]};
    constexpr unsigned kWindows[] = {16, 0, 1, 4}, kWritePorts[] = {1, 0, 3}, kTests[] = {256, 0, 1, 7};
    rt.warp_stack.window = kWindows[pick(3)];
    rt.warp_stack.write_ports = kWritePorts[pick(2)];
    rt.warp_stack.tests = kTests[pick(3)];
    rt.gaussian_unit = pick(1) == 0;
    rt.any_hit_unit.enabled = pick(1) == 0;
    rt.any_hit_unit.count = 1 + pick(31);
    const unsigned leaves = pick(3);
    trace.procedural = leaves > 1 && trace.layout == traces::NodeLayout::quantised;  // their size differs
    auto made = random_trace(trace);
    if (leaves > 1) make_procedural(made, leaves == 3);
    if (leaves == 3) rt.any_hit_unit.enabled = false;  // hits of boxes come from a shader
    SCOPED_TRACE(traces::testing::describe(trace));
    spilled += expect_agreement(made.header, made.groups, configuration);
  }
  EXPECT_GT(spilled, 0u);
}
INSTANTIATE_TEST_SUITE_P(Traces, RtUnitPlain, ::testing::Range(0u, 20u));

// Trees do not lead there: a leaf whose node is visited in a round has no BLAS node in that round's source buffer.
TEST_F(RtUnitPlainDirected, AReplayedBlasNodeAsksForItsLeafAsAnyVisitDoes) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::instance, NodeKind::instance})};
  group.rays.resize(1);
  constexpr std::uint32_t kBlasLeaf = (1 << 19) / traces::kNodeUnit + 1;
  group.nodes.push_back(node_definition(2, 1, {NodeKind::internal}));
  add_round(group.rays[0], {internal_event(1, 0b1, 0b1), cull_event(1, 1)});
  add_round(group.rays[0],
            {take_event(1), internal_event(0, 0b11), cull_event(12, 0), cull_event(10, 0), take_event(kBlasLeaf),
             instance_event(10, 1), leaf_event(kBlasLeaf, LeafOutcome::miss)},
            true);
  expect_agreement(small_header("tlas-tri20", 64), {group}, {});
}

frontend::RenderOptions one_thread() {
  frontend::RenderOptions render;
  render.threads = 1;
  return render;
}

/// Warps of a view, whose trace has this header, on the default configuration.
void expect_agreement_on(const frontend::TracedStructure& structure, const traces::Header& header,
                         const frontend::Camera& camera, const frontend::TracerOptions& options) {
  const std::string path = ::testing::TempDir() + "/plain_" + std::to_string(::getpid()) + ".grtx";
  traces::Writer writer(path, header);
  frontend::render(structure, camera, options, one_thread(), &writer);
  writer.finish();
  const traces::Reader reader(path);
  std::vector<traces::RayGroup> groups(reader.group_count());
  for (std::size_t g = 0; g < groups.size(); ++g) reader.read(g, groups[g]);
  std::filesystem::remove(path);
  expect_agreement(header, groups, {});
  if (!options.checkpoint || !header.two_level) return;  // one design is enough for what none of them has by default
  BenchOptions spilling;
  spilling.rt.warp_buffer.spill = true;
  spilling.rt.warp_buffer.stack_entries = 4;
  expect_agreement(header, groups, spilling);
}

/// The same of a scene, traced for one design.
void expect_agreement_on(const frontend::Scene& scene, frontend::Camera camera, frontend::AccelKind kind,
                         const frontend::TracerOptions& options, traces::NodeLayout layout) {
  camera = camera.resized(32, 16);
  const frontend::PreparedGaussians gaussians(scene, options.kernel, frontend::is_quantised(layout));
  const frontend::AccelerationStructure accel(gaussians, {kind, traces::default_width(layout), false, 8, layout});
  expect_agreement_on({scene, gaussians, accel}, frontend::trace_header(scene, camera, accel, options, one_thread()),
                      camera, options);
}

class RtUnitPlainScene : public modules::SystemCTest {
 protected:
  static void all_designs(const frontend::Scene& scene, const frontend::Camera& camera) {
    for (const auto layout : {traces::NodeLayout::vulkan_sim, traces::NodeLayout::compact,
                              traces::NodeLayout::compressed, traces::NodeLayout::quantised}) {
      for (const auto kind : {frontend::AccelKind::tri20, frontend::AccelKind::tlas_tri20}) {
        for (const bool checkpoint : {false, true}) {
          SCOPED_TRACE(frontend::accel_name(kind) + (checkpoint ? " with checkpoints " : " ") +
                       std::string(name_of(layout)));
          frontend::TracerOptions options;
          options.checkpoint = checkpoint;
          const bool every_design = layout == traces::NodeLayout::vulkan_sim || layout == traces::NodeLayout::compact;
          if (!every_design && checkpoint != traces::is_two_level(kind)) continue;
          expect_agreement_on(scene, camera, kind, options, layout);
          if (!every_design) continue;
          options.child_order = traces::ChildOrder::vulkan_sim;
          options.pop_test = traces::PopTest::off;
          expect_agreement_on(scene, camera, kind, options, layout);
        }
      }
    }
  }
};

TEST_F(RtUnitPlainScene, GeneratedRoom) {
  const std::string path = ::testing::TempDir() + "/plain_room_" + std::to_string(::getpid()) + ".ply";
  frontend::synthesise({"flat", 3000, 5, 1}, path);
  const std::string cameras = std::filesystem::path(path).replace_extension(".cameras.json").string();
  all_designs(frontend::load_scene(path), frontend::load_cameras(cameras)[0]);
  std::filesystem::remove(path);
  std::filesystem::remove(cameras);
}

TEST_F(RtUnitPlainScene, GeneratedObjects) {
  const std::string path = ::testing::TempDir() + "/plain_objects_" + std::to_string(::getpid()) + ".ply";
  frontend::synthesise({"object", 800, 5, 1}, path);
  const std::string cameras = std::filesystem::path(path).replace_extension(".cameras.json").string();
  const frontend::Camera camera = frontend::load_cameras(cameras)[0].resized(32, 16);
  std::vector<frontend::Placement> placements(3);
  placements[1].translate = {0.5, 0.1, -0.2};
  placements[1].scale = 0.7;
  placements[2].translate = {-0.4, 0.0, 0.3};
  placements[2].rotate = glm::normalize(glm::dquat(0.8, 0.1, 0.5, 0.0));
  for (const auto kind : {frontend::AccelKind::tlas_tri20, frontend::AccelKind::tlas_sphere}) {
    for (const auto layout :
         {traces::NodeLayout::vulkan_sim, traces::NodeLayout::compact, traces::NodeLayout::compressed}) {
      std::vector<frontend::Scene> scenes;
      scenes.push_back(frontend::load_scene(path));
      const frontend::MultiObjectWorld world(std::move(scenes), placements,
                                             {kind, traces::default_width(layout), false, 8, layout}, {});
      for (const bool checkpoint : {false, true}) {
        SCOPED_TRACE(frontend::accel_name(kind) + (checkpoint ? " with checkpoints " : " ") +
                     std::string(name_of(layout)));
        frontend::TracerOptions options;
        options.checkpoint = checkpoint;
        const traces::Header header = frontend::trace_header(world, camera, options, one_thread());
        expect_agreement_on(frontend::TracedStructure(world), header, camera, options);
      }
    }
  }
  std::filesystem::remove(path);
  std::filesystem::remove(cameras);
}

TEST_F(RtUnitPlainScene, TrainedScene) {
  const std::string path = grtx::test::real_scene_path("playbot_L4");
  const std::string cameras = grtx::test::real_cameras_path("playbot");
  if (path.empty() || cameras.empty()) GTEST_SKIP() << "no trained scenes: name their folder in GRTX_SCENES";
  all_designs(frontend::load_scene(path), frontend::load_cameras(cameras)[0]);
}

}  // namespace
}  // namespace grtx::sim
