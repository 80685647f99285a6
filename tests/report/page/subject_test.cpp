// SPDX-License-Identifier: Apache-2.0
// What of two results must be the same for their figures to be put together, and how results are called.
#include "grtx/report/page/subject.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using testing::ElementsAre;
using testing::IsEmpty;

/// Inputs as grtx sim writes them.
ordered_json inputs(const ordered_json& more = ordered_json::object()) {
  ordered_json all = {{"trace.scene", "scenes/hall.ply"},
                      {"trace.scene_hash", "5ce"},
                      {"trace.camera", "0"},
                      {"trace.camera_hash", "ca0"},
                      {"trace.fov_scale", "1"},
                      {"trace.ert", "0.01"},
                      {"trace.k", "8"},
                      {"trace.accel", "tri20"},
                      {"trace.checkpoint", "off"},
                      {"trace.checkpoint_capacity", "1024"},
                      {"accel", "tri20"},
                      {"checkpoint", "off"},
                      {"k", "8"},
                      {"width", "64"},
                      {"height", "32"},
                      {"trace_hash", "1"},
                      {"mode", "cycle"},
                      {"machine", "paper"}};
  if (more.is_object()) all.update(more);
  return all;
}

Subject subject(const ordered_json& more = ordered_json::object(), const ordered_json& config = {{"l1.bytes", 1}}) {
  return Subject(inputs(more), config, {{"model_version", "7"}});
}

std::vector<std::string> names(const std::vector<Fact>& facts) {
  std::vector<std::string> list;
  for (const Fact& fact : facts) list.push_back(fact.name + ": " + fact.value);
  return list;
}

const ordered_json kGrtx = {{"accel", "tlas-tri20"},    {"trace.accel", "tlas-tri20"}, {"checkpoint", "on"},
                            {"trace.checkpoint", "on"}, {"trace_hash", "2"},           {"trace.checkpoint_bins", "4"}};

TEST(Subject, DesignsOfOneViewOnOneMachineAreAlike) {
  EXPECT_THAT(names(subject().differences(subject(kGrtx), MayDiffer::designs)), IsEmpty());
  EXPECT_EQ(subject().unknown(), "");
  EXPECT_EQ(subject().text(), "hall, view 0, 64 × 32, k = 8, machine paper, mode cycle, model version 7");
}

TEST(Subject, WhateverElseDiffersIsNamed) {
  struct Case {
    ordered_json other;
    const char* fact;  ///< of the other
  };
  for (const Case& c :
       {Case{{{"width", "16"}, {"trace.camera_hash", "c16"}}, "size: 16 × 32"},
        Case{{{"trace.fov_scale", "0.5"}, {"trace.camera_hash", "c5"}}, "fov_scale: 0.5"},
        Case{{{"trace.ert", "0.5"}}, "ert: 0.5"}, Case{{{"trace.secondary", "glass"}}, "secondary: glass"},
        Case{{{"mode", "windows"}}, "mode: windows"}, Case{{{"groups", "4 of 8"}}, "groups: 4 of 8"},
        Case{{{"warm", "1"}, {"warm.camera_hash", "ca0"}}, "warm.camera_hash: ca0"},
        Case{{{"k", "16"}, {"trace.k", "16"}}, "k: 16"},
        Case{{{"trace.camera", "7"}, {"trace.camera_hash", "ca7"}}, "view: 7"},
        Case{{{"trace.camera_hash", "ca7"}}, "camera_hash: ca7"},  // two cameras of one name
        Case{{{"trace.scene", "room.ply"}, {"trace.scene_hash", "400"}}, "scene: room"},
        Case{{{"trace.scene_hash", "400"}}, "scene_hash: 400"},  // the file was edited
        Case{{{"machine", "modern"}}, "machine: modern"}}) {
    EXPECT_THAT(names(subject(c.other).differences(subject(kGrtx), MayDiffer::designs)), ElementsAre(c.fact));
  }
  EXPECT_THAT(names(subject(ordered_json::object(), {{"l1.bytes", 2}}).differences(subject(), MayDiffer::designs)),
              ElementsAre("l1.bytes: 2"));
  EXPECT_THAT(
      names(Subject(inputs(), {{"l1.bytes", 1}}, {{"model_version", "6"}}).differences(subject(), MayDiffer::designs)),
      ElementsAre("model_version: 6"));
}

