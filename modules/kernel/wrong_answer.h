// SPDX-License-Identifier: Apache-2.0
// Exception for a user-supplied unit or policy that breaks the contract of its interface; without SystemC, so that
// decisions can throw it, too.
#pragma once

#include <stdexcept>

namespace grtx::modules {

/// The text is the broken rule. Thrown by code that detects a wrong answer; the caller that knows which unit gave it,
/// at the latest the clock domain that called the unit, turns it into unit_fault().
struct WrongAnswer : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace grtx::modules
