// Strong types for numbers that must not mix.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace grtx {

/// A number of type T that only compares and assigns with its own kind; `value` is the way in and out.
template <typename T, typename Tag>
struct Strong {
  T value{};
  constexpr Strong() = default;
  constexpr explicit Strong(T v) : value(v) {}
  friend constexpr auto operator<=>(const Strong&, const Strong&) = default;
};

/// Byte address inside the acceleration structure's node image.
using NodeAddress = Strong<std::uint64_t, struct NodeAddressTag>;
/// Row of a Gaussian in the loaded scene.
using GaussianId = Strong<std::uint32_t, struct GaussianIdTag>;
/// One bit a lane.
using LaneMask = std::uint64_t;
/// Clock cycles of the domain that the context names (core unless said).
using Cycle = std::uint64_t;

}  // namespace grtx

template <typename T, typename Tag>
struct std::hash<grtx::Strong<T, Tag>> {
  std::size_t operator()(const grtx::Strong<T, Tag>& s) const noexcept { return std::hash<T>{}(s.value); }
};
