// SPDX-License-Identifier: Apache-2.0
// Header and totals as JSON text, strict in both directions: every key present, none unknown.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "grtx/traces/header.h"

namespace grtx::traces {

/// Header as JSON, with the keys of format_version(header).
std::string header_to_json(const Header& header);
/// version: of the file. Throws Malformed naming the key. The result is valid (header_fault() is "").
Header header_from_json(std::string_view text, std::uint32_t version);
/// The rule that a header breaks, naming the field; "" if it is valid.
std::string header_fault(const Header& header);

/// Throws Malformed naming the key.
Totals totals_from_json(std::string_view text);

}  // namespace grtx::traces
