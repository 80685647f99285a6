// A process that makes one trace after the other, and keeps scene and structure for the next one: building takes longer
// than tracing a small view.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grtx/lab/sweep/program_run.h"

namespace grtx::sim {

class KeptTracer {
 public:
  /// program: the grtx to run. folder: for what the process prints. limits: memory of the process, wall time of each
  /// trace. Nothing is started yet.
  KeptTracer(std::string program, const std::string& folder, const ProgramLimits& limits);
  ~KeptTracer();
  KeptTracer(const KeptTracer&) = delete;
  KeptTracer& operator=(const KeptTracer&) = delete;

  struct End {
    bool done = false;
    bool timeout = false;
    double seconds = 0.0;                ///< wall time, of starting the process, too
    std::uint64_t structures_built = 0;  ///< for this trace
  };
  /// arguments: of `grtx trace`. Of one that is not done nobody knows what it left behind, so its process is gone, and
  /// the next trace has a new one.
  End trace(const std::vector<std::string>& arguments);

 private:
  class Requests;
  bool start();
  std::string answer(std::size_t count) const;

  std::string program_, output_, errors_;
  ProgramLimits limits_;
  std::unique_ptr<Requests> requests_;
  std::unique_ptr<ProgramRun> process_;
  std::size_t made_ = 0;  ///< by this process
};

}  // namespace grtx::sim
