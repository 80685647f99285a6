// SPDX-License-Identifier: Apache-2.0
// Several objects by three-level instancing: equal to one flat scene, any traversal setting, moving without rebuilding.
#include "grtx/frontend/accel/multi_object.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <set>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "temporary_folder.h"

namespace grtx::frontend {
namespace {

Scene object(unsigned seed, unsigned sh_degree = 0) {
  test::RandomSceneOptions o{.count = 120, .log_scale_mean = -2.0, .log_scale_sd = 0.7, .sh_degree = sh_degree};
  Scene scene = test::random_scene(seed, o);
  scene.offset = {10.0 + seed, -3.0, 0.5};
  return scene;
}

/// Two files, the first placed twice; `frame` moves them.
std::vector<Placement> placements(double frame = 0.0) {
  std::vector<Placement> list(3);
  list[0].translate = {-11.4 + 0.2 * frame, 3.0, 0.0};
  list[1].object = 1;
  list[1].rotate = glm::normalize(glm::dquat(0.9, 0.2 + 0.1 * frame, -0.3, 0.4));
  list[1].translate = -(glm::mat3_cast(list[1].rotate) * glm::dvec3(12.0, -3.0, 0.5)) + glm::dvec3(1.2, 0.3, 0.5);
  list[2].scale = 0.6;
  list[2].rotate = glm::normalize(glm::dquat(0.4, 0.1, 0.8, -0.2));
  list[2].translate =
      -0.6 * (glm::mat3_cast(list[2].rotate) * glm::dvec3(11.0, -3.0, 0.5)) + glm::dvec3(0.1, -0.8 + 0.1 * frame, 0.2);
  return list;
}

std::unique_ptr<MultiObjectWorld> world_of(const std::vector<Placement>& list, AccelKind kind = AccelKind::tlas_tri20,
                                           unsigned width = 6, unsigned sh_degree = 0) {
  std::vector<Scene> scenes;
  scenes.push_back(object(1, sh_degree));
  scenes.push_back(object(2, sh_degree));
  return std::make_unique<MultiObjectWorld>(std::move(scenes), list, AccelOptions{kind, width, false}, true);
}

RenderResult render(const MultiObjectWorld& world, const Camera& camera, const TracerOptions& options,
                    unsigned threads = 1) {
  RenderOptions render_options{.threads = threads, .keep_sequences = true};
  return frontend::render(TracedStructure(world), camera, options, render_options, nullptr);
}

Camera camera() { return test::front_camera(40, 32); }

TEST(MultiObject, EqualsTheFlattenedScene) {
  for (const AccelKind kind : {AccelKind::tlas_tri20, AccelKind::tlas_tri80, AccelKind::tlas_sphere}) {
    for (const bool peak : {false, true}) {
      TracerOptions options;
      options.sort_key = peak ? SortKey::peak : SortKey::entry;
      const auto world = world_of(placements(), kind);
      const RenderResult instanced = render(*world, camera(), options);
      const RenderResult flat = test::trace_scene(flatten(*world, placements()), camera(), kind, options);
      ASSERT_GT(flat.counters.blended, 2000u);
      EXPECT_GE(compare(instanced.image, flat.image).psnr, 80.0) << accel_name(kind);
      // Both round every hit's t, in different spaces: sequences may differ where two hits are that close.
      std::size_t different = 0;
      for (std::size_t p = 0; p < flat.sequences.size(); ++p) {
        if (flat.sequences[p] == instanced.sequences[p]) continue;
        ++different;
        const std::multiset<std::uint32_t> a(flat.sequences[p].begin(), flat.sequences[p].end());
        const std::multiset<std::uint32_t> b(instanced.sequences[p].begin(), instanced.sequences[p].end());
        EXPECT_EQ(a, b) << "pixel " << p;
      }
      EXPECT_LE(different, flat.sequences.size() / 200);
    }
  }
}

TEST(MultiObject, EverySettingGivesTheSameImage) {
  const auto world = world_of(placements());
  const RenderResult expected = render(*world, camera(), {});
  for (const unsigned width : {2u, 8u}) {
    const auto other = world_of(placements(), AccelKind::tlas_tri20, width);
    EXPECT_TRUE(compare(expected.image, render(*other, camera(), {}).image).identical()) << width;
  }
  for (const unsigned k : {1u, 4u, 64u}) {
    for (const CheckpointOrder order : {CheckpointOrder::fifo, CheckpointOrder::lifo, CheckpointOrder::nearest}) {
      for (const unsigned capacity : {2u, 1024u}) {
        TracerOptions options;
        options.k = k;
        options.checkpoint = true;
        options.checkpoint_capacity = capacity;
        options.checkpoint_order = order;
        const RenderResult actual = render(*world, camera(), options, 3);
        EXPECT_TRUE(compare(expected.image, actual.image).identical()) << "k " << k << " capacity " << capacity;
        EXPECT_EQ(expected.sequences, actual.sequences);
      }
    }
  }
}

TEST(MultiObject, OneUnmovedObjectIsTheSceneItself) {
  std::vector<Scene> scenes;
  scenes.push_back(object(4, 2));
  scenes.front().offset = glm::dvec3(0.0);
  const Scene alone = scenes.front();
  const MultiObjectWorld world(std::move(scenes), {Placement{}}, {AccelKind::tlas_tri20, 6, false}, true);
  const RenderResult expected = test::trace_scene(alone, camera(), AccelKind::tlas_tri20, {});
  const RenderResult actual = render(world, camera(), {});
  EXPECT_EQ(expected.sequences, actual.sequences);
  EXPECT_GE(compare(expected.image, actual.image).psnr, 100.0);  // SH: the direction is normalised again
}

TEST(MultiObject, SphericalHarmonicsTurnWithTheObject) {
  // Turning object and camera together changes nothing.
  const glm::dquat turn = glm::normalize(glm::dquat(0.7, 0.3, -0.5, 0.2));
  std::vector<RenderResult> results;
  for (const bool turned : {false, true}) {
    std::vector<Scene> scenes;
    scenes.push_back(object(4, 2));
    scenes.front().offset = glm::dvec3(0.0);
    Placement placement;
    Camera view = camera();
    if (turned) {
      placement.rotate = turn;
      view.rotation = glm::mat3_cast(turn) * view.rotation;
      view.position = glm::mat3_cast(turn) * view.position;
    }
    const MultiObjectWorld world(std::move(scenes), {placement}, {AccelKind::tlas_sphere, 6, false}, true);
    results.push_back(render(world, view, {}));
  }
  EXPECT_GE(compare(results[0].image, results[1].image).psnr, 80.0);
}

TEST(MultiObject, MovingChangesTheSceneTlasAlone) {
  const auto world = world_of(placements());
  const std::uint64_t scene_bytes = world->scene_tlas_bytes();
  const std::vector<std::uint8_t> before(world->image().data(), world->image().data() + world->image().size());
  const RenderResult first = render(*world, camera(), {});
  for (const double frame : {3.0, 1.0, 5.0, 0.0}) {
    world->move(placements(frame));
    const std::uint8_t* now = world->image().data();
    ASSERT_EQ(std::memcmp(now + scene_bytes, before.data() + scene_bytes, before.size() - scene_bytes), 0);
    EXPECT_EQ(std::memcmp(now, before.data(), scene_bytes) == 0, frame == 0.0);
    // The moved world is the world built there.
    const auto fresh = world_of(placements(frame));
    EXPECT_EQ(std::memcmp(now + scene_bytes, fresh->image().data() + scene_bytes, before.size() - scene_bytes), 0);
    const Scene flat = flatten(*world, placements(frame));
    const RenderResult moved = render(*world, camera(), {});
    EXPECT_GE(compare(moved.image, test::trace_scene(flat, camera(), AccelKind::tlas_tri20, {}).image).psnr, 80.0);
    EXPECT_EQ(compare(moved.image, first.image).identical(), frame == 0.0);
  }
}

TEST(MultiObject, AMoveCostsAShareOfARebuild) {
  std::vector<Scene> scenes;
  test::RandomSceneOptions o{.count = 20000, .sh_degree = 0};
  scenes.push_back(test::random_scene(1, o));
  MultiObjectWorld world(std::move(scenes), std::vector<Placement>(8), {AccelKind::tlas_tri20, 6, false}, true);
  std::vector<Placement> moved(8);
  for (std::size_t i = 0; i < 8; ++i) moved[i].translate = {static_cast<double>(i), 0, 0};
  double fastest = 1e9;
  for (int i = 0; i < 3; ++i) {
    world.move(moved);
    fastest = std::min(fastest, world.update_seconds());
  }
  RecordProperty("rebuild_over_move", std::to_string(world.build_seconds() / fastest));
  EXPECT_LT(fastest * 2.0, world.build_seconds());
}

/// A view's trace: written, checked, and its image.
struct Traced {
  traces::Header header;
  traces::Totals totals;
  RenderResult result;
};

Traced traced(const MultiObjectWorld& world, const TracerOptions& options) {
  const std::string path = testing::TempDir() + "/objects_" + std::to_string(::getpid()) + ".grtx";
  RenderOptions render{.threads = 2};
  Traced all;
  {
    traces::Writer writer(path, trace_header(world, camera(), options, render));
    all.result = frontend::render(TracedStructure(world), camera(), options, render, &writer);
    writer.finish();
  }
  const traces::Reader reader(path);
  all.header = reader.header();
  all.totals = traces::check(reader, true);
  std::filesystem::remove(path);
  return all;
}

TEST(MultiObject, TracesAreSoundAndCountWhatTheTracerCounts) {
  const auto world = world_of(placements());
  const RenderResult expected = render(*world, camera(), {});
  for (const bool checkpoint : {false, true}) {
    for (const CheckpointOrder order : {CheckpointOrder::fifo, CheckpointOrder::lifo, CheckpointOrder::nearest}) {
      for (const unsigned capacity : {3u, 1024u}) {
        TracerOptions options;
        options.k = 4;
        options.checkpoint = checkpoint;
        options.checkpoint_capacity = capacity;
        options.checkpoint_order = order;
        const Traced view = traced(*world, options);
        const TracerCounters& counters = view.result.counters;
        EXPECT_TRUE(compare(expected.image, view.result.image).identical());
        EXPECT_EQ(view.totals.visits_internal, counters.visits_internal);
        EXPECT_EQ(view.totals.visits_instance, counters.visits_instance);
        EXPECT_EQ(view.totals.visits_leaf, counters.visits_leaf);
        EXPECT_EQ(view.totals.blended, counters.blended);
        EXPECT_EQ(view.totals.checkpoints_read, counters.checkpoints_read);
        EXPECT_EQ(view.totals.checkpoints_read > 0, checkpoint);
        if (!checkpoint) break;
      }
      if (!checkpoint) break;
    }
  }
}

TEST(MultiObject, TheHeaderNamesWhereTheSceneTlasLeads) {
  const auto world = world_of(placements());
  const traces::Header header = trace_header(*world, camera(), {}, {});
  EXPECT_EQ(header.gaussians, 240u);  // records: the file that is placed twice has them once
  ASSERT_EQ(header.object_roots, (std::vector<std::uint64_t>{world->objects()[0]->root, world->objects()[1]->root}));
  EXPECT_EQ(header.objects_base(), world->scene_tlas_bytes());
  ASSERT_EQ(header.scene_leaves.size(), 3u);
  std::multiset<std::uint32_t> objects;
  for (const traces::SceneLeaf& leaf : header.scene_leaves) {
    objects.insert(leaf.object);
    const std::uint32_t placement = world->image().leaf_index(static_cast<std::uint32_t>(leaf.address / 64));
    EXPECT_EQ(placements()[placement].object, leaf.object);
  }
  EXPECT_EQ(objects, (std::multiset<std::uint32_t>{0, 0, 1}));
  EXPECT_EQ(world->update_bytes(), 64u + 64u + 3u * 128u);  // header, root, a leaf a placement
}

TEST(MultiObject, EventsEncodedAfterwardsGiveTheSameBytes) {
  const auto world = world_of(placements());
  const Camera view = camera();
  TracerOptions options;
  options.k = 4;
  options.checkpoint = true;
  const traces::Header header = trace_header(*world, view, options, {});
  const TracedStructure structure(*world);
  RayTracer encoding(structure, options), recording(structure, options);
  EncodingRecorder encoder(world->image(), header);
  GroupRecorder recorder(world->image(), &header);
  const auto groups = map_pixels(view.width, view.height, false);
  const auto trace = [&](RayTracer& tracer, auto& into, std::uint32_t group) {
    into.begin_group(group, traces::RayKind::primary);
    for (const std::uint32_t pixel : groups[group]) {
      into.begin_ray(pixel);
      const glm::dvec3 direction = view.direction(pixel % view.width, pixel / view.width);
      tracer.trace(TraceRay(glm::vec3(view.position - world->offset()), glm::vec3(direction)), into);
    }
    return into.end_group();
  };
  for (std::uint32_t group = 0; group < groups.size(); ++group) {
    EXPECT_TRUE(trace(encoding, encoder, group).chunk == trace(recording, recorder, group).chunk) << group;
  }
}

TEST(MultiObject, BadInputIsRefused) {
  EXPECT_THROW(world_of(placements(), AccelKind::tri20), Error);
  EXPECT_THROW(world_of({}), Error);
  auto missing = placements();
  missing[0].object = 7;
  EXPECT_THROW(world_of(missing), Error);
  const auto world = world_of(placements());
  auto fewer = placements();
  fewer.pop_back();
  EXPECT_THROW(world->move(fewer), Error);
  const auto coloured = world_of(placements(), AccelKind::tlas_tri20, 6, 1);
  EXPECT_THROW(flatten(*coloured, placements()), Error);
}

TEST(ObjectList, ReadsPlacementsAndRefusesWhatItDoesNotKnow) {
  const test::TemporaryFolder folder;
  const auto load = [&](const std::string& text) { return load_object_list(folder.write("objects.json", text)); };
  const ObjectList list = load(
      R"([{"file": "a.ply"}, {"file": "b.ply", "translate": [1, 2, 3], "rotate": [2, 0, 0, 0], "scale": 0.5},
          {"file": "a.ply", "scale": 2}])");
  ASSERT_EQ(list.files.size(), 2u);
  ASSERT_EQ(list.placements.size(), 3u);
  EXPECT_EQ(list.placements[2].object, 0u);
  EXPECT_EQ(list.placements[1].object, 1u);
  EXPECT_EQ(list.placements[1].translate, glm::dvec3(1, 2, 3));
  EXPECT_EQ(list.placements[1].rotate.w, 1.0);
  EXPECT_EQ(list.placements[1].scale, 0.5);
  for (const char* bad :
       {"{}", "[]", R"([{"file": 3}])", R"([{"translate": [0, 0, 0]}])", R"([{"file": "a", "turn": 1}])",
        R"([{"file": "a", "scale": 0}])", R"([{"file": "a", "rotate": [0, 0, 0, 0]}])",
        R"([{"file": "a", "translate": [1, 2]}])", "[3]", "nonsense"}) {
    EXPECT_THROW(load(bad), Error) << bad;
  }
}

}  // namespace
}  // namespace grtx::frontend
