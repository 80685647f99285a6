// SPDX-License-Identifier: Apache-2.0
// Command-line building blocks shared by several commands.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "grtx/apps/grtx/command_files.h"
#include "grtx/apps/grtx/commands.h"
#include "grtx/base/declare/named_enum.h"
#include "grtx/base/wrapped.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/option_rules.h"
#include "grtx/experiment/view_choice.h"

namespace grtx::apps {

/// Adds a subcommand with --quiet and --help; help shows defaults. `body` runs after parsing and returns the exit code
/// (0 or 1); it throws grtx::Error for bad input.
CLI::App* make_command(CLI::App& app, CommonOptions& common, const std::string& name, const std::string& description,
                       std::function<int()> body);

/// Prints a sentence, wrapped to the terminal width.
template <typename... Values>
void say(fmt::format_string<Values...> form, Values&&... values) {
  fmt::print("{}\n", wrapped(fmt::format(form, std::forward<Values>(values)...)));
}

/// Accepts only `names`; the message for any other value names the nearest one.
CLI::Validator one_of(std::vector<std::string> names);
CLI::Validator one_of(experiment::OneOf rule);

/// Accepts numbers from low to high; NaN is refused elsewhere, for all options. Used instead of CLI::Range, whose
/// message differs between versions of CLI11.
template <typename Number>
CLI::Validator in_range(Number low, Number high) {
  const std::string range = fmt::format("{:.10g} to {:.10g}", static_cast<double>(low), static_cast<double>(high));
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        Number value{};
        if (CLI::detail::lexical_cast(text, value) && !(value < low || value > high)) return {};
        return fmt::format("must be {}, not {}", range, text);
      },
      range);
}

/// Accepts numbers above 0.
CLI::Validator above_zero();

/// Adds an option whose value is a name of an enumeration. allowed: if given, accepts only values for which it returns
/// true.
template <NamedEnum Enum>
CLI::Option* add_choice(CLI::App* command, const std::string& flag, Enum& value, const std::string& description,
                        bool (*allowed)(Enum) = nullptr) {
  std::vector<std::string> names;
  for (const std::string& name : names_of<Enum>()) {
    if (allowed == nullptr || allowed(*from_name<Enum>(name))) names.push_back(name);
  }
  const auto assign = [&value](const std::string& name) { value = *from_name<Enum>(name); };
  return command->add_option_function<std::string>(flag, assign, description)
      ->default_str(std::string(name_of(value)))
      ->check(one_of(std::move(names)));
}

/// --cameras (required), --view, --width, --height, --fov-scale.
void add_view_options(CLI::App* command, experiment::ViewOptions& view);
/// --views.
void add_views_option(CLI::App* command, experiment::ViewOptions& view);
/// --machine, with the machines of the project as a hint.
CLI::Option* add_machine_option(CLI::App* command, std::string& machine);
/// The same for several, with commas.
CLI::Option* add_machine_option(CLI::App* command, std::vector<std::string>& machines);
/// experiment::choose_machine(); throws Error if the command would overwrite a file that was read.
experiment::ChosenMachine choose_machine(const experiment::MachineChoice& choice, const CommonOptions& common,
                                         bool check = true);
/// --flatten.
void add_flatten_option(CLI::App* command, bool& flatten);
/// --heatmap, which may be repeated.
void add_heatmap_option(CLI::App* command, std::vector<std::string>& texts, const std::vector<std::string>& names);

}  // namespace grtx::apps
