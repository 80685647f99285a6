// SPDX-License-Identifier: Apache-2.0
// A run of a random trace on the small GPU in a process of its own, for tests of what observers write.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/simulate_priced.h"
#include "temporary_folder.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim::test {

class ObservedRun {
 public:
  /// procedural: leaves are spheres, or ellipsoids without a BLAS; boxes: they are boxes. delayed: any-hit shaders are.
  explicit ObservedRun(bool checkpoint = true, bool two_level = true, unsigned objects = 0, bool procedural = false,
                       bool boxes = false, bool delayed = false) {
    traces::testing::RandomOptions random{
        .seed = 11, .groups = 12, .warp_size = 32, .two_level = two_level, .objects = objects};
    if (objects != 0) random.depth = 2;  // three trees deep, a ray visits many nodes
    random.checkpoint = checkpoint;
    if (delayed) random.any_hit = traces::AnyHit::delayed;
    random.capacity = checkpoint ? 1000 : 0;
    auto trace = traces::testing::random_trace(random);
    if (procedural) make_procedural(trace, boxes);
    for (traces::RayGroup& group : trace.groups) group.kind = traces::RayKind::primary;
    traces::testing::write_trace(path("t.grtx"), trace.header, trace.groups);
  }

  std::string path(const std::string& name) const { return folder_.path(name); }

  /// Runs with `options`; returns the statistics. Fails the test when a conservation law does not hold.
  nlohmann::ordered_json run(const SimulationOptions& options, const std::vector<std::string>& settings = {}) const {
    ChildProcess child("simulation", [&] {
      const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", settings);
      const SimulationResult result = test::simulate_priced(path("t.grtx"), config, options);
      nlohmann::ordered_json answer = {{"stats", result.document.at("stats")},
                                       {"violations", result.violations},
                                       {"pixel_cycles", result.pixel_cycles}};
      return answer.dump();
    });
    const auto answer = nlohmann::ordered_json::parse(child.result());
    EXPECT_EQ(answer.at("violations").size(), 0U) << answer.at("violations").dump();
    pixel_cycles_ = answer.at("pixel_cycles").get<std::vector<std::uint64_t>>();
    return answer.at("stats");
  }
  const std::vector<std::uint64_t>& pixel_cycles() const { return pixel_cycles_; }

 private:
  grtx::test::TemporaryFolder folder_;
  mutable std::vector<std::uint64_t> pixel_cycles_;
};

inline std::uint64_t statistic(const nlohmann::ordered_json& stats, const std::string& name) {
  return stats.at(name).at("value").get<std::uint64_t>();
}

}  // namespace grtx::sim::test
