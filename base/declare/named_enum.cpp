// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/declare/named_enum.h"

#include <fmt/format.h>

namespace grtx {

std::string joined_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string unknown_name(std::string_view name, const std::vector<std::string>& known) {
  return fmt::format("must be one of {}, not '{}'; the nearest is '{}'", joined_names(known), name,
                     nearest_name(name, known));
}

}  // namespace grtx
