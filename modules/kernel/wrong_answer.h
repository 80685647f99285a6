// SPDX-License-Identifier: Apache-2.0
// What a unit or a policy of a user's is blamed with when it breaks the contract of its interface; without SystemC, so
// that decisions can throw it, too.
#pragma once

#include <stdexcept>

namespace grtx::modules {

/// Its text is the broken rule. Thrown by code that detects a wrong answer; the caller that knows which unit gave it,
/// at the latest the clock domain that called the unit, turns it into unit_fault().
struct WrongAnswer : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace grtx::modules
