// SPDX-License-Identifier: Apache-2.0
// A child process that makes traces one after another and reuses scene and acceleration structure: building takes
// longer than tracing a small view.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grtx/explore/sweep/program_run.h"

namespace grtx::explore {

class TracerProcess {
 public:
  /// program: path of grtx. folder: for the process's output. limits: memory of the process, wall time per trace. The
  /// first trace() starts the process.
  TracerProcess(std::string program, const std::string& folder, const ProgramLimits& limits);
  ~TracerProcess();
  TracerProcess(const TracerProcess&) = delete;
  TracerProcess& operator=(const TracerProcess&) = delete;

  struct Result {
    bool done = false;
    bool timeout = false;
    double seconds = 0.0;                ///< wall time, including the start of the process
    std::uint64_t structures_built = 0;  ///< acceleration structures built for this trace
  };
  /// Makes a trace. arguments: of `grtx trace`. After a trace that is not done the process's state is unknown, so it is
  /// ended and the next trace starts a new one.
  Result trace(const std::vector<std::string>& arguments);

 private:
  class Requests;
  bool start();
  std::string answer(std::size_t count) const;

  std::string program_, output_, errors_;
  ProgramLimits limits_;
  std::unique_ptr<Requests> requests_;
  std::unique_ptr<ProgramRun> process_;
  std::size_t requests_sent_ = 0;  ///< traces requested from this process
};

}  // namespace grtx::explore
