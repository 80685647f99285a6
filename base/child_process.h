// SPDX-License-Identifier: Apache-2.0
// Runs work in a forked child process. SystemC can elaborate only once per process, so each further simulation needs
// its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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

  /// Waits up to `time` for the text or end of one of them. Returns the one whose result() will not block for long.
  static std::optional<std::size_t> wait_for_any(const std::vector<std::unique_ptr<ChildProcess>>& children,
                                                 std::chrono::milliseconds time);
  /// Waits for the child and returns its text. Call once.
  std::string result();

 private:
  std::string name_;
  pid_t pid_ = -1;
  int pipe_ = -1;
};

/// Work for a child process. name: for messages.
struct ChildTask {
  std::string name;
  std::function<std::string()> body;
};

/// Runs tasks in child processes, begun in this order, at most `at_a_time` at once: whichever ends first makes room for
/// the next. take: gets a task's index and text as soon as it ends. look: called from time to time. Throws as
/// ChildProcess::result(), and ends those that still run.
void run_children(const std::vector<ChildTask>& tasks, std::size_t at_a_time,
                  const std::function<void(std::size_t, const std::string&)>& take, const std::function<void()>& look);

}  // namespace grtx
