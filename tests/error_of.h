// SPDX-License-Identifier: Apache-2.0
// What a call throws.
#pragma once

#include <string>

#include "grtx/base/error.h"

namespace grtx::test {

/// The text of the Error; "" when there is none.
template <typename Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace grtx::test
