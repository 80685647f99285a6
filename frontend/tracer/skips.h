// Work that the tracer leaves out because it changes no bit of the image. docs/model/skips.md has what each saves.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>

#include "grtx/base/declare/named_enum.h"

namespace grtx::frontend {

enum class Skip : std::uint8_t {
  retests,         ///< boxes, instances and leaves that the ray has tested before
  dead_colours,    ///< colours of hits behind the one that ended the ray
  sh_bands,        ///< spherical harmonics above the scene's degree
  scene_miss,      ///< the round of a ray that misses all boxes of the root
  events,          ///< trace events when no trace is written
  never_accepted,  ///< Gaussians whose alpha never reaches 1/255
  blas,            ///< walks of the shared BLAS: the hit function decides at the instance leaf
};
inline constexpr unsigned kSkipCount = 7;

/// A set of skips.
class Skips {
 public:
  constexpr Skips() = default;
  constexpr Skips(std::initializer_list<Skip> skips) {
    for (const Skip skip : skips) bits_ |= 1u << static_cast<unsigned>(skip);
  }
  constexpr bool has(Skip skip) const { return (bits_ >> static_cast<unsigned>(skip) & 1u) != 0; }
  constexpr void add(Skip skip) { bits_ |= 1u << static_cast<unsigned>(skip); }
  /// Node visits, any-hit calls and traces are those of the hardware.
  constexpr bool faithful() const { return !has(Skip::never_accepted) && !has(Skip::blas); }
  friend constexpr bool operator==(const Skips&, const Skips&) = default;

 private:
  std::uint32_t bits_ = 0;
};

/// Those that leave node visits, any-hit calls and traces alone.
inline constexpr Skips kFaithfulSkips{Skip::retests, Skip::dead_colours, Skip::sh_bands, Skip::scene_miss,
                                      Skip::events};
inline constexpr Skips kAllSkips{Skip::retests, Skip::dead_colours,   Skip::sh_bands, Skip::scene_miss,
                                 Skip::events,  Skip::never_accepted, Skip::blas};

/// What --skip takes.
enum class SkipSet : std::uint8_t { none, faithful, all };
constexpr auto enum_names(SkipSet) { return names_in_order<SkipSet>({"none", "faithful", "all"}); }
constexpr Skips skips_of(SkipSet set) {
  return set == SkipSet::all ? kAllSkips : set == SkipSet::faithful ? kFaithfulSkips : Skips{};
}

}  // namespace grtx::frontend
