// SPDX-License-Identifier: Apache-2.0
// Runs work in a forked child process. SystemC can elaborate only once per process, so each further simulation needs
// its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>

namespace grtx {

/// A child process that computes a text. A grtx::Error in the child is rethrown here as the same grtx::Error; any other
/// exception, and death by a signal, as std::runtime_error.
class ChildProcess {
 public:
  /// Forks at once. No other thread of this process may hold locks that `body` needs (no thread pool running).
  /// name: for messages. The child exits without running destructors of inherited objects.
  ChildProcess(std::string name, const std::function<std::string()>& body);
  /// Kills the child if result() was not called.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits up to `time` for the child's text or end. Returns whether it came, so that result() will not block for long.
  bool wait_for(std::chrono::milliseconds time) const;
  /// Waits for the child and returns its text. Call once.
  std::string result();

 private:
  std::string name_;
  pid_t pid_ = -1;
  int pipe_ = -1;
};

}  // namespace grtx
