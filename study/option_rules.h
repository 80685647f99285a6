// What the text of an option must be, beyond its type: said once, for the command line, machines, plans and headers.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace grtx::sim {

template <typename Number>
struct InRange {
  Number low, high;
};
template <typename Number>
InRange(Number, Number) -> InRange<Number>;
struct OneOf {
  std::vector<std::string> names;
};
struct AnyOf {
  std::vector<unsigned> numbers;
};
/// So many numbers, separated by commas.
struct ListOf {
  std::size_t numbers;
};

/// The option of a key: --pop-test of pop_test.
std::string flag_of(std::string key);
/// The key of an option's name: pop_test of pop-test.
std::string key_of(std::string name);

}  // namespace grtx::sim
