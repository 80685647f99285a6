// SPDX-License-Identifier: Apache-2.0
// A random trace and a small machine, for tests of estimates against cycle mode.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/base/child_process.h"
#include "paths.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim::test {

class RandomTraceRun : public ::testing::Test {
 protected:
  /// secondary: so many groups at the end are a launch of their own.
  RandomTraceRun(std::uint32_t seed, unsigned groups, unsigned secondary = 0) {
    traces::testing::RandomOptions random{
        .seed = seed, .groups = groups, .warp_size = 8, .depth = 3, .checkpoint = false};
    auto trace = traces::testing::random_trace(random);
    for (traces::RayGroup& group : trace.groups) {
      group.kind = group.index < groups - secondary ? traces::RayKind::primary : traces::RayKind::glass;
    }
    traces::testing::write_trace(file_.path(), trace.header, trace.groups);
  }

  nlohmann::ordered_json cycle_mode() const {
    ChildProcess child("cycle", [this] { return simulate_priced(file_.path(), config_, {}).document.dump(); });
    return nlohmann::ordered_json::parse(child.result());
  }

  traces::testing::TemporaryFile file_{"random_trace_run"};
  GpuConfig config_ = load_config(grtx::paths::source_dir() + "/configs/small.toml", {});
};

}  // namespace grtx::sim::test
