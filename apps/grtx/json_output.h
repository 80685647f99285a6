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

/// Prints the document.
void print_json(const nlohmann::ordered_json& document);

/// Prints a document with a list so long that it is better never held as a whole, byte for byte as print_json() prints
/// {head, name: [items], tail}.
class JsonListPrinter {
 public:
  /// head: an object, as json_document() makes it; not empty.
  JsonListPrinter(const nlohmann::ordered_json& head, const std::string& name);
  void add(const nlohmann::ordered_json& item);
  /// Ends the list, and the document after the members of tail, of which there is one or more.
  void end(const nlohmann::ordered_json& tail);

 private:
  bool empty_ = true;
};

/// What each command prints with --json, as a table in Markdown.
std::string json_reference();

}  // namespace grtx::sim
