// SPDX-License-Identifier: Apache-2.0
// The other ways to trace, through the program: same image, sound traces, a simulation without violations, and every
// statistic of all six structures.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

class TracingModes : public ::testing::Test {
 protected:
  void SetUp() override { must("synth --preset flat --count 2000 --seed 3 -o s.ply --quiet"); }
  void must(const std::string& arguments) {
    const Outcome outcome = folder_.run(arguments);
    ASSERT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
  }
  void trace(const std::string& name, const std::string& options) {
    must("trace --quiet --scene s.ply --cameras s.cameras.json -o " + name + ".grtx --image " + name + ".pfm --stats " +
         name + ".json " + (options.starts_with("--width") ? "" : "--width 24 --height 16 ") + options);
  }
  double stat(const std::string& file, const std::string& name) {
    return nlohmann::json::parse(folder_.read(file)).at("stats").at(name).at("value").get<double>();
  }
  Folder folder_;
};

TEST_F(TracingModes, SameImageSoundTraceAndSimulation) {
  for (const std::string accel : {"tri20", "tlas-sphere"}) {
    const std::string with = "--width 16 --height 8 --accel " + accel + " ";
    trace("multi", with + "--k 8");
    trace("single", with + "--tracing single --k 1024");
    trace("full", with + "--tracing single --k 8");
    trace("closest", with + "--tracing closest");
    trace("list", with + "--tracing list");
    trace("short", with + "--tracing list --list-capacity 8");
    for (const std::string name : {"single", "full", "closest", "list", "short"}) {
      EXPECT_THAT(folder_.run("compare multi.pfm " + name + ".pfm").out, HasSubstr("identical")) << accel << name;
      must("trace-check --quiet " + name + ".grtx");
      must("sim --quiet --config '" + grtx::paths::source_dir() + "/configs/small.toml' " + name + ".grtx --stats " +
           name + ".sim.json");
      EXPECT_EQ(stat(name + ".json", "tracer.blended"), stat("multi.json", "tracer.blended"));
      EXPECT_EQ(stat(name + ".sim.json", "gpu.rt.node_visits"), stat(name + ".json", "tracer.visits.total"));
    }
    EXPECT_EQ(stat("single.json", "tracer.rounds"), stat("single.json", "tracer.rays"));
    EXPECT_EQ(stat("single.json", "tracer.single.overflows"), 0.0);
    EXPECT_GT(stat("full.json", "tracer.single.overflows"), 0.0);
    EXPECT_EQ(stat("list.json", "tracer.rounds"), stat("list.json", "tracer.rays"));
    EXPECT_EQ(stat("short.json", "tracer.single.overflows"), stat("full.json", "tracer.single.overflows"));
    EXPECT_GE(stat("list.sim.json", "gpu.simt.phases.blend"), stat("single.sim.json", "gpu.simt.phases.blend"));
    EXPECT_EQ(stat("list.sim.json", "gpu.simt.phases.sort"), stat("list.sim.json", "gpu.simt.phases.blend"))
        << "each batch is a scan and a blend";
    EXPECT_GT(stat("closest.json", "tracer.rounds"), stat("multi.json", "tracer.rounds"));
    EXPECT_EQ(stat("closest.sim.json", "gpu.rt.any_hit_calls"), 0.0);
    EXPECT_THAT(folder_.run("trace-dump closest.grtx").out, HasSubstr(" nearest"));
  }
}

TEST_F(TracingModes, LargestKInAllModes) {
  for (const std::string mode : {"multi", "single", "closest", "list"}) {
    trace(mode, "--k 2048 --tracing " + mode);
    must("trace-check --quiet " + mode + ".grtx");
    EXPECT_THAT(folder_.run("compare multi.pfm " + mode + ".pfm").out, HasSubstr("identical")) << mode;
  }
  trace("checkpointing", "--k 2048 --checkpoint on");
  EXPECT_THAT(folder_.run("compare multi.pfm checkpointing.pfm").out, HasSubstr("identical"));
  EXPECT_EQ(folder_.run("trace --k 2049 --no-trace --scene s.ply --cameras s.cameras.json").code, 2);
}

TEST_F(TracingModes, EveryStructureReportsItsSizeHeightAndFootprint) {
  for (const std::string accel : {"tri20", "tri80", "ellipsoid", "tlas-tri20", "tlas-tri80", "tlas-sphere"}) {
    trace("a", "--accel " + accel);
    const bool two_level = accel.starts_with("tlas");
    const double bytes = stat("a.json", "accel.bytes");
    EXPECT_GE(stat("a.json", "accel.height"), 4.0) << accel;
    EXPECT_EQ(stat("a.json", "accel.blas_height") > 0.0, two_level) << accel;
    EXPECT_GT(bytes, 2000 * 64.0) << accel;
    EXPECT_NEAR(stat("a.json", "accel.bytes_per_gaussian"), bytes / 2000, 1e-6 * bytes) << accel;
    EXPECT_GT(stat("a.json", "accel.footprint_bytes"), 64.0 * 10) << accel;
    EXPECT_LE(stat("a.json", "accel.footprint_bytes"), bytes) << accel;
    const double faces = accel.ends_with("20") ? 20 : accel.ends_with("80") ? 80 : 1;
    EXPECT_EQ(stat("a.json", "accel.nodes.triangle"), two_level || faces == 1 ? 0.0 : faces * 2000) << accel;
    EXPECT_EQ(stat("a.json", "accel.nodes.procedural"), accel == "ellipsoid" ? 2000.0 : 0.0) << accel;
    EXPECT_EQ(stat("a.json", "accel.nodes.instance"), two_level ? 2000.0 : 0.0) << accel;
    EXPECT_EQ(stat("a.json", "accel.nodes.blas") > faces - 1, two_level) << accel;
    const double unique = stat("a.json", "tracer.visits.unique");
    EXPECT_GT(unique, 0.0) << accel;
    EXPECT_LT(unique, stat("a.json", "tracer.visits.total")) << accel;
  }
}

TEST_F(TracingModes, WorldTrianglesGiveNearlyTheSameImage) {
  for (const std::string accel : {"tri20", "tlas-tri20"}) {
    trace("canonical", "--accel " + accel);
    trace("world", "--accel " + accel + " --triangle-test world");
    must("trace-check --quiet world.grtx");
    must("compare --min-psnr 80 canonical.pfm world.pfm");
  }
}

}  // namespace
}  // namespace grtx::e2e
