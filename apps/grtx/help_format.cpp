// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/help_format.h"

#include <fmt/format.h>

namespace grtx::apps {
namespace {

/// "" or ` Needs: --a --b`.
std::string others(const char* label, const auto& options) {
  std::string text;
  for (const CLI::Option* option : options) text += " " + option->get_name();
  return text.empty() ? "" : fmt::format(" {}:{}", label, text);
}

}  // namespace

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  std::string text;
  if (option->get_type_size() != 0) {  // no flag
    const std::string type = option->get_type_name(), given = option->get_default_str();
    if (!type.empty()) text += " " + type;
    if (!given.empty()) text += "=" + (given == "{}" ? "[]" : given);  // an empty list
    if (option->get_expected_max() == CLI::detail::expected_max_vector_size) {
      text += " ...";
    } else if (option->get_expected_min() > 1) {
      text += fmt::format(" x {}", option->get_expected());
    }
    if (option->get_required()) text += " REQUIRED";
  }
  return text + others("Needs", option->get_needs()) + others("Excludes", option->get_excludes());
}

}  // namespace grtx::apps
