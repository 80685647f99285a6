// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/free_memory.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "grtx/base/error.h"

namespace grtx {
namespace {

constexpr std::uint64_t kNotAsked = std::uint64_t{8}
                                    << 20;  ///< bytes; smaller amounts are not checked, as a check takes about 20 us

/// Value in bytes of `key` in a file of /proc ("MemAvailable:  123 kB").
std::optional<std::uint64_t> proc_bytes(const char* path, const std::string& key) {
  std::ifstream file(path);
  std::string name;
  while (file >> name) {
    std::uint64_t kib = 0;
    if (name == key && file >> kib) return kib * 1024;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> free_memory() {
  std::optional<std::uint64_t> free = proc_bytes("/proc/meminfo", "MemAvailable:");
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return free;
  const std::optional<std::uint64_t> taken = proc_bytes("/proc/self/status", "VmData:");
  if (!taken) return free;
  const std::uint64_t left = limit.rlim_cur - std::min<std::uint64_t>(*taken, limit.rlim_cur);
  return free ? std::min(*free, left) : left;
}

std::string memory_fault(std::uint64_t bytes) {
  if (bytes < kNotAsked) return "";
  const std::optional<std::uint64_t> free = free_memory();
  if (!free || bytes <= *free) return "";
  return fmt::format("takes {} MB more memory, and {} MB are free", bytes / 1'000'000, *free / 1'000'000);
}

void require_memory(std::uint64_t bytes, const std::string& file, const std::string& place) {
  if (const std::string fault = memory_fault(bytes); !fault.empty()) throw Error(file, place, fault);
}

}  // namespace grtx
