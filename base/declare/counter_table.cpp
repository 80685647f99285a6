// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/declare/counter_table.h"

namespace grtx::declare {

std::string with_name(std::string_view text, std::string_view name) {
  std::string result(text);
  if (const std::size_t at = result.find("{}"); at != std::string::npos) result.replace(at, 2, name);
  return result;
}

}  // namespace grtx::declare
