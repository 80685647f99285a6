// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/wires.h"

#include <fnmatch.h>

#include <sstream>

namespace grtx::sim {
namespace {

bool matches(const std::string& pattern, const std::string& name, const std::string& root) {
  return ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0 ||
         (name.starts_with(root) && ::fnmatch(pattern.c_str(), name.c_str() + root.size(), 0) == 0);
}

}  // namespace

Wires::Wires(VcdWriter& writer, const std::string& scope, WaveLevel level, const std::string& gpu)
    : writer_(writer), level_(level), root_(gpu + ".") {
  std::istringstream list(scope);
  for (std::string pattern; std::getline(list, pattern, ',');) patterns_.push_back(pattern);
}

Wire Wires::add(const std::string& name, unsigned width, WaveLevel level, const Enumeration* enumeration) {
  if (level > level_) return {};
  const auto selects = [&](const std::string& pattern) {
    for (std::size_t end = name.size(); end != std::string::npos; end = name.rfind('.', end - 1)) {
      if (matches(pattern, name.substr(0, end), root_)) return true;
    }
    return false;
  };
  if (std::none_of(patterns_.begin(), patterns_.end(), selects)) return {};
  ++selected_;
  return {&writer_, writer_.declare(name, width, enumeration)};
}

}  // namespace grtx::sim
