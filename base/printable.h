// SPDX-License-Identifier: Apache-2.0
// Escapes foreign text for messages and documents, so that it cannot break lines, send terminal control sequences or
// make the output invalid UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace grtx {

/// `text` with bytes that are not valid UTF-8 escaped, e.g. \xfc.
std::string utf8(std::string_view text);

/// utf8() with control characters escaped as well, e.g. \n, \x1b.
std::string printable(std::string_view text);

}  // namespace grtx
