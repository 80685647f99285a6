// SPDX-License-Identifier: Apache-2.0
// Fields of JSON input, with errors that name the key and what it must be.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/frontend/camera/camera.h"

namespace grtx::frontend {

/// One object of a JSON file and its place ("camera 3"), for messages.
struct JsonObject {
  const nlohmann::json& json;
  const std::string& file;
  std::string place;

  bool has(const char* key) const { return json.contains(key); }
  /// Both throw Error when the key is missing or of another type.
  double number(const char* key) const;
  std::string text(const char* key) const;
  /// A whole number (3.0 counts) from 0 to 65536.
  unsigned pixels(const char* key) const;
  /// Reads at least `rows` arrays of at least `columns` numbers; returns `rows` x `columns` of them in row order.
  std::vector<double> matrix(const char* key, std::size_t rows, std::size_t columns) const;
  std::vector<double> numbers(const char* key, std::size_t count) const;
  [[noreturn]] void fail(const std::string& rule) const;
};

}  // namespace grtx::frontend
