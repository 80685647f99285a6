// Text of others in a message or a document: names that they chose neither break a line, nor steer a terminal, nor make
// it anything else than UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace grtx {

/// `text` with the bytes that are no UTF-8 escaped: \xfc.
std::string utf8(std::string_view text);

/// utf8() with control characters escaped, too: \n, \x1b.
std::string printable(std::string_view text);

}  // namespace grtx
