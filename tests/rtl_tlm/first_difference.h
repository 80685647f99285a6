// SPDX-License-Identifier: Apache-2.0
// Where two documents differ, for the message of a test.
#pragma once

#include <sstream>
#include <string>

namespace grtx::sim::test {

/// The first line in which two texts differ.
inline std::string first_difference(const std::string& a, const std::string& b) {
  std::istringstream left(a), right(b);
  std::string of_left, of_right, name;
  while (std::getline(left, of_left) && std::getline(right, of_right)) {
    if (of_left.find("{") != std::string::npos) name = of_left;
    if (of_left != of_right) return name + ": " + of_left + " / " + of_right;
  }
  return a == b ? "" : "one is longer";
}

}  // namespace grtx::sim::test
