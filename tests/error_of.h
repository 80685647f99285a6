// What a call throws.
#pragma once

#include <string>

#include "error_of.h"
#include "grtx/base/error.h"

namespace grtx::test {

/// The text of the Error; "" when there is none.
template <typename Call>
std::string error_of(const Call& call) {
  return grtx::test::error_of([&] { call(); });
}

}  // namespace grtx::test
