// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/base/printable.h"
#include "grtx/report/page/assets.h"

namespace grtx::report {

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t at) -> std::uint32_t {
      return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0u;
    };
    const std::uint32_t word = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (unsigned digit = 0; digit < 4; ++digit) {
      text += i + digit <= bytes.size() ? kDigits[word >> (18 - 6 * digit) & 63] : '=';
    }
  }
  return text;
}

std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : utf8(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string script_json(const nlohmann::ordered_json& json) {
  const std::string text = json_text(json);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string number(double value) {
  if (!std::isfinite(value)) return "";
  if (std::fabs(value) >= 1e15) return fmt::format("{:.4g}", value);
  if (value != std::floor(value) && std::fabs(value) < 1000.0) return fmt::format("{:.4g}", value);
  std::string digits = fmt::format("{:.0f}", std::fabs(value));
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return (value < 0.0 ? "-" : "") + digits;
}

std::string with_unit(double value, const std::string& unit) { return in_one_unit({value}, unit).front(); }

std::vector<std::string> in_one_unit(const std::vector<double>& values, const std::string& unit) {
  constexpr std::array<const char*, 9> kPrefixes = {"p", "n", "µ", "m", "", "k", "M", "G", "T"};
  constexpr std::size_t kOne = 4;  // index of the empty prefix
  double largest = 0.0;
  for (const double value : values) largest = std::isfinite(value) ? std::max(largest, std::fabs(value)) : largest;
  std::size_t prefix = unit == "B" ? kOne : 0;
  double scale = unit == "B" ? 1.0 : 1e12;
  for (; largest * scale >= 999.5 && prefix + 1 < kPrefixes.size(); ++prefix) scale *= 1e-3;
  std::vector<std::string> texts;
  for (const double value : values) {
    const double scaled = std::fabs(value) * scale;
    const bool whole = scaled >= 99.95 || (unit == "B" && prefix == kOne);
    const int decimals = whole ? 0 : scaled >= 9.995 ? 1 : scaled >= 0.9995 || largest == std::fabs(value) ? 2 : 3;
    texts.push_back(!std::isfinite(value) ? ""
                    : value == 0.0        ? "0 " + unit
                    : scaled < 0.0005     ? fmt::format("under 0.001 {}{}", kPrefixes[prefix], unit)
                                          : fmt::format("{}{:.{}f} {}{}", value < 0.0 ? "-" : "", scaled, decimals,
                                                        kPrefixes[prefix], unit));
  }
  return texts;
}

std::string times(double value) { return std::isfinite(value) ? fmt::format("{:.2f}×", value) : ""; }

std::string share_text(double share) {
  if (!std::isfinite(share)) return "";
  if (share > 0.0 && share < 5e-4) return "< 0.1 %";
  return share == 0.0 || share == 1.0 ? fmt::format("{:.0f} %", 100.0 * share) : fmt::format("{:.1f} %", 100.0 * share);
}

std::string cell(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "";
  if (value.is_number()) return number(value.get<double>());
  if (value.is_string()) return escape(value.get<std::string>());
  return escape(json_text(value));
}

std::string breakable(std::string_view text) {
  std::string html = escape(text);
  for (std::size_t at = 1; at + 1 < html.size(); ++at) {
    const auto letter = [&](std::size_t i) { return std::isalpha(static_cast<unsigned char>(html[i])) != 0; };
    if ((html[at] == '.' || html[at] == '_') && letter(at - 1) && letter(at + 1)) html.insert(++at, "<wbr>"), at += 4;
  }
  return html;
}

std::string picture_uri(const std::string& path) {
  const std::string bytes = read_file(path);
  const std::string_view view = bytes;
  const char* type = view.starts_with("\x89PNG\r\n\x1a\n")                            ? "png"
                     : view.starts_with("\xff\xd8\xff")                               ? "jpeg"
                     : view.starts_with("GIF8")                                       ? "gif"
                     : view.starts_with("RIFF") && view.substr(8).starts_with("WEBP") ? "webp"
                                                                                      : nullptr;
  if (type == nullptr) throw Error(path, "byte 0", "must be a PNG, JPEG, GIF or WebP picture");
  return fmt::format("data:image/{};base64,{}", type, base64(bytes));
}

std::string details(const std::string& summary_html, const std::string& content_html, bool open) {
  return fmt::format("<details{}><summary>{}</summary>\n{}</details>\n", open ? " open" : "", summary_html,
                     content_html);
}

Table::Table(std::string caption, std::vector<Column> columns, std::string id)
    : caption_(std::move(caption)), columns_(std::move(columns)), id_(std::move(id)) {}

void Table::row(const std::vector<std::string>& cells, const std::string& attributes) {
  body_ += "<tr" + attributes + ">";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::string own = i < columns_.size() && columns_[i].numeric ? " class=\"n\"" : "";
    if (stacks_ && i > 0 && i < columns_.size()) own += " data-what=\"" + escape(columns_[i].title) + "\"";
    body_ += i == 0 ? fmt::format("<th scope=\"row\"{}>{}</th>", own, cells[i])
                    : fmt::format("<td{}>{}</td>", own, cells[i]);
  }
  body_ += "</tr>\n";
  ++rows_;
}

std::string Table::html() const {
  std::string head;
  for (const Column& column : columns_) {
    head += fmt::format("<th scope=\"col\"{}>{}</th>", column.numeric ? " class=\"n\"" : "", breakable(column.title));
  }
  return fmt::format(
      "<div class=\"scroll\" role=\"region\" tabindex=\"0\" "
      "aria-label=\"{}\"><table{}>\n<caption><span>{}</span></caption>\n"
      "<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table></div>\n",
      escape(caption_), (id_.empty() ? "" : fmt::format(" id=\"{}\"", id_)) + (stacks_ ? " class=\"stacks\"" : ""),
      escape(caption_), head, body_);
}

std::string chart(const std::string& id, const std::string& label, const std::string& caption,
                  const nlohmann::ordered_json& spec, const std::string& role, const std::string& group) {
  if (chart_library().empty()) return "";
  return fmt::format(
      "<figure class=\"chart\" id=\"{0}\" data-role=\"{1}\" data-group=\"{2}\">\n"
      "<div class=\"drawing\" role=\"group\" aria-label=\"{3}\"></div>\n"
      "<noscript><p>This chart needs JavaScript; the tables of this page hold its numbers.</p></noscript>\n"
      "<figcaption>{4}</figcaption>\n<script type=\"application/json\" class=\"spec\">{5}</script>\n</figure>\n",
      id, role, group, escape(label), escape(caption), script_json(spec));
}

std::string explorer(const std::string& id, const nlohmann::ordered_json& data, const std::string& table) {
  if (chart_library().empty()) return "";
  return fmt::format(
      "<div class=\"explorer\" id=\"{0}_explorer\" data-group=\"{0}\" data-table=\"{1}\">\n"
      "<noscript><p>The charts need JavaScript; the tables of this page hold their numbers.</p></noscript>\n"
      "<script type=\"application/json\" class=\"points\">{2}</script>\n</div>\n",
      id, table, script_json(data));
}

}  // namespace grtx::report
