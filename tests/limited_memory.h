// SPDX-License-Identifier: Apache-2.0
// A process with little memory left.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

namespace grtx::test {

/// Leaves so many bytes to the process until it ends (Linux: RLIMIT_DATA).
class LimitedMemory {
 public:
  explicit LimitedMemory(std::uint64_t left) {
    ::getrlimit(RLIMIT_DATA, &before_);
    std::ifstream file("/proc/self/status");
    std::string name;
    std::uint64_t kib = 0;
    while (file >> name && name != "VmData:") file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    file >> kib;
    rlimit limit = before_;
    limit.rlim_cur = kib * 1024 + left;
    ::setrlimit(RLIMIT_DATA, &limit);
  }
  ~LimitedMemory() { ::setrlimit(RLIMIT_DATA, &before_); }
  LimitedMemory(const LimitedMemory&) = delete;
  LimitedMemory& operator=(const LimitedMemory&) = delete;

 private:
  rlimit before_{};
};

}  // namespace grtx::test
