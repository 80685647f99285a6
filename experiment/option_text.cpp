// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/option_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "grtx/base/nearest_name.h"

namespace grtx::experiment {

std::string flag_of(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

std::string key_of(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::string out_of_range(double low, double high, const std::string& text) {
  return fmt::format("must be {:.10g} to {:.10g}, not {}", low, high, text);
}

std::string not_converted(const std::string& flag, const std::string& text) {
  return fmt::format("Could not convert: {} = {}", flag, text);
}

std::string breach(const OneOf& rule, const std::string& text) {
  if (std::find(rule.names.begin(), rule.names.end(), text) != rule.names.end()) return {};
  if (!rule.gone.empty() && text == rule.gone) return fmt::format("'{}' is gone: {}", text, rule.instead);
  return fmt::format("unknown value '{}', the nearest is '{}' (known: {})", text, nearest_name(text, rule.names),
                     joined_names(rule.names));
}

std::string breach(const AnyOf& rule, const std::string& text) {
  unsigned number = 0;
  const bool known = number_from(text, number) && std::ranges::find(rule.numbers, number) != rule.numbers.end();
  return known ? std::string() : fmt::format("{} not in {{{}}}", text, fmt::join(rule.numbers, ","));
}

std::vector<std::string> pieces_of(const std::string& text) {
  std::vector<std::string> pieces;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    pieces.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

std::string take(const std::string& flag, const std::string& text, std::vector<double>& value, const ListOf& rule) {
  const std::vector<std::string> pieces = pieces_of(text);
  if (pieces.size() < rule.numbers)
    return fmt::format("{}: At least {} required but received {}", flag, rule.numbers, pieces.size());
  std::vector<double> taken;
  for (const std::string& piece : pieces) {
    if (!number_from(piece, taken.emplace_back())) {
      return not_converted(flag, text);
    }
  }
  if (pieces.size() > rule.numbers) {
    return fmt::format("{}: At Most {} required but received {}", flag, rule.numbers, pieces.size());
  }
  value = std::move(taken);
  return {};
}

}  // namespace grtx::experiment
