// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames{{{"char", PlyType::i8},
                                                                           {"int8", PlyType::i8},
                                                                           {"uchar", PlyType::u8},
                                                                           {"uint8", PlyType::u8},
                                                                           {"short", PlyType::i16},
                                                                           {"int16", PlyType::i16},
                                                                           {"ushort", PlyType::u16},
                                                                           {"uint16", PlyType::u16},
                                                                           {"int", PlyType::i32},
                                                                           {"int32", PlyType::i32},
                                                                           {"uint", PlyType::u32},
                                                                           {"uint32", PlyType::u32},
                                                                           {"float", PlyType::f32},
                                                                           {"float32", PlyType::f32},
                                                                           {"double", PlyType::f64},
                                                                           {"float64", PlyType::f64}}};

// Words as they appear in a message: short, printable.
std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += (c >= 0x20 && c < 0x7f) ? c : '?';
  return out + (text.size() > 40 ? "...\"" : "\"");
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while (true) {
    at = line.find_first_not_of(" \t", at);
    if (at == std::string_view::npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
}

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  PlyHeader parse() {
    if (next_line() != "ply") fail("must be \"ply\"");
    bool format_known = false;
    while (true) {
      const std::string_view line = next_line();
      const std::vector<std::string_view> words = words_of(line);
      if (words.empty()) continue;
      const std::string_view keyword = words[0];
      if (keyword == "comment" || keyword == "obj_info") {
        header_.comments.emplace_back(line.substr(std::min(line.size(), line.find(keyword) + keyword.size() + 1)));
      } else if (keyword == "format") {
        if (format_known) fail("is a second format line");
        read_format(words);
        format_known = true;
      } else if (keyword == "end_header") {
        break;
      } else if (!format_known) {
        fail("must be the format line, not " + in_quotes(line));
      } else if (keyword == "element") {
        read_element(words);
      } else if (keyword == "property") {
        read_property(words);
      } else {
        fail("has an unknown keyword: " + in_quotes(keyword));
      }
    }
    if (!format_known) fail("ends the header without a format line");
    header_.lines = line_;
    header_.data_begin = at_;
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& rule) const { throw Error(file_, "line " + std::to_string(line_), rule); }

  std::string_view next_line() {
    ++line_;
    const std::size_t end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) fail("the header must end in a line \"end_header\"; the file ends first");
    std::string_view line = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }

  PlyType type_of(std::string_view word) const {
    for (const auto& [name, type] : kTypeNames) {
      if (name == word) return type;
    }
    fail("has an unknown type: " + in_quotes(word));
  }

  void read_format(const std::vector<std::string_view>& words) {
    if (words.size() != 3 || words[2] != "1.0") fail("must be \"format NAME 1.0\"");
    if (words[1] == "ascii") {
      header_.format = PlyFormat::ascii;
    } else if (words[1] == "binary_little_endian") {
      header_.format = PlyFormat::binary_little_endian;
    } else if (words[1] == "binary_big_endian") {
      header_.format = PlyFormat::binary_big_endian;
    } else {
      fail("has an unknown format: " + in_quotes(words[1]));
    }
  }

  void read_element(const std::vector<std::string_view>& words) {
    if (words.size() != 3) fail("must be \"element NAME COUNT\"");
    PlyElement element;
    element.name = words[1];
    const auto [end, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.rows);
    if (error != std::errc() || end != words[2].data() + words[2].size()) {
      fail("has a count that is no whole number from 0 to 2^64 - 1: " + in_quotes(words[2]));
    }
    if (header_.find(element.name)) fail("names the element " + in_quotes(element.name) + " a second time");
    header_.elements.push_back(std::move(element));
  }

  void read_property(const std::vector<std::string_view>& words) {
    if (header_.elements.empty()) fail("is a property before the first element");
    PlyProperty property;
    if (words.size() == 3) {
      property.type = type_of(words[1]);
    } else if (words.size() == 5 && words[1] == "list") {
      property.list_count = type_of(words[2]);
      property.type = type_of(words[3]);
      if (!is_integer(*property.list_count)) fail("has a list count that is not of an integer type");
    } else {
      fail("must be \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"");
    }
    property.name = words.back();
    PlyElement& element = header_.elements.back();
    if (element.find(property.name)) fail("names the property " + in_quotes(property.name) + " a second time");
    element.properties.push_back(std::move(property));
  }

  std::string_view bytes_;
  const std::string& file_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  PlyHeader header_;
};

}  // namespace

std::size_t size_in_bytes(PlyType type) {
  return with_type(type, []<typename T>(T) { return sizeof(T); });
}

bool is_integer(PlyType type) { return type != PlyType::f32 && type != PlyType::f64; }

bool PlyElement::has_list() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& p) { return p.list_count.has_value(); });
}

std::size_t PlyElement::row_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& p : properties) bytes += size_in_bytes(p.type);
  return bytes;
}

std::optional<std::size_t> PlyElement::find(std::string_view property) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> PlyHeader::find(std::string_view element) const {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (elements[i].name == element) return i;
  }
  return std::nullopt;
}

PlyHeader parse_ply_header(std::string_view bytes, const std::string& file) {
  return HeaderParser(bytes, file).parse();
}

}  // namespace grtx::frontend
