// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/memory_purpose.h"

#include <exception>

namespace grtx {
namespace {

std::array<char, 400> present{};

}  // namespace

MemoryPurpose::MemoryPurpose(const std::string& what) : before_(present), exceptions_(std::uncaught_exceptions()) {
  present[what.copy(present.data(), present.size() - 1)] = '\0';
}

MemoryPurpose::~MemoryPurpose() {
  if (std::uncaught_exceptions() == exceptions_) present = before_;
}

const char* MemoryPurpose::latest() { return present.data(); }

}  // namespace grtx
