// SPDX-License-Identifier: Apache-2.0
// The page of a sequence: times and energies are of a frame, counts of all, and shares of the frame that they lie in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/report/page/launch_size.h"
#include "grtx/report/page/report.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

ordered_json count(double value) { return {{"value", value}, {"unit", ""}, {"description", ""}}; }

/// Statistics of two frames, each of half the cycles at 1 GHz, 1,000 rays a frame, 8 mJ in all.
ordered_json statistics(double cycles) {
  return {{"gpu.cycles", count(cycles)},
          {"gpu.time_us", count(cycles / 1000)},
          {"gpu.frame0.cycles", count(cycles / 2)},
          {"gpu.frame1.cycles", count(cycles / 2)},
          {"gpu.rt.warp_latency_max", count(0.4 * cycles)},
          {"gpu.bound.fraction", count(0.3)},
          {"gpu.energy_nj", count(8e6)},
          {"tracer.rays", count(2000)}};
}

/// The members of results.json that belong to a machine.
ordered_json machine(const std::string& name, double cycles) {
  ordered_json document = {{"machine", name}, {"config", sim::config_json(sim::load_config("", {}))}};
  for (const auto& [design, own] : {std::pair("baseline", cycles), std::pair("walk", cycles / 4)}) {
    document["designs"][design] = statistics(own);
    document["inputs"][design] = {{"trace.scene", "hall.ply"},
                                  {"trace.scene_hash", "1"},
                                  {"trace.camera", "0 to 1"},
                                  {"trace.camera_hash", "2"},
                                  {"accel", "tri20"},
                                  {"checkpoint", "off"},
                                  {"trace.k", "8"},
                                  {"width", "64"},
                                  {"height", "64"},
                                  {"mode", "cycle"}};
    document["binding_bound"][design] = "l2_port";
  }
  document["speedup"] = {{"walk", 4.0}};
  return document;
}

ordered_json run_of(const std::vector<ordered_json>& machines) {
  ordered_json document = {{"schema", "grtx.run/2"}, {"version", "1"}, {"model_version", 8}};
  if (machines.size() == 1) {
    document.update(machines.front());
  } else {
    document["machines"] = machines;
    document["between_machines"] = {{"over", machines.front().at("machine")}};
  }
  document["images_identical"] = true;
  return document;
}

std::string page(const ordered_json& document) {
  const grtx::test::TemporaryFolder folder;
  folder.write("results.json", document.dump());
  ReportOptions options;
  options.inputs = {folder.path("results.json")};
  const std::string whole = report_page(options);
  const std::size_t begin = whole.find("<main");
  return whole.substr(begin, whole.find("</main>") - begin);
}

// "time of the frame" was 4 ms, the sum of both; so were the energy and all that the first screen said.
TEST(SequencePage, TheTimeOfAllFramesIsNotGivenAsThatOfTheFrame) {
  const std::string html = page(run_of({machine("paper", 4e6)}));
  EXPECT_THAT(html, AllOf(HasSubstr("<th scope=\"row\">time of a frame, mean of 2</th><td class=\"n\">2.00 ms</td>"),
                          HasSubstr("<th scope=\"row\">energy of a frame, mean of 2</th><td class=\"n\">4.00 mJ</td>"),
                          HasSubstr("<th scope=\"row\">rays a second</th><td class=\"n\">0.500 Mrays/s</td>"),
                          HasSubstr("are of all 2 frames."), HasSubstr("2.00 ms a frame, 0.500 Mrays/s"),
                          HasSubstr("4.00 mJ a frame")));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("time of the frame")), Not(HasSubstr("4.00 ms")), Not(HasSubstr("8.00 mJ"))));
}

TEST(SequencePage, TimesOfMachinesSideBySideAreNoSumsEither) {
  EXPECT_THAT(page(run_of({machine("paper", 4e6), machine("ada", 2e6)})),
              AllOf(HasSubstr("Machines side by side: time of a frame, mean of 2, against paper"),
                    HasSubstr(">2.00 ms</td>"), HasSubstr(">1.00 ms</td>")));
}

// 40 % of both frames, and at least 80 % of its own.
TEST(SequencePage, TheSlowestCallIsComparedWithTheCyclesOfItsFrame) {
  EXPECT_THAT(page(run_of({machine("paper", 4e6)})),
              HasSubstr("latency: the slowest call of a warp is 80 % of its frame or more"));
}

// A launch of which three quarters are tail is no better for a second one like it.
TEST(SequencePage, ASecondFrameDoesNotHideThatALaunchIsMostlyTail) {
  ordered_json two = statistics(400);
  two["gpu.distributor.groups"] = count(2 * 600);
  two["gpu.distributor.tail_cycles"] = count(150);
  const ordered_json config = sim::config_json(sim::load_config("", {}));
  EXPECT_DOUBLE_EQ(launch_size(two, config, {}).tail, 0.75);
  EXPECT_FALSE(launch_size(two, config, {}).fills());
}

}  // namespace
}  // namespace grtx::report
