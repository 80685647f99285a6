// SPDX-License-Identifier: Apache-2.0
// Sound results, to be damaged.
#pragma once

#include <filesystem>
#include <string>

#include "fuzz/readers.h"
#include "grtx/base/atomic_file.h"
#include "sweep_database.h"

namespace grtx::fuzzing {

inline std::string database() {
  const std::string path = folder() + "/seed.sqlite";
  std::filesystem::remove(path);
  testing_sweep::make_points(path, {{{"id", 1}, {"values", {{"gpu.time_us", 2.0}, {"cost.mm2", 3.0}}}}});
  return read_file(path);
}

inline constexpr const char* kStatistics =
    R"({"schema": "grtx.stats/1", "config": {"gpu.sms": 2}, "inputs": {"accel": "tri20", "checkpoint": "off"}, )"
    R"("stats": {"gpu.cycles": {"value": 12, "unit": "cycles", "description": "d"}, )"
    R"("gpu.rt.stall.memory": {"value": 1.5, "unit": "cycles", "description": ""}}})";

}  // namespace grtx::fuzzing
