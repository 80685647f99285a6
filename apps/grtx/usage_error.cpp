// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/usage_error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "grtx/apps/grtx/command_files.h"
#include "grtx/base/nearest_name.h"

namespace grtx::apps {
namespace {

constexpr const char* kWhole = "a whole number from 0 on";

/// The option that the parser's message is about, which it names first: a value may look like an option, too. nullptr
/// if it names none.
const CLI::Option* option_in(const CLI::App& command, const std::string& message) {
  const CLI::Option* found = nullptr;
  std::size_t first = message.size();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    const std::size_t at = name.empty() ? std::string::npos : message.find(name);
    if (at == std::string::npos) continue;
    const bool longer = at == first && found != nullptr && name.size() > found->get_name().size();
    if (at < first || longer) {
      found = option;
      first = at;
    }
  }
  return found;
}

/// The rule for a value of the option.
std::string what_it_takes(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  if (type.starts_with("UINT")) return kWhole;
  if (type.starts_with("INT")) return "a whole number";
  if (type.starts_with("FLOAT")) return "a number";
  return type;
}

/// The digits of a whole number that is written otherwise, as 1e6; "" for anything else.
std::string digits(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool whole = end != text.c_str() && *end == '\0' && value >= 0.0 && value < 1e15 && value == std::floor(value);
  return whole ? fmt::format("{:.0f}", value) : "";
}

/// The rule that values of an option break; "" if the parser's own words serve.
std::string broken_rule(const CLI::Option& option, const std::string& kind) {
  const std::vector<std::string>& given = option.results();
  const std::string type = what_it_takes(option);
  if (kind == "ConversionError") {
    const std::string text = fmt::format("{}", fmt::join(given, ","));
    if (option.get_items_expected_max() == 0) return fmt::format("takes no value, so not {}", text);
    const std::string meant = option.get_type_name().starts_with("FLOAT") ? "" : digits(text);
    return fmt::format("must be {}{}, not {}", type, meant.empty() ? "" : ", as " + meant, text);
  }
  if (kind != "ArgumentMismatch") return "";
  if (given.empty()) return fmt::format("needs a value: {}", type);
  if (option.get_items_expected_max() == 1) return fmt::format("is given {} times: give it once", given.size());
  return fmt::format("must be {}: {} values, not {}", type, option.get_items_expected_min(), given.size());
}

/// The option of the command that is called so, as --seed or -o; nullptr if there is none.
const CLI::Option* option_called(const CLI::App& command, const std::string& flag) {
  return flag.size() > 1 && flag[0] == '-' ? command.get_option_no_throw(flag) : nullptr;
}

}  // namespace

void refuse_missing_values(const CLI::App& app, const std::vector<std::string>& arguments) {
  const auto first =
      std::find_if(arguments.begin(), arguments.end(), [](const auto& a) { return !a.starts_with("-"); });
  if (first == arguments.end()) return;
  const auto named = app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == *first; });
  if (named.empty()) return;
  const CLI::App* const command = named.front();
  for (auto at = first + 1; at != arguments.end() && *at != "--"; ++at) {
    if (at->empty()) throw Error(command->get_name(), "", "an argument is empty");
    const std::size_t equals = at->starts_with("--") ? at->find('=') : std::string::npos;
    const CLI::Option* const option = option_called(*command, at->substr(0, equals));
    if (option == nullptr || option->get_items_expected_min() == 0) continue;
    const std::string needs = fmt::format("needs a value: {}", what_it_takes(*option));
    if (equals == at->size() - 1) throw Error(command->get_name(), option->get_name(), needs);
    if (equals != std::string::npos || at + 1 == arguments.end()) continue;
    const std::string& value = *++at;
    if (value.empty() && option->get_type_name() == kOutputFile) continue;  // CommandFiles says so
    if (value.empty() && option->get_type_name() == kMachineType) continue;
    if (value.empty()) throw Error(command->get_name(), option->get_name(), needs);
    if (value.starts_with("--") || option_called(*command, value) != nullptr) {
      throw Error(command->get_name(), option->get_name(), fmt::format("{}, not {}", needs, value));
    }
  }
}

Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  if (const auto chosen = app.get_subcommands(); !chosen.empty()) command = chosen.front();
  const std::string name = command == &app ? "" : command->get_name();
  std::vector<std::string> unknown = command->remaining();
  if (unknown.empty()) unknown = app.remaining();
  for (const std::string& word : unknown) {
    std::vector<std::string> known;
    if (word.starts_with("-")) {
      for (const CLI::Option* option : command->get_options()) {
        if (option->get_group().empty()) continue;  // not in --help, so not to be recommended
        for (const std::string& flag : option->get_lnames()) known.push_back("--" + flag);
        for (const std::string& flag : option->get_snames()) known.push_back("-" + flag);
      }
      const std::string flag = word.substr(0, word.find('='));
      if (std::find(known.begin(), known.end(), flag) != known.end()) {
        return {name, flag, "options come after the command: grtx " + name + " ... " + word};
      }
      return {name, "unknown option " + flag, "the nearest is " + grtx::nearest_name(flag, known)};
    }
    if (command == &app && word == "help")
      return {"", "unknown command help", "must be grtx --help or grtx COMMAND --help"};
    if (command == &app) {
      for (const CLI::App* sub : app.get_subcommands(nullptr)) known.push_back(sub->get_name());
      return {name, "unknown command " + word,
              "the nearest is " + grtx::nearest_name(word, known) + "; grtx --help lists all"};
    }
    return {name, "unexpected argument " + word, "see grtx " + name + " --help"};
  }
  const CLI::Option* const option = option_in(*command, error.what());
  const std::string rule = option == nullptr ? "" : broken_rule(*option, error.get_name());
  if (!rule.empty()) return {name, option->get_name(), rule};
  return {name, "", error.what()};
}

void refuse_odd_numbers(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string type = option->get_type_name();
    for (const std::string& text : option->results()) {
      char* end = nullptr;
      if (type.find("FLOAT") != std::string::npos && std::isnan(std::strtod(text.c_str(), &end))) {
        throw Error(command.get_name(), option->get_name(), fmt::format("must be a number, not {}", text));
      }
      if (type.starts_with("UINT") && text.starts_with("-")) {
        throw Error(command.get_name(), option->get_name(), fmt::format("must be {}, not {}", kWhole, text));
      }
    }
  }
}

}  // namespace grtx::apps
