// SPDX-License-Identifier: Apache-2.0
// Records what memory is being allocated for, so that an out-of-memory message can say it.
#pragma once

#include <array>
#include <string>

namespace grtx {

/// Scope in which an out-of-memory message says `what`, also if the exception leaves the scope. Main thread only.
class MemoryPurpose {
 public:
  explicit MemoryPurpose(const std::string& what);
  ~MemoryPurpose();
  MemoryPurpose(const MemoryPurpose&) = delete;
  MemoryPurpose& operator=(const MemoryPurpose&) = delete;

  /// The innermost purpose; "" if there is none. Does not allocate.
  static const char* latest();

 private:
  std::array<char, 400> before_;
  int exceptions_;
};

}  // namespace grtx
