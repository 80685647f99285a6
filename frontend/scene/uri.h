// What URIs in scene files stand for.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace grtx::frontend {

/// The bytes that RFC 4648's base64 stands for; nothing when it is none.
std::optional<std::string> decode_base64(std::string_view text);

/// A URI's path with %XX as the byte that it stands for; what is no such number stays.
std::string percent_decoded(const std::string& uri);

}  // namespace grtx::frontend
