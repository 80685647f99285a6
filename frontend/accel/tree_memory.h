// SPDX-License-Identifier: Apache-2.0
// Memory of a tree between its build and its packing. Each thread takes chunks of its own and fills them node by node;
// a chunk goes back to the system when the last of its nodes has been read.
#pragma once

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>
#include <thread>
#include <utility>

#include "grtx/base/huge_pages.h"

namespace grtx::frontend {

class TreeMemory {
 public:
  /// most_bytes: upper bound on the size of all nodes; memory that stays unused is never touched.
  explicit TreeMemory(std::size_t most_bytes)
      : chunks_(most_bytes / (sizeof(Chunk::nodes) - kLargestNode) + 4 * most_threads() + 8) {}
  TreeMemory(const TreeMemory&) = delete;
  TreeMemory& operator=(const TreeMemory&) = delete;

  /// Memory for one node of `bytes` (at most kLargestNode), aligned to 16. Call from any thread.
  void* allocate(std::size_t bytes) {
    Cursor& cursor = cursors_.local();
    bytes = (bytes + 15) / 16 * 16;
    if (static_cast<std::size_t>(cursor.end - cursor.at) < bytes) open_chunk(cursor);
    ++cursor.chunk->unread;
    return std::exchange(cursor.at, cursor.at + bytes);
  }

  /// The node will not be read any more. Call from any thread, after the last allocate().
  void release(const void* node) {
    const auto offset = reinterpret_cast<std::uintptr_t>(node) - reinterpret_cast<std::uintptr_t>(chunks_.data());
    Chunk* const chunk = &chunks_[offset / sizeof(Chunk)];
    const std::atomic_ref unread(chunk->unread);
    if (unread.fetch_sub(1, std::memory_order_acq_rel) == 1) release_pages(chunk, chunk + 1);
  }

  static constexpr std::size_t kLargestNode = 512;

 private:
  struct Chunk {
    std::uint32_t unread;  ///< nodes in it not yet released
    alignas(64) std::uint8_t nodes[kHugePageBytes - 64];
  };
  static_assert(sizeof(Chunk) == kHugePageBytes);

  struct Cursor {
    Chunk* chunk = nullptr;
    std::uint8_t* at = nullptr;
    std::uint8_t* end = nullptr;
  };

  // Each thread leaves one chunk partly filled. Workers may take turns, so that more of them allocate than run at once.
  static std::size_t most_threads() {
    return std::max<std::size_t>(std::thread::hardware_concurrency(),
                                 tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  }

  void open_chunk(Cursor& cursor) {
    const std::size_t number = opened_.fetch_add(1, std::memory_order_relaxed);
    if (number >= chunks_.size()) throw std::bad_alloc();
    cursor.chunk = &chunks_[number];
    cursor.at = cursor.chunk->nodes;
    cursor.end = cursor.at + sizeof cursor.chunk->nodes;
  }

  ZeroedPages<Chunk> chunks_;
  std::atomic<std::size_t> opened_{0};
  tbb::enumerable_thread_specific<Cursor, tbb::cache_aligned_allocator<Cursor>, tbb::ets_key_per_instance> cursors_;
};

}  // namespace grtx::frontend
