// JSON from outside, with errors that name the file and the place.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace grtx::sim {

/// file: for messages. Throws Error for what is no JSON and for numbers that no double can hold.
nlohmann::ordered_json parse_json(const std::string& text, const std::string& file);
/// The whole file.
nlohmann::ordered_json read_json(const std::string& path);

}  // namespace grtx::sim
