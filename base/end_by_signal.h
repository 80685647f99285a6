// A user who stops the program finds no half of a file: what is being written is removed, and one line says so.
#pragma once

#include <sys/types.h>
#include <csignal>

#include <string>

namespace grtx {

/// While it lives no signal ends this process: a handler waits. Short, and without another of its kind on the thread.
class EndHeld {
 public:
  EndHeld();
  ~EndHeld();
  EndHeld(const EndHeld&) = delete;
  EndHeld& operator=(const EndHeld&) = delete;

 private:
  sigset_t before_{};
};

/// A file that is to be removed should SIGHUP, SIGINT or SIGTERM end this process while the object lives. Does not
/// remove it otherwise.
class RemovedBySignal {
 public:
  explicit RemovedBySignal(std::string path);
  /// Known from the moment in which it was made.
  RemovedBySignal(std::string path, const EndHeld& held);
  ~RemovedBySignal();
  RemovedBySignal(const RemovedBySignal&) = delete;
  RemovedBySignal& operator=(const RemovedBySignal&) = delete;
  const std::string& path() const { return path_; }

 private:
  friend void remove_by_signal();
  std::string path_;
  pid_t owner_;  ///< a forked child leaves it alone
  RemovedBySignal* next_ = nullptr;
  RemovedBySignal* before_ = nullptr;
};

/// From now on the three signals, unless they are ignored, remove those files, print one line to stderr, and end the
/// process as by the signal: a shell says 129, 130 or 143. Forked children do so without the line.
void end_tidily_by_signals();

/// What the line says of starting again; a string literal.
void say_when_ended_by_signal(const char* advice);

}  // namespace grtx
