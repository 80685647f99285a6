// SPDX-License-Identifier: Apache-2.0
// Lets a user's factory construct a unit in place of the project's own.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "grtx/base/error.h"

namespace grtx::modules {

/// Returns `part`. Throws Error if it is null; factory: its name for the message.
template <typename Part>
std::unique_ptr<Part> not_null(std::unique_ptr<Part> part, const char* factory) {
  if (part == nullptr) throw Error("parts", factory, "its factory made nothing");
  return part;
}

/// Constructs a part from `arguments`: by the factory if there is one, otherwise as the project's own class Own.
template <typename Own, typename Part, typename... Parameters, typename... Arguments>
std::unique_ptr<Part> made(const std::function<std::unique_ptr<Part>(Parameters...)>& factory, const char* name,
                           Arguments&&... arguments) {
  if (factory) return not_null(factory(std::forward<Arguments>(arguments)...), name);
  return std::make_unique<Own>(std::forward<Arguments>(arguments)...);
}

}  // namespace grtx::modules
