// JSON of others and JSON for others: read with errors that name the file and the place, written as UTF-8 whatever a
// path in it holds.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace grtx {

/// Lists and objects inside each other in what is read: a document is copied and written level by level of the stack.
inline constexpr int kMostJsonLevels = 128;
/// The rule of a text that has more.
std::string json_levels_rule();

/// file and place: of the text, for messages; place "" for a whole file. Throws Error for what is no JSON, for more
/// than kMostJsonLevels and for numbers that no double can hold. Json: nlohmann::json or ordered_json.
template <typename Json = nlohmann::ordered_json>
Json parse_json(std::string_view text, const std::string& file, const std::string& place = "");
/// The whole file.
template <typename Json = nlohmann::ordered_json>
Json read_json(const std::string& path);

/// The document as text; indent: spaces a level, -1 for one line. A path may hold any bytes: those that are no UTF-8
/// are written as \xNN, as in messages.
template <typename Json>
std::string json_text(const Json& json, int indent = -1);

/// The same for another process that opens the paths in it. Throws Error that names a text that is no UTF-8.
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