// What checkpoints read says nothing of a design without them.
TEST(Subject, OptionsOfCheckpointsAreComparedWhereBothHaveThem) {
  const Subject grtx = subject(kGrtx);
  ordered_json fewer = kGrtx;
  fewer["trace.checkpoint_capacity"] = "1";
  EXPECT_THAT(names(subject(fewer).differences(subject(), MayDiffer::designs)), IsEmpty());
  EXPECT_THAT(names(subject(fewer).differences(grtx, MayDiffer::designs)), ElementsAre("checkpoint_capacity: 1"));
}

const ordered_json kGauTracer = {{"accel", "ellipsoid"}, {"trace.accel", "ellipsoid"}, {"k", "48"},
                                 {"trace.k", "48"},      {"trace.sort_key", "peak"},   {"trace.tmax_update", "kth"},
                                 {"trace_hash", "3"},    {"machine", "paper, changed"}};

/// The configuration of GauTracer's units, or the same keys at rest.
ordered_json units(bool on, unsigned registers = 32, unsigned l1_bytes = 1, unsigned k = 48) {
  return {{"l1.bytes", l1_bytes},
          {"rt.gaussian.enabled", on},
          {"rt.any_hit_unit.enabled", on},
          {"simt.registers_per_thread", on ? registers : 0},
          {"simt.payload_registers", on ? 3 * k : 0}};
}

// Statistics of gautracer stood apart from those of the other designs: k, its order of hits and its units differ.
TEST(Subject, WhatADesignBringsIsNoDifference) {
  const Subject baseline = subject(ordered_json::object(), units(false)), gautracer = subject(kGauTracer, units(true));
  EXPECT_THAT(names(gautracer.differences(baseline, MayDiffer::designs)), IsEmpty());
  EXPECT_THAT(names(baseline.differences(gautracer, MayDiffer::designs)), IsEmpty());
  // Another value than the one that it brings, or another key.
  ordered_json wide = kGauTracer;
  wide["k"] = wide["trace.k"] = "32";
  const Subject wider = subject(wide, units(true, 32, 1, 32));
  EXPECT_THAT(names(wider.differences(baseline, MayDiffer::designs)), ElementsAre("k: 32"));
  EXPECT_THAT(names(subject(kGauTracer, units(true, 40)).differences(baseline, MayDiffer::designs)),
              ElementsAre("machine: paper, changed"));
  EXPECT_THAT(names(subject(kGauTracer, units(true, 32, 2)).differences(baseline, MayDiffer::designs)),
              ElementsAre("machine: paper, changed"));
  // Of two results of one design, all of it is a difference.
  EXPECT_THAT(names(wider.differences(gautracer, MayDiffer::designs)),
              ElementsAre("k: 32", "simt.payload_registers: 96"));
  EXPECT_THAT(names(subject(kGauTracer, units(true, 40)).differences(gautracer, MayDiffer::designs)),
              ElementsAre("simt.registers_per_thread: 40"));
}

