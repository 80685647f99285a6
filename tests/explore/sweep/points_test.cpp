// SPDX-License-Identifier: Apache-2.0
// What decides a point's key: everything it is made from, and nothing else.
#include "grtx/explore/sweep/points.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <filesystem>
#include <functional>
#include <tuple>
#include <vector>

#include "explore/sweep/fake_tracer_rules.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/hash.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "temporary_folder.h"

namespace grtx::explore {
namespace {

class SweepPointsTest : public testing::Test {
 protected:
  SweepPointsTest() {
    write_file(folder + "/s.ply", "scene");
    write_file(folder + "/c.json", "cameras");
  }
  SweepPlan plan() const {
    SweepPlan plan;
    plan.points = {{}};
    plan.scenes.emplace_back();
    plan.scenes[0].name = "s";
    plan.scenes[0].file = folder + "/s.ply";
    plan.scenes[0].cameras = folder + "/c.json";
    return plan;
  }
  SweepPoints points(const SweepPlan& plan, const std::string& program = "grtx 1") const {
    return expand(plan, test::FakeTracerRules(), program);
  }
  const grtx::test::TemporaryFolder own_folder;
  const std::string folder = own_folder.path();
};

TEST_F(SweepPointsTest, APointMayNameItsDesignAndChangeIt) {
  SweepPlan named = plan(), varied = plan();
  named.designs = {"walk"};
  varied.points = {{{"design", "walk"}}, {{"design", "walk"}, {"tracer.k", 16}}, {{"tracer.accel", "tri20"}}};
  varied.designs = {};
  const SweepPoints expected = points(named), made = points(varied);
  ASSERT_EQ(made.points.size(), 3u);
  EXPECT_EQ(made.points[0].key, expected.points.at(0).key);
  EXPECT_EQ(made.points[1].design, "walk");
  EXPECT_EQ(made.points[1].config.json().at("simt.payload_registers"), 48);
  EXPECT_EQ(made.points[2].design, "baseline");
}

TEST_F(SweepPointsTest, EveryInputChangesTheKeyOfThePoint) {
  const SweepPoints base = points(plan());
  const struct {
    const char* what;
    bool traced_anew;
    std::function<void(SweepPlan&)> change;
  } cases[] = {
      {"scene", true, [&](SweepPlan&) { write_file(folder + "/s.ply", "other"); }},
      {"cameras", true, [&](SweepPlan&) { write_file(folder + "/c.json", "other"); }},
      {"view", true, [](SweepPlan& p) { p.scenes[0].views = {1}; }},
      {"width", true, [](SweepPlan& p) { p.scenes[0].width = 5; }},
      {"fov", true, [](SweepPlan& p) { p.scenes[0].fov_scale = 0.5; }},
      {"k", true,
       [](SweepPlan& p) {
         p.settings = {{"tracer.k", 4}};
       }},
      {"design", true, [](SweepPlan& p) { p.designs = {"hw"}; }},
      {"key", false,
       [](SweepPlan& p) {
         p.settings = {{"l1.latency", 21}};
       }},
      {"axis", false,
       [](SweepPlan& p) {
         p.points = {{{"l1.latency", 21}}};
       }},
      {"mode", false, [](SweepPlan& p) { p.mode = "windows"; }},
      {"machine", false, [](SweepPlan& p) { p.machine.name = "paper-charged"; }},
  };
  for (const auto& c : cases) {
    SweepPlan changed = plan();
    c.change(changed);
    const SweepPoints other = points(changed);
    EXPECT_NE(other.points.at(0).key, base.points.at(0).key) << c.what;
    EXPECT_EQ(other.traces.at(0)->key != base.traces.at(0)->key, c.traced_anew) << c.what;
    write_file(folder + "/s.ply", "scene");
    write_file(folder + "/c.json", "cameras");
  }
  EXPECT_NE(points(plan(), "grtx 2").points.at(0).key, base.points.at(0).key);
}

TEST_F(SweepPointsTest, AMachineIsAnAxisAndItsTraceIsSharedWhereTheTracerIsTheSame) {
  SweepPlan p = plan();
  p.machine.name = "base";
  sim::GpuConfig many;
  many.sms = 99;
  p.machines = {{"a", {"a", "a", {}, {}, {{"ert", "0.1"}}}},
                {"b", {"b", "b", many, {}, {{"ert", "0.1"}}}},
                {"folder/c.toml", {"c", "/folder/c.toml", {}, {}, {{"ert", "0.2"}}}}};
  p.points = {{{"machine", "a"}}, {{"machine", "b"}}, {{"machine", "folder/c.toml"}}, {{"l1.latency", 21}}};
  const SweepPoints all = points(p);
  ASSERT_EQ(all.points.size(), 4U);
  EXPECT_EQ(all.traces.size(), 3U);  // a and b share one
  const std::vector<std::string> names = {"a", "b", "c", "base"}, options = {"a", "b", "/folder/c.toml", ""};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(all.points[i].machine, names[i]);
    EXPECT_EQ(all.points[i].machine_option, options[i]);
    EXPECT_FALSE(all.points[i].coordinates.contains("machine"));  // which each point says itself
  }
  EXPECT_EQ(all.points[0].trace_key, all.points[1].trace_key);
  EXPECT_EQ(all.points[1].config.json().at("gpu.sms"), 99);
  EXPECT_NE(all.points[0].config.json().at("gpu.sms"), 99);
}

TEST_F(SweepPointsTest, AChangedFileThatConfiguresTheMemoryIsAnotherPoint) {
  sim::register_memory_system(
      "by_file", [](sim::Gpu&, const sim::BuildOptions&) { return std::unique_ptr<sim::MemorySystem>(); }, true);
  SweepPlan by_file = plan();
  by_file.settings = {{"dram.model", "by_file"}, {"dram.simulator.config", folder + "/memory.yaml"}};
  EXPECT_NE(points(by_file).points.at(0).broken, "");  // no such file
  write_file(folder + "/memory.yaml", "CL: 20");
  const SweepPoint before = points(by_file).points.at(0);
  EXPECT_EQ(before.broken, "");
  write_file(folder + "/memory.yaml", "CL: 21");
  const SweepPoint changed = points(by_file).points.at(0);
  EXPECT_EQ(changed.config.text(), before.config.text());
  EXPECT_NE(changed.key, before.key);
}

/// A tracer that knows how the file format depends on what is traced.
class FormatRules final : public TracerRules {
 public:
  void check(const std::string&, const std::string&) const override {}
  std::map<std::string, std::string> resolve(const std::map<std::string, std::string>& options, const std::string&,
                                             bool) const override {
    return options;
  }
  std::string structure(const std::map<std::string, std::string>&, const std::string& accel) const override {
    return accel;
  }
  SceneInput input(const std::string& scene, const std::string&) const override {
    return {"same", scene.ends_with(".json")};
  }
};

TEST_F(SweepPointsTest, TheKeyHasTheVersionThatIsWrittenAndNotTheHighestKnown) {
  const auto format = [&](const std::string& scene, const Coordinates& options) {
    SweepPlan p = plan();
    p.scenes[0].file = scene;
    p.settings = options;
    return expand(p, FormatRules(), "grtx 1").traces.at(0)->options.at("trace_format").get<unsigned>();
  };
  EXPECT_EQ(format("s.ply", {}), 4U);
  EXPECT_EQ(format("s.ply", {{"tracer.pop_test", "off"}}), 5U);
  EXPECT_EQ(format("s.ply", {{"tracer.child_order", "vulkan_sim"}}), 5U);
  EXPECT_EQ(format("objects.json", {}), 6U);
  EXPECT_EQ(format("s.ply", {{"tracer.accel", "box"}}), 8U);
  EXPECT_EQ(format("s.ply", {{"tracer.checkpoint_bins", 4}}), 9U);
  EXPECT_EQ(format("s.ply", {{"tracer.tracing", "list"}}), 10U);
  EXPECT_EQ(format("s.ply", {{"tracer.any_hit", "delayed"}}), 11U);
  EXPECT_EQ(format("s.ply", {{"tracer.ert_check", "round"}}), 11U);
  EXPECT_EQ(format("s.ply", {{"tracer.ahead", 4}}), 12U);
  EXPECT_EQ(format("s.ply", {{"tracer.opacity_bound", "on"}}), 14U);
  EXPECT_EQ(format("s.ply", {{"tracer.sh_dir", "centre"}, {"tracer.colour", "frame"}}), 16U);
}

TEST_F(SweepPointsTest, WhatIsSaidOtherwiseButResolvesTheSameIsOnePoint) {
  const SweepPoints base = points(plan());
  SweepPlan other = plan();
  std::filesystem::rename(folder + "/s.ply", folder + "/moved.ply");
  other.scenes[0].file = folder + "/moved.ply";
  other.settings = {{"tracer.k", 16}, {"l1.latency", 20}};  // the design's, and the default
  other.points = {{}, {{"gpu.sms", 8}}};
  const SweepPoints same = points(other);
  ASSERT_EQ(same.points.size(), 1U);
  EXPECT_EQ(same.points[0].key, base.points[0].key);
}

TEST_F(SweepPointsTest, PointsShareTheTraceThatTheyCanShare) {
  SweepPlan p = plan();
  p.points.clear();
  for (const int k : {4, 8}) {
    for (const int latency : {10, 20, 30}) p.points.push_back({{"tracer.k", k}, {"l1.latency", latency}});
  }
  const SweepPoints all = points(p);
  EXPECT_EQ(all.points.size(), 6U);
  ASSERT_EQ(all.traces.size(), 2U);
  EXPECT_EQ(all.points[2].trace_key, all.traces[0]->key);
  EXPECT_EQ(all.points[3].trace_key, all.traces[1]->key);
  EXPECT_EQ(all.points[4].coordinates.dump(), R"({"tracer.k":8,"l1.latency":20})");
  EXPECT_EQ(all.points[4].config.json().at("l1.latency"), 20);
}

TEST_F(SweepPointsTest, ACombinationThatNothingTakesIsAPointWithAReason) {
  SweepPlan p = plan();
  p.points = {{{"l1.bytes", 64}}, {{"tracer.k", 1}}, {{"l1.latency", 30}}};
  const SweepPoints all = points(p);
  ASSERT_EQ(all.points.size(), 3U);
  EXPECT_NE(all.points[0].broken.find("l1.bytes: must hold at least l1.ways lines"), std::string::npos);
  EXPECT_NE(all.points[1].broken.find("nothing to checkpoint"), std::string::npos);
  EXPECT_EQ(all.points[2].broken, "");
}

TEST_F(SweepPointsTest, AConfigurationGoesThroughItsFile) {
  SweepPlan p = plan();
  p.points = {{{"rt.scheduler.policy", "round_robin"}, {"gpu.core_mhz", 999.5}, {"l2.xor_hash", true}}};
  const SweepPoint point = points(p).points.at(0);
  write_config(folder + "/config.toml", point.config.json());
  EXPECT_EQ(sim::config_json(sim::load_config(folder + "/config.toml", {})), point.config.json());
}

// Databases hold keys: how they are made must not change them.
TEST_F(SweepPointsTest, AKeyIsTheHashOfTheInputsAsOneDocument) {
  SweepPlan p = plan();
  p.mode = "windows";
  p.machine.name = "own";
  p.points = {{{"rt.scheduler.policy", "round_robin"}, {"gpu.core_mhz", 999.5}, {"tracer.k", 16}}};
  const SweepPoint point = points(p, "grtx \"1\"").points.at(0);
  sim::GpuConfig config;
  config.core_mhz = 999.5;
  config.rt.scheduler.policy = "round_robin";
  EXPECT_EQ(point.config.text(), sim::config_json(config).dump());
  const nlohmann::ordered_json inputs = {{"trace", point.trace_key},
                                         {"config", sim::config_json(config)},
                                         {"machine", "own"},
                                         {"mode", "windows"},
                                         {"program", "grtx \"1\""}};
  EXPECT_EQ(point.key, hex(xxh3(inputs.dump())));
}

/// Counts how often it is asked.
class CountingRules final : public TracerRules {
 public:
  void check(const std::string&, const std::string&) const override {}
  std::map<std::string, std::string> resolve(const std::map<std::string, std::string>& options,
                                             const std::string& accel, bool checkpoint) const override {
    ++asked;
    return test::FakeTracerRules().resolve(options, accel, checkpoint);
  }
  std::string structure(const std::map<std::string, std::string>&, const std::string& accel) const override {
    return accel;
  }
  SceneInput input(const std::string&, const std::string&) const override { return {"same", false}; }
  mutable unsigned asked = 0;
};

TEST_F(SweepPointsTest, TheTracerIsAskedOnceForEachTrace) {
  SweepPlan p = plan();
  p.designs = {"sw", "grtx"};
  p.points.clear();
  for (const int latency : {10, 20, 30}) {
    for (const int k : {4, 8}) p.points.push_back({{"l1.latency", latency}, {"tracer.k", k}});
  }
  CountingRules rules;
  EXPECT_EQ(expand(p, rules, "grtx 1").points.size(), 12U);
  EXPECT_EQ(rules.asked, 4U);
}

TEST_F(SweepPointsTest, RegistersOfHeapsFollowK) {
  SweepPlan p = plan();
  p.designs = {"gautracer"};
  p.points = {{}, {{"tracer.k", 16}}, {{"tracer.k", 16}, {"simt.payload_registers", 60}}};
  const auto all = points(p).points;
  ASSERT_EQ(all.size(), 3U);
  std::vector<int> registers;
  for (const auto& point : all) registers.push_back(point.config.json().at("simt.payload_registers"));
  EXPECT_EQ(registers, (std::vector<int>{144, 48, 60}));
}

/// A plan of 100,000 points took 1.9 GB, nearly all of it configurations.
TEST_F(SweepPointsTest, APointKeepsWhatItSetsAndNotAConfiguration) {
  SweepPlan p = plan();
  p.points.clear();
  for (int i = 0; i < 4000; ++i) p.points.push_back({{"l1.latency", 10 + i % 1000}, {"rt.box.count", 1 + i / 1000}});
  const std::size_t before = ::mallinfo2().uordblks;
  const SweepPoints all = points(p);
  const std::size_t after = ::mallinfo2().uordblks;
  ASSERT_EQ(all.points.size(), 4000U);
  if (after == 0) GTEST_SKIP() << "this allocator does not say what is in use";
  EXPECT_LT((after - before) / all.points.size(), 1500U) << "bytes per point";
}

/// 100,000 points that waited took 464 MB of database, nearly all of it configurations.
TEST_F(SweepPointsTest, WaitsInTheDatabaseWithoutAConfiguration) {
  SweepPlan p = plan();
  p.points.clear();
  for (int i = 0; i < 2000; ++i) p.points.push_back({{"l1.latency", 10 + i % 1000}, {"rt.box.count", 1 + i / 1000}});
  const SweepPoints all = points(p);
  const std::string path = folder + "/a.sqlite";
  SweepDatabase database(path);
  database.add(all);
  EXPECT_LT(std::filesystem::file_size(path) / all.points.size(), 1000U) << "bytes per point";
  EXPECT_EQ(database.statuses_of(all.points), std::vector<std::string>(2000, "pending"));

  database.set_running({point_task(all.points[7], "grtx", folder, {})});
  database.refuse({{&all.points[8], "no such machine"}, {&all.points[9], "no trace"}});
  Sqlite read(path, Sqlite::Open::read_only);
  SqliteStatement row(read, "SELECT id, status, config, reason FROM point WHERE config IS NOT NULL ORDER BY id");
  for (const auto& [index, status, reason] :
       {std::tuple(7U, "running", ""), std::tuple(8U, "failed", "no such machine"),
        std::tuple(9U, "failed", "no trace")}) {
    ASSERT_TRUE(row.step());
    EXPECT_EQ(row.integer(0), index + 1);
    EXPECT_EQ(row.text(1), status);
    EXPECT_EQ(row.text(2), all.points[index].config.text());
    EXPECT_EQ(row.text(3), reason);
  }
  EXPECT_FALSE(row.step());
}

}  // namespace
}  // namespace grtx::explore
