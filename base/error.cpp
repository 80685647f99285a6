// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/error.h"

#include "grtx/base/printable.h"

namespace grtx {
namespace {

constexpr std::size_t kMostQuoted = 200;  ///< most bytes of a path, place or rule in a message

/// Shortens input of any length to its beginning and end.
std::string shortened(const std::string& text) {
  if (text.size() <= kMostQuoted) return text;
  return text.substr(0, kMostQuoted / 2) + " ... " + text.substr(text.size() - kMostQuoted / 2);
}

std::string one_line(const std::string& file, const std::string& place, const std::string& rule) {
  std::string text = shortened(file);
  if (!place.empty()) text += (text.empty() ? "" : ": ") + shortened(place);
  if (!rule.empty()) text += (text.empty() ? "" : ": ") + shortened(rule);
  return printable(text);
}

}  // namespace

Error::Error(std::string file, std::string place, std::string rule)
    : std::runtime_error(one_line(file, place, rule)),
      file_(std::move(file)),
      place_(std::move(place)),
      rule_(std::move(rule)) {}

}  // namespace grtx
