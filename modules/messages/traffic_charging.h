// SPDX-License-Identifier: Apache-2.0
// Whether per-ray data in memory causes memory traffic: a modelling assumption, not hardware.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::modules {

/// charged: entries are read and written by memory requests. uncharged: they are available at once, without traffic.
enum class TrafficCharging : std::uint8_t { charged, uncharged };
constexpr auto enum_names(TrafficCharging) { return names_in_order<TrafficCharging>({"charged", "uncharged"}); }

}  // namespace grtx::modules
