// Units that factories of a user's own make in place of the project's.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "grtx/base/error.h"

namespace grtx::modules {

/// factory: its name. Throws Error when it made nothing.
template <typename Part>
std::unique_ptr<Part> not_null(std::unique_ptr<Part> part, const char* factory) {
  if (part == nullptr) throw Error("parts", factory, "its factory made nothing");
  return part;
}

/// What the factory makes of `arguments` if there is one, else an Own of them.
template <typename Own, typename Part, typename... Parameters, typename... Arguments>
std::unique_ptr<Part> made(const std::function<std::unique_ptr<Part>(Parameters...)>& factory, const char* name,
                           Arguments&&... arguments) {
  if (factory) return not_null(factory(std::forward<Arguments>(arguments)...), name);
  return std::make_unique<Own>(std::forward<Arguments>(arguments)...);
}

}  // namespace grtx::modules
