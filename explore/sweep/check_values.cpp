// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/check_values.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::explore {
namespace {

using Values = std::map<std::string, double>;

/// SAX parser that extracts the numbers stats.NAME.value and cost.NAME; building the whole document would take several
/// times as long.
class ValueReader final : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit ValueReader(Values& values) : values_(values) {}

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool number_integer(number_integer_t value) override { return number(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override { return number(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t&) override { return number(value); }
  bool start_object(std::size_t) override { return enter(); }
  bool start_array(std::size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool end_array() override { return leave(); }
  bool key(string_t& name) override {
    if (depth_ < keys_.size()) keys_[depth_] = std::move(name);
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  bool number(double value) {
    if (depth_ == 3 && keys_[1] == "stats" && keys_[3] == "value") values_[keys_[2]] = value;
    if (depth_ == 2 && keys_[1] == "cost") values_[keys_[2]] = value;
    return true;
  }
  bool enter() {
    if (++depth_ < keys_.size()) keys_[depth_].clear();
    return true;
  }
  bool leave() {
    --depth_;
    return true;
  }

  Values& values_;
  std::array<std::string, 4> keys_;  ///< current key by depth; depth 1 is the top-level object
  std::size_t depth_ = 0;
};

/// Document and values of a point, read in one transaction: a sweep may be writing to the database.
struct Point {
  std::string document;
  Values values;
};

Point read_point(Sqlite& database, const std::string& place, std::int64_t id) {
  const SqliteTransaction together(database, SqliteTransaction::Kind::read);
  Point point;
  SqliteStatement document(database, "SELECT document FROM point WHERE id = ?1");
  if (document.bind(1, id).step()) point.document = document.text(0);
  SqliteStatement value(database, "SELECT name, value FROM value WHERE point_id = ?1");
  value.bind(1, id);
  while (value.step()) {
    if (!value.is_number(1)) throw Error(database.path(), place, "its value " + value.text(0) + " must be a number");
    point.values[value.text(0)] = value.real(1);
  }
  return point;
}

}  // namespace

void check_values(Sqlite& database) {
  std::vector<std::pair<std::int64_t, std::string>> points;
  SqliteStatement done(database, "SELECT id, key FROM point WHERE status = 'done' ORDER BY id");
  while (done.step()) points.emplace_back(done.integer(0), fmt::format("point {} ({})", done.integer(0), done.text(1)));
  for (const auto& [id, place] : points) {
    const Point point = read_point(database, place, id);
    Values truth;
    ValueReader reader(truth);
    if (!nlohmann::json::sax_parse(point.document, &reader)) {
      throw Error(database.path(), place, "its document is damaged: it is no JSON");
    }
    for (const auto& [name, value] : point.values) {
      const auto said = truth.find(name);
      if (said != truth.end() && said->second == value) continue;
      throw Error(database.path(), place,
                  fmt::format("{} is {} in the table `value` and {} in its document: one was changed", name, value,
                              said == truth.end() ? "missing" : fmt::format("{}", said->second)));
    }
    for (const auto& [name, value] : truth) {
      if (point.values.contains(name)) continue;
      throw Error(
          database.path(), place,
          fmt::format("{} is missing in the table `value` and {} in its document: one was changed", name, value));
    }
  }
}

}  // namespace grtx::explore
