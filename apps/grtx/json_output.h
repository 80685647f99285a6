// SPDX-License-Identifier: Apache-2.0
// --json: output of a command as one JSON document on stdout instead of text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace grtx::apps {

/// Help text of --json for a command. Throws std::out_of_range for a command without an entry in the table.
std::string json_help(std::string_view command);

/// An object whose first member, "schema", names the format of the command's --json output.
nlohmann::ordered_json json_document(std::string_view command);

/// Prints the document.
void print_json(const nlohmann::ordered_json& document);

/// Prints a document with a long list without holding it in memory. Prints the same bytes as print_json() of {head,
/// name: [items], tail}.
class JsonListPrinter {
 public:
  /// head: an object, as json_document() makes it; not empty.
  JsonListPrinter(const nlohmann::ordered_json& head, const std::string& name);
  void add(const nlohmann::ordered_json& item);
  /// Ends the list, appends the members of tail (at least one), and ends the document.
  void end(const nlohmann::ordered_json& tail);

 private:
  bool empty_ = true;
};

/// The --json output of each command, as a Markdown table.
std::string json_reference();

}  // namespace grtx::apps
