// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/camera/json_fields.h"

#include <cmath>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

const nlohmann::json& field(const JsonObject& object, const char* key) {
  if (!object.json.is_object()) object.fail("must be an object");
  const auto found = object.json.find(key);
  if (found == object.json.end()) object.fail("needs the key \"" + std::string(key) + "\"");
  return *found;
}

bool are_numbers(const nlohmann::json& json, std::size_t count) {
  if (!json.is_array() || json.size() < count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (!json[i].is_number()) return false;
  }
  return true;
}

}  // namespace

void JsonObject::fail(const std::string& rule) const { throw Error(file, place, rule); }

double JsonObject::number(const char* key) const {
  const nlohmann::json& value = field(*this, key);
  if (!value.is_number()) fail("\"" + std::string(key) + "\" must be a number");
  return value.get<double>();
}

std::string JsonObject::text(const char* key) const {
  const nlohmann::json& value = field(*this, key);
  if (!value.is_string()) fail("\"" + std::string(key) + "\" must be a string");
  return value.get<std::string>();
}

unsigned JsonObject::pixels(const char* key) const {
  const double value = number(key);
  if (!(value >= 0.0 && value <= 65536.0) || value != std::floor(value)) {
    fail("\"" + std::string(key) + "\" must be a whole number of pixels, 1 to 65536");
  }
  return static_cast<unsigned>(value);
}

std::vector<double> JsonObject::numbers(const char* key, std::size_t count) const {
  const nlohmann::json& value = field(*this, key);
  if (!are_numbers(value, count) || value.size() != count) {
    fail("\"" + std::string(key) + "\" must be an array of " + std::to_string(count) + " numbers");
  }
  return value.get<std::vector<double>>();
}

std::vector<double> JsonObject::matrix(const char* key, std::size_t rows, std::size_t columns) const {
  const nlohmann::json& value = field(*this, key);
  bool fits = value.is_array() && value.size() >= rows;
  for (std::size_t row = 0; fits && row < rows; ++row) fits = are_numbers(value[row], columns);
  if (!fits) {
    fail("\"" + std::string(key) + "\" must be " + std::to_string(rows) + " arrays of " + std::to_string(columns) +
         " numbers");
  }
  std::vector<double> result;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) result.push_back(value[row][column].get<double>());
  }
  return result;
}

}  // namespace grtx::frontend
