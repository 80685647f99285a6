// SPDX-License-Identifier: Apache-2.0
// The exception type for bad input: names the file, the place in it and the broken rule. Thrown at the boundary,
// printed as one line by main, which then exits with code 2.
#pragma once

#include <stdexcept>
#include <string>

namespace grtx {

class Error : public std::runtime_error {
 public:
  /// file: path or option name. place: line, byte offset, key ... ("" for the whole file). rule: what must hold.
  Error(std::string file, std::string place, std::string rule);

  const std::string& file() const { return file_; }
  const std::string& place() const { return place_; }
  const std::string& rule() const { return rule_; }

 private:
  std::string file_;
  std::string place_;
  std::string rule_;
};

}  // namespace grtx
