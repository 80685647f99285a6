// SPDX-License-Identifier: Apache-2.0
// Names of parameterised tests: what their parameters print (PrintTo), in the characters that GoogleTest allows.
#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <string>

namespace grtx::test {

/// "a.b -> c" gives a_b_c. For parameters that differ in letters or digits.
struct PrintedName {
  template <typename Parameter>
  std::string operator()(const testing::TestParamInfo<Parameter>& info) const {
    std::string name;
    for (const char c : testing::PrintToString(info.param)) {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
        name += c;
      } else if (!name.empty() && name.back() != '_') {
        name += '_';
      }
    }
    while (!name.empty() && name.back() == '_') name.pop_back();
    return name;
  }
};

/// With the parameter's index in front. For parameters that differ in other characters only.
struct NumberedName {
  template <typename Parameter>
  std::string operator()(const testing::TestParamInfo<Parameter>& info) const {
    return std::to_string(info.index) + "_" + PrintedName{}(info);
  }
};

}  // namespace grtx::test
