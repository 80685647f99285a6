// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/design_progress.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <new>
#include <numeric>
#include <utility>

namespace grtx::experiment {
namespace {

std::atomic<std::uint64_t>* shared_counts(std::size_t count) {
  void* const memory = ::mmap(nullptr, count * sizeof(std::atomic<std::uint64_t>), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return new (memory) std::atomic<std::uint64_t>[count]();
}

}  // namespace

DesignProgress::DesignProgress(std::vector<std::string> names, std::vector<std::uint64_t> warps, bool quiet)
    : names_(std::move(names)),
      warps_(std::move(warps)),
      shared_(shared_counts(names_.size())),
      progress_("simulating", std::accumulate(warps_.begin(), warps_.end(), std::uint64_t{0}), " warps", quiet) {
  for (std::size_t i = 0; i < names_.size(); ++i) counters_.emplace_back(shared_ + i);
}

DesignProgress::~DesignProgress() { ::munmap(shared_, names_.size() * sizeof(std::atomic<std::uint64_t>)); }

void DesignProgress::look() {
  std::string label = "simulating";
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::uint64_t ended = shared_[i].load(std::memory_order_relaxed);
    sum += ended;
    if (ended == 0 || ended >= warps_[i]) continue;
    label += fmt::format("{}{} {:.0f} %", label == "simulating" ? " " : ", ", names_[i],
                         100.0 * static_cast<double>(ended) / static_cast<double>(warps_[i]));
  }
  progress_.rename(label == "simulating" ? label : label + "; all");
  progress_.set(sum);
}

}  // namespace grtx::experiment
