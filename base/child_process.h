// Runs work in a forked child: SystemC elaborates once a process, so every simulation beyond the first needs its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>

namespace grtx::sim {

/// A child that computes a text. Errors come back as what they were: a grtx::Error in the child is thrown as the same
/// grtx::Error here, any other exception as std::runtime_error, as is death by a signal.
class ChildProcess {
 public:
  /// Forks at once. Call while no other thread of this process holds locks that `body` needs (no thread pool running).
  /// name: for messages. The child ends without running destructors of what it inherited.
  ChildProcess(std::string name, const std::function<std::string()>& body);
  /// Kills the child if its result was not collected.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits so long for the child to have something to say: its text, or its end. Then result() does not block for long.
  bool wait_for(std::chrono::milliseconds time) const;
  /// Waits for the child and returns its text. Call once.
  std::string result();

 private:
  std::string name_;
  pid_t pid_ = -1;
  int pipe_ = -1;
};

}  // namespace grtx::sim
