#include "grtx/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

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
  next_draw_ms_ = terminal_ ? 200 : 5000;
}

Progress::~Progress() { finish(); }

void Progress::add(std::uint64_t amount) {
  done_ += amount;
  if (!quiet_ && elapsed_ms(start_) >= next_draw_ms_) draw(false);
}

void Progress::set(std::uint64_t done) {
  done_ = done;
  if (!quiet_ && elapsed_ms(start_) >= next_draw_ms_) draw(false);
}

void Progress::finish() {
  if (finished_) return;
  finished_ = true;
  if (!quiet_ && (terminal_ || elapsed_ms(start_) >= 5000)) draw(true);
}

void Progress::draw(bool last) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::int64_t now = elapsed_ms(start_);
  if (!last && now < next_draw_ms_) return;
  next_draw_ms_ = now + (terminal_ ? 200 : 5000);
  const double seconds = std::max(1e-3, static_cast<double>(now) * 1e-3);
  const double done = static_cast<double>(done_.load());
  const double rate = done / seconds;
  const double share = total_ == 0 ? 1.0 : std::min(1.0, done / static_cast<double>(total_));
  std::string line = fmt::format("{} {:3.0f} % {}{}/s", label_, 100.0 * share, si(rate), unit_);
  if (!last && rate > 0.0 && total_ > 0) {
    line += fmt::format(", {:.0f} s left", std::max(0.0, (static_cast<double>(total_) - done) / rate));
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
