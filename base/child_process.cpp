// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

#include "grtx/base/error.h"

namespace grtx {
namespace {

// First byte of the child's message.
constexpr char kResult = 'r';
constexpr char kBadInput = 'e';  // followed by file \0 place \0 rule
constexpr char kFailure = 'x';   // followed by the message

constexpr std::chrono::milliseconds kLook{200};  ///< between two looks at running children

/// Exit code of a child that ran out of memory.
constexpr int kNoMemory = 3;

[[noreturn]] void fail(const std::string& name, const char* what) {
  throw std::runtime_error(name + ": " + what + ": " + std::strerror(errno));
}

std::string message_of(const std::function<std::string()>& body) {
  try {
    return kResult + body();
  } catch (const Error& error) {
    return kBadInput + error.file() + '\0' + error.place() + '\0' + error.rule();
  } catch (const std::exception& error) {
    return std::string(1, kFailure) + error.what();
  }
}

[[noreturn]] void run_child(int pipe, pid_t parent, const std::function<std::string()>& body) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a killed parent must not leave simulations behind
  if (::getppid() != parent) ::_exit(EXIT_FAILURE);
  std::set_new_handler([] { ::_exit(kNoMemory); });  // the parent reports it
  const std::string message = message_of(body);
  std::fflush(nullptr);
  for (std::size_t sent = 0; sent < message.size();) {
    const ssize_t count = ::write(pipe, message.data() + sent, message.size() - sent);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) ::_exit(EXIT_FAILURE);
    sent += static_cast<std::size_t>(count);
  }
  ::_exit(EXIT_SUCCESS);
}

}  // namespace

ChildProcess::ChildProcess(std::string name, const std::function<std::string()>& body) : name_(std::move(name)) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail(name_, "cannot make a pipe");
  std::fflush(nullptr);  // otherwise the child would write this process's buffered text again
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) {
    const int reason = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    errno = reason;
    fail(name_, "cannot start a process");
  }
  if (pid_ == 0) {
    ::close(ends[0]);
    run_child(ends[1], parent, body);
  }
  ::close(ends[1]);
  pipe_ = ends[0];
}

ChildProcess::~ChildProcess() {
  if (pipe_ >= 0) ::close(pipe_);
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
}

std::optional<std::size_t> ChildProcess::wait_for_any(const std::vector<std::unique_ptr<ChildProcess>>& children,
                                                      std::chrono::milliseconds time) {
  std::vector<pollfd> ends;
  ends.reserve(children.size());
  for (const auto& child : children) ends.push_back({child->pipe_, POLLIN, 0});
  if (::poll(ends.data(), ends.size(), static_cast<int>(time.count())) <= 0) return std::nullopt;
  const auto ended = std::find_if(ends.begin(), ends.end(), [](const pollfd& end) { return end.revents != 0; });
  return static_cast<std::size_t>(ended - ends.begin());
}

std::string ChildProcess::result() {
  std::string message;
  std::array<char, 65536> buffer{};
  for (;;) {
    const ssize_t count = ::read(pipe_, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(name_, "cannot read from the process");
    if (count == 0) break;
    message.append(buffer.data(), static_cast<std::size_t>(count));
  }
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0) {
    if (errno != EINTR) fail(name_, "cannot wait for the process");
  }
  pid_ = -1;
  if (WIFSIGNALED(status)) throw std::runtime_error(name_ + ": ended by signal " + ::strsignal(WTERMSIG(status)));
  if (WEXITSTATUS(status) == kNoMemory) throw std::bad_alloc();
  if (status != 0 || message.empty()) throw std::runtime_error(name_ + ": the process ended without a result");
  std::string rest = message.substr(1);
  if (message.front() == kResult) return rest;
  if (message.front() == kFailure) throw std::runtime_error(name_ + ": " + rest);
  const std::size_t place = rest.find('\0');
  const std::size_t rule = rest.find('\0', place + 1);
  throw Error(rest.substr(0, place), rest.substr(place + 1, rule - place - 1), rest.substr(rule + 1));
}

void run_children(const std::vector<ChildTask>& tasks, std::size_t at_a_time,
                  const std::function<void(std::size_t, const std::string&)>& take, const std::function<void()>& look) {
  std::vector<std::unique_ptr<ChildProcess>> running;
  std::vector<std::size_t> indices;  // of the running ones
  std::size_t begun = 0;
  while (begun < tasks.size() || !running.empty()) {
    if (begun < tasks.size() && running.size() < at_a_time) {
      running.push_back(std::make_unique<ChildProcess>(tasks[begun].name, tasks[begun].body));
      indices.push_back(begun++);
      continue;
    }
    const std::optional<std::size_t> ended = ChildProcess::wait_for_any(running, kLook);
    look();
    if (!ended) continue;
    const auto at = static_cast<std::ptrdiff_t>(*ended);
    take(indices[*ended], running[*ended]->result());
    running.erase(running.begin() + at);
    indices.erase(indices.begin() + at);
  }
}

}  // namespace grtx
