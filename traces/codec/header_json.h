// Header and totals as JSON text, strict in both directions: every key present, none unknown.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "grtx/traces/header.h"

namespace grtx::traces {

/// As format_version() of the header has it.
std::string header_to_json(const Header& header);
/// version: of the file. Throws Malformed naming the key. The result obeys header_fault() == "".
Header header_from_json(std::string_view text, std::uint32_t version);
/// The rule that a header breaks, naming the field; "" when it is sound.
std::string header_fault(const Header& header);

std::string totals_to_json(const Totals& totals);
/// Throws Malformed naming the key.
Totals totals_from_json(std::string_view text);

}  // namespace grtx::traces
