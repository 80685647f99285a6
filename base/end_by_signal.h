// SPDX-License-Identifier: Apache-2.0
// Clean end by a signal: when the user stops the program, partly written files are removed, and one line says so.
#pragma once

#include <sys/types.h>
#include <csignal>

#include <string>

namespace grtx {

/// Delays the handlers of signals while it lives, so that none ends this process. Keep it briefly, and at most one per
/// thread.
class DelayedSignals {
 public:
  DelayedSignals();
  ~DelayedSignals();
  DelayedSignals(const DelayedSignals&) = delete;
  DelayedSignals& operator=(const DelayedSignals&) = delete;

 private:
  sigset_t before_{};
};

/// A file that is removed if SIGHUP, SIGINT or SIGTERM ends this process while the object lives, and only then.
class RemovedBySignal {
 public:
  explicit RemovedBySignal(std::string path);
  /// For a file created while `delayed` blocks the signals, so that there is no gap before it is registered.
  RemovedBySignal(std::string path, const DelayedSignals& delayed);
  ~RemovedBySignal();
  RemovedBySignal(const RemovedBySignal&) = delete;
  RemovedBySignal& operator=(const RemovedBySignal&) = delete;
  const std::string& path() const { return path_; }

 private:
  friend void remove_by_signal();
  std::string path_;
  pid_t owner_;  ///< process that removes it; forked children do not
  RemovedBySignal* next_ = nullptr;
  RemovedBySignal* before_ = nullptr;
};

/// Installs handlers for the three signals, unless ignored: they remove the files, print one line to stderr, and end
/// the process by the same signal (exit status 129, 130 or 143 in a shell). Forked children do so without the line.
void end_tidily_by_signals();

/// Sets the advice on restarting that the line contains; must be a string literal.
void say_when_ended_by_signal(const char* advice);

}  // namespace grtx
