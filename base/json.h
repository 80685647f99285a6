// SPDX-License-Identifier: Apache-2.0
// JSON input with errors that name file and place, and output that is always valid UTF-8, even for paths that are not.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace grtx {

/// Deepest nesting of lists and objects in input. Limited because copying and writing a document recurse per level.
inline constexpr int kMostJsonLevels = 128;
/// Error text for deeper nesting.
std::string json_levels_rule();

/// Parses `text`. file, place: for messages; place "" for a whole file. Throws Error for invalid JSON, for nesting
/// beyond kMostJsonLevels and for numbers beyond the range of double. Json: nlohmann::json or ordered_json.
template <typename Json = nlohmann::ordered_json>
Json parse_json(std::string_view text, const std::string& file, const std::string& place = "");
/// Reads and parses a file.
template <typename Json = nlohmann::ordered_json>
Json read_json(const std::string& path);

/// The document as text. indent: spaces per level, -1 for one line. Bytes that are not UTF-8, as paths may contain, are
/// written as `\xNN`, as in messages.
template <typename Json>
std::string json_text(const Json& json, int indent = -1);

/// The same for another process that opens the paths in it: throws Error naming a text that is not UTF-8.
template <typename Json>
std::string exact_json_text(const Json& json);

extern template nlohmann::json parse_json(std::string_view, const std::string&, const std::string&);
extern template nlohmann::ordered_json parse_json(std::string_view, const std::string&, const std::string&);
extern template nlohmann::json read_json(const std::string&);
extern template nlohmann::ordered_json read_json(const std::string&);
extern template std::string json_text(const nlohmann::json&, int);
extern template std::string json_text(const nlohmann::ordered_json&, int);
extern template std::string exact_json_text(const nlohmann::json&);
extern template std::string exact_json_text(const nlohmann::ordered_json&);

}  // namespace grtx
