// --json: what a command says, as one JSON document on stdout in place of its text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace grtx::sim {

/// The words of a command's --help on --json. Throws std::out_of_range for a command without an entry in the table.
std::string json_help(std::string_view command);

/// An object whose first member is the schema of what the command prints with --json.
nlohmann::ordered_json json_document(std::string_view command);

/// Prints the document. Text in it that is no UTF-8 (a path) gets replacement characters.
void print_json(const nlohmann::ordered_json& document);

/// What each command prints with --json, as a table in Markdown.
std::string json_reference();

}  // namespace grtx::sim
