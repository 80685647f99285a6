// SPDX-License-Identifier: Apache-2.0
// The schema is that of OpenUSD 26.03, pxr/usd/usdVol/schema.usda; 3DGRUT writes it (threedgrut/export/usd/writers/
// lightfield.py).
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/frontend/scene/raw_encoding.h"
#include "grtx/frontend/scene/readers.h"

namespace grtx::frontend {
namespace {

constexpr std::string_view kUsdMagic = "#usda ", kUsdBlanks = " \t\r;", kUsdSpace = " \t\r;\n";
constexpr std::string_view kUsdSplats = "ParticleField3DGaussianSplat";
constexpr unsigned kUsdDegree = 3;
constexpr int kUsdDepth = 64;

bool is_word_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':' ||
         c == '.' || c == '[' || c == ']';
}

/// The text, read token by token. All that is not asked for is skipped: strings, lists and dictionaries as a whole.
class UsdText {
 public:
  UsdText(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  [[noreturn]] void fail(const std::string& rule) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw Error(file_, "line " + std::to_string(line), rule);
  }
  /// The next character that is neither blank nor comment, '\0' at the end.
  char next(std::string_view blanks = kUsdSpace) {
    while (true) {
      at_ = std::min(text_.find_first_not_of(blanks, at_), text_.size());
      if (at_ == text_.size() || text_[at_] != '#') break;
      at_ = std::min(text_.find('\n', at_), text_.size());
    }
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  /// Takes the next character if it is c.
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!take(c)) fail(std::string("needs '") + c + "'");
  }
  /// Letters, digits and "_:.[]" that come next; may be "".
  std::string_view word() {
    next();
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_word_character(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  /// The words of this line up to '=', a bracket or its end.
  std::vector<std::string_view> words_of_line() {
    std::vector<std::string_view> words;
    while (is_word_character(next(kUsdBlanks)) && text_[at_] != '[') words.push_back(word());
    return words;
  }
  double number() {
    next();
    double value = 0.0;
    const char* const begin = text_.data() + at_;
    const auto [end, failed] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (failed != std::errc{}) fail("needs a number");
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }
  /// A list of tuples of `width` numbers, or of numbers; appended one after the other.
  template <typename Number>
  void list(std::size_t width, std::vector<Number>& values) {
    for (expect('['); !take(']');) {
      if (width > 1) expect('(');
      for (std::size_t i = 0; i < width; ++i) {
        if (i > 0) expect(',');
        values.push_back(static_cast<Number>(number()));
      }
      if (width > 1) expect(')');
      if (!take(',') && next() != ']') fail("needs ',' or ']'");
    }
  }
  void skip_value() {
    switch (next()) {
      case '(':
      case '[':
      case '{':
        return skip_brackets();
      case '"':
      case '\'':
      case '@':
      case '<':
        return skip_quoted();
      default:
        const std::size_t begin = at_;
        while (at_ < text_.size() && (is_word_character(text_[at_]) || text_[at_] == '-' || text_[at_] == '+')) ++at_;
        if (at_ == begin) fail("needs a value");
    }
  }

 private:
  /// A string, or the name of a file or prim.
  void skip_quoted() {
    const char quote = text_[at_] == '<' ? '>' : text_[at_];
    std::string end(1, quote);
    if (quote != '>' && text_.substr(at_, 3) == std::string(3, quote)) end = std::string(3, quote);
    at_ += end.size();
    while (at_ < text_.size() && !text_.substr(at_).starts_with(end)) at_ += text_[at_] == '\\' && quote != '@' ? 2 : 1;
    at_ += end.size();
    if (at_ > text_.size()) {
      at_ = text_.size();
      fail("ends inside a string");
    }
  }
  void skip_brackets() {
    std::string open;  // brackets that are to be closed
    do {
      const char c = next();
      if (c == '\0') fail("ends inside brackets");
      if (c == '"' || c == '\'' || c == '@' || c == '<') {
        skip_quoted();
        continue;
      }
      if (c == '(' || c == '[' || c == '{') open += c == '(' ? ')' : c == '[' ? ']' : '}';
      if (c == ')' || c == ']' || c == '}') {
        if (open.back() != c) fail(std::string("has '") + c + "' where '" + open.back() + "' closes");
        open.pop_back();
      }
      ++at_;
    } while (!open.empty());
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
};

/// One prim of splats: its attributes, as the file has them.
struct UsdSplats {
  std::vector<float> positions, orientations, harmonics;
  std::vector<double> scales, opacities, degree;  ///< all digits: what is kept is their logarithm
};

/// Reads the value of an attribute, if it is one that counts. The twin whose name ends in h has fewer bits, and counts
/// only where the other is not.
bool read_attribute(UsdText& text, std::string_view name, UsdSplats& splats) {
  const auto list = [&](std::string_view own, std::size_t width, auto& values) {
    const bool half = name.size() == own.size() + 1 && name.starts_with(own) && name.ends_with('h');
    if (name != own && !half) return false;
    if (half && !values.empty()) {
      text.skip_value();
      return true;
    }
    values.clear();
    if (text.next() == 'N') {  // None
      text.skip_value();
    } else if (width == 0) {
      values.push_back(static_cast<std::decay_t<decltype(values[0])>>(text.number()));
    } else {
      text.list(width, values);
    }
    return true;
  };
  return list("positions", 3, splats.positions) || list("scales", 3, splats.scales) ||
         list("orientations", 4, splats.orientations) || list("opacities", 1, splats.opacities) ||
         list("radiance:sphericalHarmonicsCoefficients", 3, splats.harmonics) ||
         list("radiance:sphericalHarmonicsDegree", 0, splats.degree);
}

/// Appends a prim's splats. Throws Error where its lists do not fit together.
void append_prim(const UsdText& text, const UsdSplats& splats, bool first, RawRows& rows, const std::string& file) {
  if (splats.degree.empty()) text.fail("needs radiance:sphericalHarmonicsDegree");
  if (!(splats.degree[0] >= 0.0 && splats.degree[0] <= kUsdDegree)) {
    text.fail("radiance:sphericalHarmonicsDegree must be 0 to 3");
  }
  const auto degree = static_cast<unsigned>(splats.degree[0]);
  if (first) rows.sh_degree = degree;
  if (degree != rows.sh_degree) text.fail("all splats must have harmonics of one degree");
  const std::size_t n = splats.positions.size() / 3, kept = std::size_t{degree + 1} * (degree + 1);
  const auto fits = [&](const char* name, std::size_t values, std::size_t per_splat) {
    if (values == n * per_splat) return;
    text.fail(std::string(name) + " must be of the " + std::to_string(n) + " positions; it has " +
              std::to_string(values) + " numbers, not " + std::to_string(n * per_splat));
  };
  fits("scales", splats.scales.size(), 3);
  fits("orientations", splats.orientations.size(), 4);
  fits("opacities", splats.opacities.size(), 1);
  fits("radiance:sphericalHarmonicsCoefficients", splats.harmonics.size(), 3 * kept);
  rows.require_memory_for(n, file);
  for (std::size_t i = 0; i < n; ++i) {
    rows.x.push_back(static_cast<double>(splats.positions[i * 3]));
    rows.y.push_back(static_cast<double>(splats.positions[i * 3 + 1]));
    rows.z.push_back(static_cast<double>(splats.positions[i * 3 + 2]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double scale = splats.scales[i * 3 + axis];
      if (scale < 0.0) text.fail("scales must not be negative: they are linear");
      rows.log_scale.push_back(log_of_scale(scale));
    }
    if (splats.opacities[i] < 0.0 || splats.opacities[i] > 1.0) text.fail("opacities must be 0 to 1");
    rows.opacity_logit.push_back(logit_of(splats.opacities[i]));
  }
  rows.rotation.insert(rows.rotation.end(), splats.orientations.begin(), splats.orientations.end());
  rows.sh.insert(rows.sh.end(), splats.harmonics.begin(), splats.harmonics.end());
}

class UsdScene {
 public:
  UsdScene(std::string_view bytes, const std::string& file) : text_(bytes, file), file_(file) {}

  RawRows read() {
    if (text_.next() == '(') text_.skip_value();  // of the file itself
    while (text_.next() != '\0') statement(0, nullptr);
    if (prims_ == 0) {
      throw Error(file_, "", "no def " + std::string(kUsdSplats) + " in it, and no file that it names is opened");
    }
    if (moved_ > 0) rows_.noticed["transforms of prims, not applied"] = moved_;
    return std::move(rows_);
  }

 private:
  /// A prim, or a property of the prim that it stands in. splats: where that is of splats.
  void statement(int depth, UsdSplats* splats) {
    const std::vector<std::string_view> words = text_.words_of_line();
    if (words.empty()) text_.fail("needs a prim or a property");
    if (words[0] == "def" || words[0] == "over" || words[0] == "class") {
      return prim(depth, words[0] == "def" && words.size() > 1 && words[1] == kUsdSplats);
    }
    const std::string_view name = words.back();
    if (text_.next() == '"') text_.skip_value();  // variantSet "NAME" = { ... }
    moved_ += name == "xformOpOrder";
    if (splats != nullptr && name.ends_with(".timeSamples")) {
      text_.fail(std::string(name) + ": splats that move are not read");
    }
    if (text_.take('=') && (splats == nullptr || !read_attribute(text_, name, *splats))) text_.skip_value();
    if (text_.next() == '(') text_.skip_value();  // what is said of the property
  }

  void prim(int depth, bool of_splats) {
    if (depth > kUsdDepth) text_.fail("prims must be at most 64 deep");
    text_.skip_value();  // its name
    if (text_.next() == '(') text_.skip_value();
    UsdSplats splats;
    for (text_.expect('{'); text_.next() != '}';) {
      if (text_.next() == '\0') text_.fail("ends inside a prim");
      statement(depth + 1, of_splats ? &splats : nullptr);
    }
    if (of_splats) append_prim(text_, splats, prims_++ == 0, rows_, file_);
    text_.expect('}');
  }

  UsdText text_;
  const std::string& file_;
  RawRows rows_;
  std::size_t prims_ = 0, moved_ = 0;
};

}  // namespace

bool is_usda(std::string_view bytes) { return bytes.starts_with(kUsdMagic); }

RawRows read_usda(std::string_view bytes, const std::string& file) { return UsdScene(bytes, file).read(); }

}  // namespace grtx::frontend
