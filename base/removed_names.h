// SPDX-License-Identifier: Apache-2.0
// Names of options, keys and values that earlier versions had, and what is in their place.
#pragma once

#include <string>
#include <string_view>

namespace grtx {

/// What is in the place of a removed name: a name of the same kind or words. "" if the name was never there.
std::string in_place_of(std::string_view name);

/// Behind "unknown key 'x', ": what is in its place, where the name was removed; "" if it was never there.
std::string said_of_removed(std::string_view name);

}  // namespace grtx
