// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/help_format.h"

#include <fmt/format.h>

#include <algorithm>

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

std::string HelpFormat::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  std::vector<std::string> groups = app->get_groups();
  const auto expert = std::ranges::find(groups, kExpert);
  if (expert == groups.end()) return CLI::Formatter::make_help(app, std::move(name), mode);
  std::rotate(expert, expert + 1, groups.end());
  std::string text = make_description(app) + make_usage(app, name) + make_positionals(app);
  for (const std::string& group : groups) {
    const std::vector<const CLI::Option*> options = app->get_options(
        [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
    if (group.empty() || options.empty()) continue;
    text += group != kExpert || mode == CLI::AppFormatMode::All
                ? make_group(group, false, options)
                : fmt::format("\n{} more for experts: --help-all\n", options.size());
  }
  return text;
}

void group_options(CLI::App* command, const std::vector<std::pair<std::string, std::vector<std::string>>>& groups) {
  command->set_help_all_flag("--help-all", "Print all options, those for experts included (default: off)");
  const auto of_all = [command](const CLI::Option* option) {
    return option == command->get_help_ptr() || option == command->get_help_all_ptr() || option->get_positional() ||
           option->get_group().empty() || option->get_name() == "--quiet" || option->get_name() == "--json";
  };
  for (CLI::Option* option : command->get_options([](const CLI::Option*) { return true; })) {
    if (!of_all(option)) option->group(kExpert);
  }
  for (const auto& [group, names] : groups) {
    for (const std::string& name : names) {
      if (CLI::Option* option = command->get_option_no_throw(name)) option->group(group);
    }
  }
}

}  // namespace grtx::apps
