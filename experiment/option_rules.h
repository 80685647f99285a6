// SPDX-License-Identifier: Apache-2.0
// Rules for the values of options beyond their type, shared by the command line, machines, plans and trace headers.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace grtx::experiment {

template <typename Number>
struct InRange {
  Number low, high;
};
template <typename Number>
InRange(Number, Number) -> InRange<Number>;
struct OneOf {
  std::vector<std::string> names;
  std::string gone = {};     ///< a name that was there before
  std::string instead = {};  ///< and what to use in its place
};
struct AnyOf {
  std::vector<unsigned> numbers;
};
/// Exactly `numbers` numbers, separated by commas.
struct ListOf {
  std::size_t numbers;
};

/// Command-line flag of a key: pop_test gives --pop-test.
std::string flag_of(std::string key);
/// Key of an option's name: pop-test gives pop_test.
std::string key_of(std::string name);

}  // namespace grtx::experiment
