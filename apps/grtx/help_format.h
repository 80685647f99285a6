// SPDX-License-Identifier: Apache-2.0
// One form of `--help` whatever the version of the parser: manual pages, completion and scripts read it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace grtx::apps {

/// The text behind an option's name: ` UINT:0 to 32=8 ... REQUIRED Needs: --a Excludes: --b`. CLI11 2.1 to 2.3 write
/// defaults so, later versions in brackets.
class HelpFormat final : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override;
};

}  // namespace grtx::apps
