// The tracer's options as a sweep's plan names them: what the command line of `grtx trace` takes.
#pragma once

#include "grtx/explore/sweep/plan.h"

namespace grtx::sim {

class CliTracerRules final : public TracerRules {
 public:
  void check(const std::string& option, const std::string& value) const override;
  std::map<std::string, std::string> resolve(const std::map<std::string, std::string>& options,
                                             const std::string& accel, bool checkpoint) const override;
};

}  // namespace grtx::sim
