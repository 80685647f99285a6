// Progress of long work: a bar with rate and time left on a terminal, plain lines every few seconds otherwise.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace grtx {

class Progress {
 public:
  /// label: what is being done; total: amount of work in `unit`s; quiet silences everything.
  Progress(std::string label, std::uint64_t total, std::string unit, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Adds finished work. Thread-safe; cheap between redraws.
  void add(std::uint64_t amount);
  /// Sets the finished work instead of adding. Thread-safe.
  void set(std::uint64_t done);
  /// Ends the bar with a newline. Called by the destructor when forgotten.
  void finish();

 private:
  void draw(bool last);

  std::string label_;
  std::uint64_t total_;
  std::string unit_;
  bool quiet_;
  bool terminal_;
  bool finished_ = false;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<std::int64_t> next_draw_ms_{0};
  std::chrono::steady_clock::time_point start_;
  std::mutex mutex_;
};

}  // namespace grtx
