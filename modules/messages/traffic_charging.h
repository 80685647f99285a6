// Whether what a ray keeps in memory costs traffic there: an assumption of a model, not hardware.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::modules {

/// charged: every entry is memory requests. uncharged: entries are there at once and nobody carries them.
enum class TrafficCharging : std::uint8_t { charged, uncharged };
constexpr auto enum_names(TrafficCharging) { return names_in_order<TrafficCharging>({"charged", "uncharged"}); }

}  // namespace grtx::modules
