// Runs a command in a process of its own, within limits of time and memory.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace grtx::sim {

struct ProgramLimits {
  double seconds = 0.0;            ///< wall time, then it is killed; 0: none
  std::uint64_t memory_bytes = 0;  ///< of private writable memory; allocating more fails; 0: none
};

struct ProgramEnd {
  int code = 0;          ///< exit code, when no signal ended it
  int signal = 0;        ///< that ended it, 0 for none
  bool timeout = false;  ///< it was killed for taking too long
  double seconds = 0.0;
};

/// A running command. Its standard output and error go to files. It dies with this process, however that ends.
class ProgramRun {
 public:
  /// arguments[0] is the program. input: descriptor of its standard input; -1: it is empty. Throws std::runtime_error
  /// when no process can be started.
  ProgramRun(const std::vector<std::string>& arguments, const std::string& output, const std::string& errors,
             const ProgramLimits& limits, int input = -1);
  /// Kills it when it has not ended.
  ~ProgramRun();
  ProgramRun(const ProgramRun&) = delete;
  ProgramRun& operator=(const ProgramRun&) = delete;

  /// Whether and how it has ended; kills it when its time is up. Does not wait.
  std::optional<ProgramEnd> poll();
  /// Waits for the end.
  ProgramEnd wait();

 private:
  pid_t pid_ = -1;
  ProgramLimits limits_;
  std::chrono::steady_clock::time_point start_;
  bool timeout_ = false;
};

/// "SIGKILL" and the like.
std::string signal_name(int signal);

}  // namespace grtx::sim
