// SPDX-License-Identifier: Apache-2.0
// A tracer that knows two options: k (1 to 64), and which k single-round tracing takes.
#pragma once

#include <cstdlib>

#include "grtx/base/error.h"
#include "grtx/base/files_read.h"
#include "grtx/explore/sweep/plan.h"

namespace grtx::explore::test {

class FakeTracerRules final : public TracerRules {
 public:
  void check(const std::string& option, const std::string& value) const override {
    for (const char* const taken : {"accel", "checkpoint", "sort_key", "layout", "tmax_update", "tracing"}) {
      if (option == taken) return;
    }
    if (option != "k") throw Error("tracer", option, "unknown tracer option '" + option + "', the nearest is 'k'");
    if (value.size() > 4 || std::atoi(value.c_str()) < 1 || std::atoi(value.c_str()) > 2048)
      throw Error("tracer", option, "k: must be 1 to 2048");
  }
  std::map<std::string, std::string> resolve(const std::map<std::string, std::string>& options,
                                             const std::string& accel, bool checkpoint) const override {
    std::map<std::string, std::string> all = {{"k", "8"}, {"accel", accel}, {"checkpoint", checkpoint ? "on" : "off"}};
    for (const auto& [name, value] : options) all[name] = value;
    if (checkpoint && all["k"] == "1") throw Error("tracer", "k", "k = 1 has nothing to checkpoint");
    return all;
  }
  std::string structure(const std::map<std::string, std::string>&, const std::string& accel) const override {
    return accel;
  }
  SceneInput input(const std::string& scene, const std::string& cameras) const override {
    FilesRead files;
    files.read(cameras);
    files.read(scene);
    return {files.hash(), false};
  }
};

}  // namespace grtx::explore::test
