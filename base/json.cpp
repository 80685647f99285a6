// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/json.h"

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/printable.h"

namespace grtx {
namespace {

/// Position (from 1) of the byte at which the nesting exceeds kMostJsonLevels; 0 if it does not.
std::size_t too_deep_at(std::string_view text) {
  int level = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string && (c == '[' || c == '{')) {
      if (++level > kMostJsonLevels) return i + 1;
    } else if (!in_string && (c == ']' || c == '}')) {
      --level;
    }
  }
  return 0;
}

template <typename Json>
void make_utf8(Json& json) {
  if (json.is_string()) {
    json = utf8(json.template get_ref<const std::string&>());
  } else if (json.is_array()) {
    for (Json& entry : json) make_utf8(entry);
  } else if (json.is_object()) {
    Json made = Json::object();
    for (auto& [name, value] : json.items()) {
      make_utf8(value);
      made[utf8(name)] = std::move(value);
    }
    json = std::move(made);
  }
}

template <typename Json>
void require_utf8(const Json& json) {
  if (json.is_string()) {
    const auto& text = json.template get_ref<const std::string&>();
    if (utf8(text) != text) throw Error(text, "", "must be UTF-8: it is handed on as JSON");
  } else if (json.is_structured()) {
    for (const Json& entry : json) require_utf8(entry);
  }
}

}  // namespace

std::string json_levels_rule() {
  return "must be nested at most " + std::to_string(kMostJsonLevels) + " levels deep, as JSON";
}

template <typename Json>
Json parse_json(std::string_view text, const std::string& file, const std::string& place) {
  const auto at = [&place](std::size_t byte) {
    return (place.empty() ? "" : place + ": ") + "byte " + std::to_string(byte);
  };
  if (const std::size_t byte = too_deep_at(text); byte != 0) throw Error(file, at(byte), json_levels_rule());
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw Error(file, at(error.byte), "is not valid JSON");
  } catch (const nlohmann::json::out_of_range&) {
    throw Error(file, place, "is not readable JSON: holds a number that no double can hold");
  }
}

template <typename Json>
Json read_json(const std::string& path) {
  return parse_json<Json>(read_file(path), path);
}

template <typename Json>
std::string json_text(const Json& json, int indent) {
  try {
    return json.dump(indent);
  } catch (const nlohmann::json::type_error&) {  // a text is not UTF-8
    Json made = json;
    make_utf8(made);
    return made.dump(indent);
  }
}

template <typename Json>
std::string exact_json_text(const Json& json) {
  require_utf8(json);
  return json.dump();
}

template nlohmann::json parse_json(std::string_view, const std::string&, const std::string&);
template nlohmann::ordered_json parse_json(std::string_view, const std::string&, const std::string&);
template nlohmann::json read_json(const std::string&);
template nlohmann::ordered_json read_json(const std::string&);
template std::string json_text(const nlohmann::json&, int);
template std::string json_text(const nlohmann::ordered_json&, int);
template std::string exact_json_text(const nlohmann::json&);
template std::string exact_json_text(const nlohmann::ordered_json&);

}  // namespace grtx
