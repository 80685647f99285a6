// One configuration key: where its value lives, what it may be, what it means and where its default comes from.
// A list of these drives loading, checking, --set, the resolved JSON, the hash and the reference in
// docs/model/configuration.md.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace grtx::sim {

/// A value that is one of a few names, or any text.
struct Choice {
  std::vector<std::string> names;  ///< empty: any text
  std::function<std::string()> get;
  std::function<void(const std::string&)> set;
  std::string hint = {};  ///< for who misses a name
};

/// How well a default is known: A = stated in the paper, B = taken from a public simulator or product,
/// C = assumption of this project.
enum class Confidence : char { paper = 'A', public_source = 'B', assumption = 'C' };

struct ConfigKey {
  std::string name;  ///< dotted, as in the TOML tables: table.key
  std::variant<unsigned*, std::uint64_t*, double*, bool*, Choice> value;
  double min = 0.0;  ///< smallest allowed number; numbers only
  double max = std::numeric_limits<double>::infinity();
  std::string unit;
  std::string description;
  std::string source;  ///< of the default
  Confidence confidence = Confidence::assumption;
};

/// Present value as text: integers and bools plainly, doubles in the shortest form that reads back, names unquoted.
std::string value_text(const ConfigKey& key);

/// Allowed values as text, e.g. "1..64" or "true, false".
std::string range_text(const ConfigKey& key);

/// Assigns from text (for --set). Returns "" or the rule that was broken.
std::string assign_text(const ConfigKey& key, const std::string& text);
/// Assign from a typed TOML value. Each returns "" or the rule that was broken.
std::string assign_integer(const ConfigKey& key, std::int64_t value);
std::string assign_real(const ConfigKey& key, double value);
std::string assign_bool(const ConfigKey& key, bool value);
std::string assign_string(const ConfigKey& key, const std::string& value);

/// A Choice over an enumeration.
template <typename Enum>
Choice choice(Enum& target, std::vector<std::pair<std::string, Enum>> values) {
  Choice c;
  for (const auto& [name, value] : values) c.names.push_back(name);
  c.get = [&target, values] {
    for (const auto& [name, value] : values) {
      if (value == target) return name;
    }
    return std::string("?");
  };
  c.set = [&target, values](const std::string& text) {
    for (const auto& [name, value] : values) {
      if (name == text) target = value;
    }
  };
  return c;
}

}  // namespace grtx::sim
