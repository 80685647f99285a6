// A value that another launch begins as its constructor makes it.
#pragma once

#include <memory>
#include <utility>

namespace grtx::modules {

/// Also for classes that hold references and cannot be assigned to. Whoever refers to `object` refers to the new value.
/// The arguments made one before, so the constructor does not throw.
template <typename T, typename... Arguments>
void make_anew(T& object, Arguments&&... arguments) {
  std::destroy_at(&object);
  std::construct_at(&object, std::forward<Arguments>(arguments)...);
}

}  // namespace grtx::modules
