// SPDX-License-Identifier: Apache-2.0
// Runs a command in a child process, with limits on time and memory.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace grtx::explore {

struct ProgramLimits {
  double seconds = 0.0;            ///< wall time limit, after which it is killed; 0: none
  std::uint64_t memory_bytes = 0;  ///< limit on private writable memory, beyond which allocation fails; 0: none
};

struct ProgramEnd {
  int code = 0;          ///< exit code, if no signal ended it
  int signal = 0;        ///< signal that ended it, 0 for none
  bool timeout = false;  ///< killed at the time limit
  double seconds = 0.0;
};

/// A running command. Its standard output and error go to files. It gets SIGTERM when this process ends for any reason.
class ProgramRun {
 public:
  /// arguments[0] is the program. input: file descriptor for its standard input; -1: empty input. Throws
  /// std::runtime_error if the process cannot be started.
  ProgramRun(const std::vector<std::string>& arguments, const std::string& output, const std::string& errors,
             const ProgramLimits& limits, int input = -1);
  /// Kills the process if it is still running.
  ~ProgramRun();
  ProgramRun(const ProgramRun&) = delete;
  ProgramRun& operator=(const ProgramRun&) = delete;

  /// Returns how it ended, nullopt while it runs. Kills it at the time limit. Does not wait.
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

}  // namespace grtx::explore