// Statistics of structures that the paper does not have were called baseline or sw.
TEST(DesignName, IsOfTheStructureTheCheckpointsAndTheUnits) {
  const auto name = [](const char* accel, const char* checkpoint, const ordered_json& config) {
    return design_name({{"accel", accel}, {"checkpoint", checkpoint}}, config);
  };
  EXPECT_EQ(name("tri20", "off", {}), "baseline");
  EXPECT_EQ(name("tri20", "on", {}), "hw");
  EXPECT_EQ(name("tlas-tri20", "off", {}), "sw");
  EXPECT_EQ(name("tlas-tri20", "on", {}), "grtx");
  EXPECT_EQ(name("tlas-sphere", "on", {}), "tlas-sphere+checkpoint");
  EXPECT_EQ(name("ellipsoid", "off", units(false)), "ellipsoid");
  EXPECT_EQ(name("ellipsoid", "off", units(true)), "gautracer");
  EXPECT_EQ(name("ellipsoid", "off", units(true, 40)), "gautracer");  // its own number of registers
  ordered_json together = units(true);
  together["rt.traversal"] = "warp";
  EXPECT_EQ(name("ellipsoid", "off", together), "walk");
  EXPECT_EQ(name("ellipsoid", "", units(true)), "");
}

TEST(Subject, ViewsOfOneResolutionShareAMean) {
  const ordered_json other = {{"trace.scene_hash", "400"}, {"trace.camera", "9"}, {"trace.camera_hash", "ca9"}};
  EXPECT_THAT(names(subject(other).differences(subject(), MayDiffer::views)), IsEmpty());
  EXPECT_NE(subject(other).view_text(), subject().view_text());
  ordered_json smaller = other;
  smaller["width"] = "16";
  EXPECT_THAT(names(subject(smaller).differences(subject(), MayDiffer::views)), ElementsAre("size: 16 × 32"));
}

TEST(Subject, WhatAFileDoesNotSayIsUnknown) {
  const auto without = [](const char* name) {
    ordered_json less = inputs();
    less.erase(name);
    return Subject(less, {}, {{"model_version", "7"}}).unknown();
  };
  EXPECT_EQ(without("trace.camera_hash"), "camera");
  EXPECT_EQ(without("trace.scene_hash"), "scene");
  EXPECT_EQ(without("width"), "size");
  EXPECT_EQ(without("mode"), "mode");
  EXPECT_EQ(Subject(inputs(), {}).unknown(), "model version");
  EXPECT_EQ(subject({{"warm", "1 2"}}).unknown(), "view that ran before");  // a saved state does not say it
  EXPECT_EQ(Subject().unknown(), "scene");
}

TEST(SetApart, ResultsAreCalledByWhatDiffers) {
  const Subject paper = subject(), charged = subject({{"machine", "paper-charged"}}, {{"l1.bytes", 2}});
  EXPECT_THAT(set_apart({paper, charged}, {"a", "b"}), ElementsAre("paper", "paper-charged"));
  const Subject warm = subject({{"warm", "1"}, {"warm.camera_hash", "ca0"}});
  EXPECT_THAT(set_apart({paper, warm}, {"a", "b"}), ElementsAre("cold caches", "warm caches"));
  EXPECT_THAT(set_apart({paper, subject({{"width", "16"}, {"trace.camera_hash", "c"}})}, {"a", "b"}),
              ElementsAre("64 × 32", "16 × 32"));
  EXPECT_THAT(set_apart({paper, subject(ordered_json::object(), {{"l1.bytes", 2}})}, {"a", "b"}),
              ElementsAre("l1.bytes = 1", "l1.bytes = 2"));
  EXPECT_THAT(set_apart({paper, paper, charged, charged}, {"a", "a", "b", "b"}),
              ElementsAre("paper (1)", "paper (2)", "paper-charged (1)", "paper-charged (2)"));
  EXPECT_THAT(set_apart({paper, paper}, {"a", "b"}), ElementsAre("a", "b"));
}

TEST(MachinesText, NamesEveryMachineAndMode) {
  EXPECT_EQ(machines_text({subject(), subject({{"machine", "modern"}}), subject()}),
            "machines paper and modern, mode cycle, model version 7");
  EXPECT_EQ(machines_text({Subject()}), "");
}

}  // namespace
}  // namespace grtx::report
