// Pieces of HTML. Whatever comes from a file or a command line goes through escape().
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace grtx::sim {

/// For text and for attribute values in double quotes.
std::string escape(std::string_view text);
/// JSON for the inside of a script element: no '<' is left that could end it. Bytes that are no UTF-8 are replaced.
std::string script_json(const nlohmann::ordered_json& json);

/// For people: four significant digits, whole from 1,000 on and then with separators; "" when not finite.
std::string number(double value);
/// "1.75x"
std::string times(double value);
/// The same as `number`, of whatever the JSON holds; strings escaped, null as an empty cell.
std::string cell(const nlohmann::ordered_json& value);

std::string base64(std::string_view bytes);
/// data:...;base64 of a picture. Throws Error when the file is no PNG, JPEG, GIF or WebP.
std::string picture_uri(const std::string& path);

/// An element that can be closed and opened without a script.
std::string details(const std::string& summary_html, const std::string& content_html, bool open = false);

/// A table with a caption in a box of its own that scrolls sideways; the first cell of a row heads it.
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
  std::size_t rows() const { return rows_; }
  std::string html() const;

 private:
  std::string caption_;
  std::vector<Column> columns_;
  std::string id_;
  std::string body_;
  std::size_t rows_ = 0;
};

/// A chart: the script draws `spec` (Vega-Lite) in it. Without charts in this build, an empty text.
/// label: what a screen reader says; caption: plain text below; role: data-role of the figure, what the script may
/// link it with; group: data-group, charts and tables of one input.
std::string chart(const std::string& id, const std::string& label, const std::string& caption,
                  const nlohmann::ordered_json& spec, const std::string& role = "", const std::string& group = "");

}  // namespace grtx::sim
