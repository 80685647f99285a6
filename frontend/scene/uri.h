// SPDX-License-Identifier: Apache-2.0
// Decoding of URIs in scene files.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace grtx::frontend {

/// The bytes encoded by RFC 4648's base64; nothing if it is malformed.
std::optional<std::string> decode_base64(std::string_view text);

/// A URI's path with each %XX replaced by its byte; malformed sequences stay.
std::string percent_decoded(const std::string& uri);

}  // namespace grtx::frontend
