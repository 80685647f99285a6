// SPDX-License-Identifier: Apache-2.0
// One form of `--help` whatever the version of the parser: manual pages, completion and scripts read it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace grtx::apps {

/// The text behind an option's name: ` UINT:0 to 32=8 ... REQUIRED Needs: --a Excludes: --b`. CLI11 2.1 to 2.3 write
/// defaults so, later versions in brackets.
class HelpFormat final : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override;
  /// Of a command with options for experts: these are the last group, and --help says only how many there are.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

/// Options of a command in this group are shown by --help-all alone.
inline constexpr const char* kExpert = "Expert";

/// Puts a command's options into groups by name, in this order; others, but for those of all commands, are for experts.
void group_options(CLI::App* command, const std::vector<std::pair<std::string, std::vector<std::string>>>& groups);

}  // namespace grtx::apps
