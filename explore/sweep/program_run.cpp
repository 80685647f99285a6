// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/program_run.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace grtx::explore {
namespace {

constexpr int kCannotStart = 127;

// Sanitizers reserve terabytes of private memory, which would count against the limit.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsMemory = false;
#else
constexpr bool kLimitsMemory = true;
#endif

/// Runs in the child between fork and exec: must not allocate.
[[noreturn]] void become(char* const* arguments, int input, const char* output, const char* errors,
                         std::uint64_t memory, pid_t parent) {
  // The parent handles Ctrl-C. SIGTERM from the parent's end lets grtx remove incomplete files.
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGHUP, SIG_IGN);
  ::signal(SIGTERM, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(kCannotStart);
  const int out = ::open(output, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  const int err = ::open(errors, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  const int in = input < 0 ? ::open("/dev/null", O_RDONLY | O_CLOEXEC) : input;
  if (out < 0 || err < 0 || in < 0 || ::dup2(in, 0) < 0 || ::dup2(out, 1) < 0 || ::dup2(err, 2) < 0) {
    ::_exit(kCannotStart);
  }
  if (kLimitsMemory && memory != 0) {
    // Linux counts private writable mappings, so a thread's unused stack and heap reserve do not.
    const rlimit limit{memory, memory};
    ::setrlimit(RLIMIT_DATA, &limit);
  }
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::execv(arguments[0], arguments);
  ::_exit(kCannotStart);
}

}  // namespace

ProgramRun::ProgramRun(const std::vector<std::string>& arguments, const std::string& output, const std::string& errors,
                       const ProgramLimits& limits, int input)
    : limits_(limits), start_(std::chrono::steady_clock::now()) {
  std::vector<std::string> copies = arguments;
  std::vector<char*> pointers;
  for (std::string& argument : copies) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  if (pid_ == 0) become(pointers.data(), input, output.c_str(), errors.c_str(), limits.memory_bytes, parent);
}

ProgramRun::~ProgramRun() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
}

std::optional<ProgramEnd> ProgramRun::poll() {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  int status = 0;
  const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
  if (ended == pid_) {
    pid_ = -1;
    ProgramEnd end;
    end.seconds = seconds;
    end.timeout = timeout_;
    if (WIFSIGNALED(status)) {
      end.signal = WTERMSIG(status);
    } else {
      end.code = WEXITSTATUS(status);
    }
    return end;
  }
  if (limits_.seconds > 0.0 && seconds > limits_.seconds && !timeout_) {
    timeout_ = true;
    ::kill(pid_, SIGKILL);
  }
  return std::nullopt;
}

ProgramEnd ProgramRun::wait() {
  for (auto pause = std::chrono::milliseconds(1);; pause = std::min(2 * pause, std::chrono::milliseconds(20))) {
    if (const auto end = poll()) return *end;
    std::this_thread::sleep_for(pause);
  }
}

std::string signal_name(int signal) {
  const char* const name = ::sigabbrev_np(signal);
  return name == nullptr ? "signal " + std::to_string(signal) : std::string("SIG") + name;
}

}  // namespace grtx::explore
