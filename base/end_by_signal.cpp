// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/end_by_signal.h"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <utility>

namespace grtx {
namespace {

struct Signal {
  int number;
  const char* name;
};
constexpr std::array kSignals{Signal{SIGHUP, "SIGHUP"}, Signal{SIGINT, "SIGINT"}, Signal{SIGTERM, "SIGTERM"}};

constexpr int kMostTries = 1'000'000;  ///< to lock the list; reached only in a child forked while it was locked

// The handler may run at any instruction of any thread. To avoid a deadlock with it, the list is changed only with
// signals blocked, without allocation and briefly.
std::atomic_flag list_taken = ATOMIC_FLAG_INIT;
RemovedBySignal* list_begin = nullptr;
std::atomic<const char*> advice_text{""};
pid_t main_process = 0;
bool on_terminal = false;

void print_line(int signal) {
  std::array<char, 160> line{};
  const auto append = [&line](const char* text) {
    const std::size_t used = std::strlen(line.data());
    std::strncpy(line.data() + used, text, line.size() - 1 - used);
  };
  if (on_terminal) append("\r\033[K");  // overwrites a progress bar
  append("grtx: ended by ");
  for (const Signal& known : kSignals) {
    if (known.number == signal) append(known.name);
  }
  append(": what was being written is removed");
  append(advice_text.load());
  append("\n");
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), std::strlen(line.data()));
}

}  // namespace

DelayedSignals::DelayedSignals() {
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  while (list_taken.test_and_set(std::memory_order_acquire)) ::sched_yield();
}

DelayedSignals::~DelayedSignals() {
  list_taken.clear(std::memory_order_release);
  ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

/// Async-signal-safe. Never releases the list, so that nobody changes it afterwards.
void remove_by_signal() {
  for (int i = 0; i < kMostTries && list_taken.test_and_set(std::memory_order_acquire); ++i) ::sched_yield();
  for (const RemovedBySignal* file = list_begin; file != nullptr; file = file->next_) {
    if (file->owner_ == ::getpid()) ::unlink(file->path_.c_str());
  }
}

namespace {

void end(int signal) {
  remove_by_signal();
  if (::getpid() == main_process) print_line(signal);
  // End by the signal itself, so that a shell loop that called this program also ends.
  struct sigaction plain {};
  plain.sa_handler = SIG_DFL;
  ::sigaction(signal, &plain, nullptr);
  sigset_t one;
  ::sigemptyset(&one);
  ::sigaddset(&one, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
  ::raise(signal);
  ::_exit(128 + signal);  // process 1 of a container survives the signal
}

}  // namespace

RemovedBySignal::RemovedBySignal(std::string path) : RemovedBySignal(std::move(path), DelayedSignals()) {}

RemovedBySignal::RemovedBySignal(std::string path, const DelayedSignals&) : path_(std::move(path)), owner_(::getpid()) {
  next_ = list_begin;
  if (next_ != nullptr) next_->before_ = this;
  list_begin = this;
}

RemovedBySignal::~RemovedBySignal() {
  const DelayedSignals delayed;
  (before_ != nullptr ? before_->next_ : list_begin) = next_;
  if (next_ != nullptr) next_->before_ = before_;
}

void end_tidily_by_signals() {
  main_process = ::getpid();
  on_terminal = ::isatty(STDERR_FILENO) == 1;
  for (const Signal& signal : kSignals) {
    struct sigaction now {};
    ::sigaction(signal.number, nullptr, &now);
    if (now.sa_handler == SIG_IGN) continue;
    struct sigaction tidy {};
    tidy.sa_handler = end;
    ::sigfillset(&tidy.sa_mask);
    ::sigaction(signal.number, &tidy, nullptr);
  }
}

void say_when_ended_by_signal(const char* advice) { advice_text = advice; }

}  // namespace grtx
