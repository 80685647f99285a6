// SPDX-License-Identifier: Apache-2.0
// Checks tracer options in a sweep's plan by the rules of `grtx trace`.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "grtx/explore/sweep/plan.h"

namespace grtx::experiment {

class SceneTracerRules final : public explore::TracerRules {
 public:
  void check(const std::string& option, const std::string& value) const override;
  std::map<std::string, std::string> resolve(const std::map<std::string, std::string>& options,
                                             const std::string& accel, bool checkpoint) const override;
  std::string structure(const std::map<std::string, std::string>& options, const std::string& accel) const override;
  /// Each scene and camera file is read only once.
  explore::SceneInput input(const std::string& scene, const std::string& cameras) const override;

 private:
  mutable std::map<std::pair<std::string, std::string>, explore::SceneInput> read_;
};

}  // namespace grtx::experiment
