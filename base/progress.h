// SPDX-License-Identifier: Apache-2.0
// Progress of long work: a bar with rate and time left on a terminal, otherwise plain lines every few seconds.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

namespace grtx {

/// Draws twice per second on a terminal and every five seconds elsewhere, from a separate thread, so also while no
/// progress is reported.
class Progress {
 public:
  /// label: what is being done. total: amount of work in `unit`s; 0 if unknown, then only the time is shown. quiet:
  /// print nothing.
  Progress(std::string label, std::uint64_t total, std::string unit, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Adds finished work. Thread-safe and cheap.
  void add(std::uint64_t amount) { done_ += amount; }
  /// Sets the finished work. Thread-safe and cheap.
  void set(std::uint64_t done) { done_ = done; }
  /// Changes the label. Thread-safe.
  void rename(std::string label);
  /// Ends the bar with a newline. The destructor calls it if needed.
  void finish();

 private:
  void draw(bool last);
  void watch();

  std::string label_;
  const std::uint64_t total_;
  const std::string unit_;
  const bool quiet_;
  const bool terminal_;
  const std::chrono::steady_clock::time_point start_;
  std::atomic<std::uint64_t> done_{0};
  std::mutex mutex_;  ///< protects label_, finished_, drawn_ and the output
  std::condition_variable ended_;
  bool finished_ = false;
  bool drawn_ = false;
  std::thread watcher_;
};

}  // namespace grtx
