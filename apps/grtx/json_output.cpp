// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/json_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "grtx/base/json.h"

namespace grtx::apps {
namespace {

struct JsonForm {
  std::string_view command;
  std::string_view schema;  ///< value of its first member, "schema"; "" if it has none
  std::string_view what;
};
// In the order of grtx --help.
constexpr std::array<JsonForm, 20> kForms = {{
    {"synth", "grtx.synth/1", "the files and what is in them"},
    {"info", "grtx.info/1", "the description"},
    {"convert", "grtx.convert/1", "the file and what is in it"},
    {"trace", "grtx.stats/1", "what --stats writes"},
    {"reference", "grtx.reference/1", "the image and its size"},
    {"compare", "grtx.compare/1", "the differences"},
    {"trace-check", "grtx.trace_check/1", "the totals"},
    {"trace-dump", "", "JSON Lines with every field, the file, then a line per warp"},
    {"ray", "grtx.ray/1", "the page and what is on it"},
    {"sim", "grtx.stats/1", "what --stats writes"},
    {"machine", "grtx.machine/1", "every key and derived figure, with where it comes from"},
    {"cost", "grtx.cost/1", "the hierarchy with every item; with --stats the energy by part (grtx.energy/1)"},
    {"run", "grtx.run/2", "results.json"},
    {"stalls", "", "a list of sections with their bars"},
    {"report", "grtx.report/1", "the page and its inputs"},
    {"correlate", "grtx.correlate/1", "every figure with its error, and what follows from all"},
    {"sweep", "grtx.sweep/1", "points by state; with --list every point, with --compare what differs"},
    {"search", "grtx.search/1", "the result, as the database holds it"},
    {"regress", "grtx.regress/1", "every case with what differs"},
    {"selftest", "grtx.selftest/1", "every step with what differs"},
}};

const JsonForm& form_of(std::string_view command) {
  const auto* found = std::ranges::find(kForms, command, &JsonForm::command);
  if (found == kForms.end()) throw std::out_of_range(fmt::format("{} has no entry in the table of --json", command));
  return *found;
}

}  // namespace

std::string json_help(std::string_view command) {
  return fmt::format("Print JSON in place of text: {} (default: off)", form_of(command).what);
}

nlohmann::ordered_json json_document(std::string_view command) { return {{"schema", form_of(command).schema}}; }

void print_json(const nlohmann::ordered_json& document) { fmt::print("{}\n", json_text(document, 1)); }

JsonListPrinter::JsonListPrinter(const nlohmann::ordered_json& head, const std::string& name) {
  const std::string text = json_text(head, 1);
  fmt::print("{},\n {}: [", text.substr(0, text.rfind('\n')), json_text(nlohmann::ordered_json(name)));
}

void JsonListPrinter::add(const nlohmann::ordered_json& item) {
  std::string text = empty_ ? "\n  " : ",\n  ";
  for (const char c : json_text(item, 1)) {  // strings contain no line ends: these are escaped
    text += c;
    if (c == '\n') text += "  ";
  }
  fmt::print("{}", text);
  empty_ = false;
}

void JsonListPrinter::end(const nlohmann::ordered_json& tail) {
  fmt::print("{}],{}\n", empty_ ? "" : "\n ", json_text(tail, 1).substr(1));
}

std::string json_reference() {
  std::string text = "| command | `--json` prints | schema |\n|---|---|---|\n";
  for (const JsonForm& form : kForms) {
    text += fmt::format("| `{}` | {} | {} |\n", form.command, form.what,
                        form.schema.empty() ? "" : fmt::format("`{}`", form.schema));
  }
  return text;
}

}  // namespace grtx::apps
