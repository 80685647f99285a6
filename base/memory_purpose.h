// What memory is asked for: so that a program that gets none can say more than that.
#pragma once

#include <array>
#include <string>

namespace grtx {

/// `what` is said when there is no memory left before this ends, or when an exception ends it. Of the main thread.
class MemoryPurpose {
 public:
  explicit MemoryPurpose(const std::string& what);
  ~MemoryPurpose();
  MemoryPurpose(const MemoryPurpose&) = delete;
  MemoryPurpose& operator=(const MemoryPurpose&) = delete;

  /// The purpose that began last; "" when there is none. Takes no memory.
  static const char* latest();

 private:
  std::array<char, 400> before_;
  int exceptions_;
};

}  // namespace grtx
