// SPDX-License-Identifier: Apache-2.0
// What points are called: everything that they are made from and differ in, varied or not.
#include <gtest/gtest.h>

#include "grtx/explore/sweep/stored_points.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

StoredPoint point(const char* trace, const char* config, const char* coordinates = "{}") {
  StoredPoint p;
  p.machine = "paper";
  p.mode = "cycle";
  p.scene = "room";
  p.design = "grtx";
  p.coordinates = ordered_json::parse(coordinates);
  p.config = ordered_json::parse(config);
  p.trace = std::make_shared<const ordered_json>(trace_inputs(ordered_json::parse(trace)));
  return p;
}

/// The coordinates of each, as texts.
std::vector<std::string> told_apart(std::vector<StoredPoint> points) {
  std::vector<StoredPoint*> pointers;
  for (StoredPoint& p : points) pointers.push_back(&p);
  add_distinguishing_inputs(pointers);
  std::vector<std::string> texts;
  for (const StoredPoint& p : points) texts.push_back(p.coordinates.dump());
  return texts;
}
using Texts = std::vector<std::string>;

TEST(TellApart, AnInputOfAnyKindThatDiffersIsACoordinate) {
  const struct {
    const char *trace, *config, *coordinates;
  } cases[] = {
      {R"({"view":1,"width":8,"tracer":{"ert":"0.01","sort_key":"entry"}})", R"({"gpu.sms":8,"l2.xor":true})",
       R"({"view":1})"},
      {R"({"view":0,"width":16,"tracer":{"ert":"0.01","sort_key":"entry"}})", R"({"gpu.sms":8,"l2.xor":true})",
       R"({"width":16})"},
      {R"({"view":0,"width":8,"tracer":{"ert":"0.5","sort_key":"entry"}})", R"({"gpu.sms":8,"l2.xor":true})",
       R"({"tracer.ert":0.5})"},
      {R"({"view":0,"width":8,"tracer":{"ert":"0.01","sort_key":"peak"}})", R"({"gpu.sms":8,"l2.xor":true})",
       R"({"tracer.sort_key":"peak"})"},
      {R"({"view":0,"width":8,"tracer":{"ert":"0.01","sort_key":"entry","layout":"compact"}})",
       R"({"gpu.sms":8,"l2.xor":true})", R"({"tracer.layout":"compact"})"},
      {R"({"view":0,"width":8,"tracer":{"ert":"0.01","sort_key":"entry"}})", R"({"gpu.sms":2,"l2.xor":true})",
       R"({"gpu.sms":2})"},
      {R"({"view":0,"width":8,"tracer":{"ert":"0.01","sort_key":"entry"}})", R"({"gpu.sms":8,"l2.xor":false})",
       R"({"l2.xor":false})"},
  };
  for (const auto& c : cases) {
    const Texts texts = told_apart(
        {point(R"({"view":0,"width":8,"tracer":{"ert":"0.01","sort_key":"entry"}})", R"({"gpu.sms":8,"l2.xor":true})"),
         point(c.trace, c.config)});
    EXPECT_EQ(texts[1], c.coordinates);
    EXPECT_NE(texts[0], texts[1]);
  }
}

// Registers of a heap follow k: as a coordinate they left gautracer and walk without a baseline of equal keys, and so
// without a speed-up over k, on the page and in Python.
TEST(TellApart, RegistersThatADesignSetsForItsKAreNone) {
  const auto walk = [](const char* trace, const char* config) {
    StoredPoint p = point(trace, config, "{}");
    p.design = "walk";
    return p;
  };
  EXPECT_EQ(told_apart({walk(R"({"tracer":{"k":"64"}})", R"({"simt.payload_registers":192})"),
                        walk(R"({"tracer":{"k":"16"}})", R"({"simt.payload_registers":48})")}),
            (Texts{R"({"tracer.k":64})", R"({"tracer.k":16})"}));
  EXPECT_EQ(told_apart({walk(R"({"tracer":{"k":"64"}})", R"({"simt.payload_registers":192})"),
                        walk(R"({"tracer":{"k":"64"}})", R"({"simt.payload_registers":255})")}),
            (Texts{R"({"simt.payload_registers":192})", R"({"simt.payload_registers":255})"}));
}

TEST(TellApart, WhatAllShareAndWhatTheOtherNamesSayIsNone) {
  StoredPoint baseline = point(R"({"files":"a","tracer":{"accel":"tri20"},"trace_format":4})", R"({"l1.ways":4})");
  baseline.design = "baseline";
  StoredPoint elsewhere =
      point(R"({"files":"b","tracer":{"accel":"tlas-tri20"},"trace_format":8})", R"({"l1.ways":4})");
  elsewhere.scene = "hall";
  StoredPoint modern = point(R"({"files":"a","tracer":{"accel":"tlas-tri20"},"trace_format":4})", R"({"l1.ways":8})");
  modern.machine = "modern";
  StoredPoint windows = point(R"({"files":"a","tracer":{"accel":"tlas-tri20"},"trace_format":4})", R"({"l1.ways":2})");
  windows.mode = "windows";
  EXPECT_EQ(told_apart({point(R"({"files":"a","tracer":{"accel":"tlas-tri20"}})", R"({"l1.ways":4})"), baseline,
                        elsewhere, modern, windows}),
            Texts(5, "{}"));
}

TEST(TellApart, APointThatAnAxisLeavesOutHasItsValueFromTheConfiguration) {
  EXPECT_EQ(
      told_apart({point("{}", R"({"l1.bytes":4096})", R"({"l1.bytes":4096})"), point("{}", R"({"l1.bytes":8192})")}),
      (Texts{R"({"l1.bytes":4096})", R"({"l1.bytes":8192})"}));
}

/// It has no configuration yet.
TEST(TellApart, APointThatWaitsIsCalledByWhatThePlanVaries) {
  EXPECT_EQ(
      told_apart({point("{}", "{}", R"({"l1.bytes":4096})"),
                  point("{}", R"({"l1.bytes":8192})", R"({"l1.bytes":8192})"), point("{}", R"({"l1.bytes":16384})")}),
      (Texts{R"({"l1.bytes":4096})", R"({"l1.bytes":8192})", R"({"l1.bytes":16384})"}));
}

TEST(TellApart, AFileThatConfiguresTheMemoryIsTold) {
  StoredPoint a = point("{}", R"({"dram.model":"x"})"), b = a;
  a.inputs = {{"memory.files_hash", "1"}};
  b.inputs = {{"memory.files_hash", "2"}};
  EXPECT_EQ(told_apart({a, b}), (Texts{R"({"memory.files_hash":"1"})", R"({"memory.files_hash":"2"})"}));
}

}  // namespace
}  // namespace grtx::explore
