// SPDX-License-Identifier: Apache-2.0
// Suggests the nearest known name for a mistyped option, key or value.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace grtx {

/// The known name with the smallest edit distance (ties: first in the list); "" if `known` is empty.
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

/// "the nearest is 'NAME'" for a key in parts ("rt.stack.entries"): or, where others hold all of its words, "the
/// nearest are 'NAME', 'OTHER' and 'OTHER'", three at most.
std::string nearest_keys(std::string_view name, const std::vector<std::string>& known);

}  // namespace grtx
