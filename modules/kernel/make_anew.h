// SPDX-License-Identifier: Apache-2.0
// Reconstructs an object in place, for the start of another launch.
#pragma once

#include <memory>
#include <utility>

namespace grtx::modules {

/// Also for classes that hold references and cannot be assigned to. References to `object` stay valid. Pass the
/// arguments of the first construction, so that the constructor does not throw.
template <typename T, typename... Arguments>
void make_anew(T& object, Arguments&&... arguments) {
  std::destroy_at(&object);
  std::construct_at(&object, std::forward<Arguments>(arguments)...);
}

}  // namespace grtx::modules
