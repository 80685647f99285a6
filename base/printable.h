// Text of others in a message: names that they chose neither break a line nor steer a terminal.
#pragma once

#include <string>
#include <string_view>

namespace grtx {

/// `text`, UTF-8, with its control characters escaped: \n, \x1b.
std::string printable(std::string_view text);

}  // namespace grtx
