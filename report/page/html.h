// SPDX-License-Identifier: Apache-2.0
// HTML building blocks. Text from files and command lines must pass through escape().
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace grtx::report {

/// Escapes text for HTML content and quoted attribute values.
std::string escape(std::string_view text);
/// Escaped text in which a line may break behind the dots and underscores of a key, and nowhere else inside of it.
std::string breakable(std::string_view text);
/// JSON for a script element: '<' is escaped, so that it cannot end the element. Invalid UTF-8 is replaced.
std::string script_json(const nlohmann::ordered_json& json);

/// Number for display: four significant digits; from 1,000 on whole, with separators; "" if not finite.
std::string number(double value);
/// Three significant digits and a prefix by size: with_unit(0.0316, "J") is "31.6 mJ"; "" if not finite.
std::string with_unit(double value, const std::string& unit);
/// The same for the values of a column: all with the prefix of the largest, so that they compare at a glance; from a
/// thousandth of it on.
std::vector<std::string> in_one_unit(const std::vector<double>& values, const std::string& unit);
/// "1.75x"
std::string times(double value);
/// A share of the whole in percent: "12.3 %", "< 0.1 %", "100 %".
std::string share_text(double share);
/// Table cell for a JSON value: numbers as by number(), strings escaped, null as an empty cell.
std::string cell(const nlohmann::ordered_json& value);

std::string base64(std::string_view bytes);
/// data: URI (base64) of a picture. Throws Error if the file is no PNG, JPEG, GIF or WebP.
std::string picture_uri(const std::string& path);

/// A collapsible <details> element; works without JavaScript.
std::string details(const std::string& summary_html, const std::string& content_html, bool open = false);

/// A table with a caption, in a box that scrolls horizontally; the first cell of a row is its header.
class Table {
 public:
  struct Column {
    std::string title;
    bool numeric = true;
  };
  /// id: of the table element, "" for none. All titles and the caption are plain text.
  Table(std::string caption, std::vector<Column> columns, std::string id = "");

  /// Cells are HTML. attributes: of the row, e.g. ` data-id="3"`.
  void row(const std::vector<std::string>& cells, const std::string& attributes = "");
  /// Before the first row: on a narrow screen each row is a block, its cells below each other, so that none is cut.
  void stacks_when_narrow() { stacks_ = true; }
  std::size_t rows() const { return rows_; }
  std::string html() const;

 private:
  std::string caption_;
  std::vector<Column> columns_;
  std::string id_;
  std::string body_;
  std::size_t rows_ = 0;
  bool stacks_ = false;
};

/// A figure in which the script draws `spec` (Vega-Lite); "" in a build without charts. label: text for screen readers;
/// caption: plain text below; role: data-role, by which the script links charts; group: data-group, common to charts
/// and tables of one input.
std::string chart(const std::string& id, const std::string& label, const std::string& caption,
                  const nlohmann::ordered_json& spec, const std::string& role = "", const std::string& group = "");

/// The place in which the script builds an explorer of points (web/explore.js); "" in a build without charts. data: as
/// explore.js says. table: id of the table of the points, "" for none.
std::string explorer(const std::string& id, const nlohmann::ordered_json& data, const std::string& table = "");

}  // namespace grtx::report
