// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>

namespace grtx {
namespace {

std::string si(double value) {
  const char* suffix[] = {"", "k", "M", "G"};
  int i = 0;
  while (value >= 1000.0 && i < 3) {
    value /= 1000.0;
    ++i;
  }
  return fmt::format("{:.3g}{}", value, suffix[i]);
}

constexpr std::chrono::milliseconds kOnTerminal{500}, kElsewhere{5000};

std::int64_t elapsed_ms(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Progress::Progress(std::string label, std::uint64_t total, std::string unit, bool quiet)
    : label_(std::move(label)),
      total_(total),
      unit_(std::move(unit)),
      quiet_(quiet),
      terminal_(::isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {
  if (quiet_) return;
  try {
    watcher_ = std::thread([this] { watch(); });
  } catch (const std::exception&) {  // no thread available: the work goes on without progress output
  }
}

Progress::~Progress() { finish(); }

void Progress::rename(std::string label) {
  const std::lock_guard<std::mutex> lock(mutex_);
  label_ = std::move(label);
}

void Progress::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ended_.wait_for(lock, terminal_ ? kOnTerminal : kElsewhere, [this] { return finished_; })) {
    try {
      draw(false);
    } catch (const std::exception&) {  // out of memory: the work itself will report that
    }
  }
}

void Progress::finish() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (finished_) return;
    finished_ = true;
    try {
      if (!quiet_ && drawn_) draw(true);  // no output for work that ends before the first draw
    } catch (const std::exception&) {
    }
  }
  ended_.notify_all();
  if (watcher_.joinable()) watcher_.join();
}

void Progress::draw(bool last) {
  drawn_ = true;
  const double seconds = std::max(1e-3, 1e-3 * static_cast<double>(elapsed_ms(start_)));
  const double done = static_cast<double>(done_.load());
  std::string line = label_;
  double share = last ? 1.0 : 0.0;
  if (total_ == 0 || done == 0.0) {
    line += fmt::format("  {:.0f} s", seconds);
  } else {
    share = std::min(1.0, done / static_cast<double>(total_));
    line += fmt::format(" {:3.0f} % {}{}/s", 100.0 * share, si(done / seconds), unit_);
    if (!last) {
      line += fmt::format(", {:.0f} s left", std::max(0.0, (static_cast<double>(total_) - done) * seconds / done));
    }
  }
  if (terminal_) {
    const int width = 24;
    const int filled = static_cast<int>(share * width);
    std::fprintf(stderr, "\r\033[K[%s%s] %s%s", std::string(static_cast<std::size_t>(filled), '#').c_str(),
                 std::string(static_cast<std::size_t>(width - filled), '.').c_str(), line.c_str(), last ? "\n" : "");
    std::fflush(stderr);
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

}  // namespace grtx
