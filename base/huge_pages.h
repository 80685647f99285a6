// SPDX-License-Identifier: Apache-2.0
// Memory in 2 MiB pages for large arrays with random accesses: with small pages a tree walk spends its time on TLB
// misses. Falls back to ordinary pages if the system has no others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace grtx {

inline constexpr std::size_t kHugePageBytes = std::size_t{2} << 20;

template <typename T>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <typename U>
  explicit HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(std::size_t count) {
    std::size_t bytes = count * sizeof(T);
    const bool huge = bytes >= 2 * kHugePageBytes;
    const std::size_t alignment = huge ? kHugePageBytes : alignof(std::max_align_t) < 64 ? 64 : alignof(T);
    bytes = (bytes + alignment - 1) / alignment * alignment;
    void* memory = std::aligned_alloc(alignment, bytes);
    if (memory == nullptr) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (huge) madvise(memory, bytes, MADV_HUGEPAGE);  // only a hint: errors do not matter
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }

  template <typename U>
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator<U>&) {
    return true;
  }
};

template <typename T>
using HugePageVector = std::vector<T, HugePageAllocator<T>>;

/// A large array, initially all zero bytes. Pages take memory only when written, so one array can be filled while its
/// source array shrinks (release_pages()).
template <typename T>
class ZeroedPages {
  static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kHugePageBytes);

 public:
  explicit ZeroedPages(std::size_t count = 0) : size_(count), reserved_(count * sizeof(T) + kHugePageBytes) {
#if defined(__linux__)
    memory_ = mmap(nullptr, reserved_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory_ == MAP_FAILED) memory_ = nullptr;
#else
    memory_ = std::calloc(reserved_, 1);
#endif
    if (memory_ == nullptr) throw std::bad_alloc();
    const auto begin = reinterpret_cast<std::uintptr_t>(memory_);
    data_ = reinterpret_cast<T*>((begin + kHugePageBytes - 1) / kHugePageBytes * kHugePageBytes);
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (count * sizeof(T) >= 2 * kHugePageBytes) madvise(data_, count * sizeof(T), MADV_HUGEPAGE);  // only a hint
#endif
  }
  ZeroedPages(ZeroedPages&& other) noexcept { swap(other); }
  ZeroedPages& operator=(ZeroedPages&& other) noexcept {
    swap(other);
    return *this;
  }
  ~ZeroedPages() {
    if (memory_ == nullptr) return;
#if defined(__linux__)
    munmap(memory_, reserved_);
#else
    std::free(memory_);
#endif
  }

  std::size_t size() const { return size_; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  void swap(ZeroedPages& other) noexcept {
    std::swap(size_, other.size_);
    std::swap(reserved_, other.reserved_);
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
  }
  std::size_t size_ = 0;
  std::size_t reserved_ = 0;
  void* memory_ = nullptr;
  T* data_ = nullptr;
};

/// Returns the whole pages in [begin, end) to the system; their contents are lost. For arrays that are read once, from
/// front to back.
inline void release_pages(const void* begin, const void* end) {
#if defined(__linux__)
  constexpr std::uintptr_t kPage = 4096;
  const auto first = (reinterpret_cast<std::uintptr_t>(begin) + kPage - 1) / kPage * kPage;
  const auto last = reinterpret_cast<std::uintptr_t>(end) / kPage * kPage;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
#else
  static_cast<void>(begin);
  static_cast<void>(end);
#endif
}

}  // namespace grtx
