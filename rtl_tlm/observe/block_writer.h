// SPDX-License-Identifier: Apache-2.0
// Hands records in blocks to a thread that writes them in order. The producer waits if kWaiting blocks are unwritten.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace grtx::sim {

template <typename Record>
class BlockWriter {
 public:
  using Write = std::function<void(const std::vector<Record>&)>;

  /// write(block) is called on the thread; an exception that it throws is rethrown by push() or finish(), and nothing
  /// is written after it.
  explicit BlockWriter(Write write) : write_(std::move(write)), thread_([this] { run(); }) { block_.reserve(kBlock); }
  /// Without finish(), blocks that still wait are dropped.
  ~BlockWriter() {
    {
      const std::lock_guard lock(mutex_);
      waiting_.clear();
      ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  BlockWriter(const BlockWriter&) = delete;
  BlockWriter& operator=(const BlockWriter&) = delete;

  void push(const Record& record) {
    block_.push_back(record);
    if (block_.size() == kBlock) hand_over();
  }
  /// Returns when all is written.
  void finish() {
    if (!block_.empty()) hand_over();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return failed_ || (waiting_.empty() && !writing_); });
    if (failed_) std::rethrow_exception(failed_);
  }

 private:
  static constexpr std::size_t kBlock = 1 << 15;
  static constexpr std::size_t kWaiting = 8;

  void hand_over() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return failed_ || waiting_.size() < kWaiting; });
    if (failed_) std::rethrow_exception(failed_);
    waiting_.push_back(std::move(block_));
    block_ = std::move(spare_);
    lock.unlock();
    changed_.notify_all();
    block_.clear();
    block_.reserve(kBlock);
  }

  void run() {
    std::vector<Record> block;
    for (;;) {
      std::unique_lock lock(mutex_);
      writing_ = false;
      if (block.capacity() != 0) spare_ = std::move(block);
      changed_.notify_all();
      changed_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      block = std::move(waiting_.front());
      waiting_.pop_front();
      writing_ = true;
      lock.unlock();
      try {
        write_(block);
      } catch (...) {
        lock.lock();
        failed_ = std::current_exception();
        waiting_.clear();
        writing_ = false;
        changed_.notify_all();
        return;
      }
    }
  }

  Write write_;
  std::vector<Record> block_;  ///< being filled by the producer
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::vector<Record>> waiting_;
  std::vector<Record> spare_;  ///< a written block, for its memory
  bool writing_ = false;
  bool ended_ = false;
  std::exception_ptr failed_;
  std::thread thread_;
};

}  // namespace grtx::sim
