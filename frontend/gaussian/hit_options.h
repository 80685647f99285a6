// SPDX-License-Identifier: Apache-2.0
// Options of a hit: the distance that orders it, whether it counts, and how its response is computed.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::frontend {

/// Which distance orders a ray's hits: entry into the proxy, or peak response.
enum class SortKey : std::uint8_t { entry, peak };
constexpr auto enum_names(SortKey) { return names_in_order<SortKey>({"entry", "peak"}); }

/// Treatment of a Gaussian whose proxy contains the ray origin: it is skipped, or it counts as a hit (spheres only).
enum class InsideRule : std::uint8_t { skip, count };
constexpr auto enum_names(InsideRule) { return names_in_order<InsideRule>({"skip", "count"}); }

/// How the response is computed: fp32, or every step rounded to a 16-bit format (a cheaper blending unit).
enum class ResponsePrecision : std::uint8_t { fp32, fp16, bf16 };
constexpr auto enum_names(ResponsePrecision) { return names_in_order<ResponsePrecision>({"fp32", "fp16", "bf16"}); }

}  // namespace grtx::frontend
