// SPDX-License-Identifier: Apache-2.0
// Declaration of model parameters: key, location of the value, allowed range, meaning, and source of the default. A
// unit lists its parameters next to its Config; loading, checking, --set, the resolved JSON, the hash and the key
// reference all use this list. Free of SystemC.
//
//   struct Config {
//     unsigned entries = 8;
//     void parameters(ParameterList& list) {
//       list.add("entries", entries, {1, 64}, "warps", "warp buffer of the RT unit", kTable1);
//     }
//   };
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "grtx/base/declare/named_enum.h"

namespace grtx::declare {

/// Confidence in a default, on the project's only scale: A = stated in the paper, B = taken from a public simulator,
/// product or publication, C = assumption of this project, to be varied in sweeps.
enum class Confidence : char { paper = 'A', public_source = 'B', assumption = 'C' };

/// Source of a default.
struct Origin {
  const char* source;
  Confidence confidence;
};
constexpr Origin from_paper(const char* place) { return {place, Confidence::paper}; }
constexpr Origin from_public(const char* source) { return {source, Confidence::public_source}; }
constexpr Origin assumed(const char* why) { return {why, Confidence::assumption}; }

inline constexpr Origin kTable1 = from_paper("GRTX, Table I");
inline constexpr Origin kVulkanSim = from_public("Vulkan-Sim (SM75_RTX2060 configuration)");
inline constexpr Origin kGpgpuSim = from_public("GPGPU-Sim as in Vulkan-Sim");
inline constexpr Origin kTreeTraversal = from_public("UBC 2024, generalized tree traversal accelerator");
inline constexpr Origin kOurs = assumed("this project");

/// Allowed numbers, inclusive.
struct Range {
  double min = 0.0;
  double max = std::numeric_limits<double>::infinity();
};
inline constexpr double kMaxLatency = 10000;             ///< cycles; far beyond real hardware
inline constexpr double kMaxEntries = 4096;              ///< entries of a queue or table
inline constexpr double kMinMhz = 100, kMaxMhz = 10000;  ///< clock frequency

/// A text value: one of a few names, or any text.
struct Choice {
  std::vector<std::string> names;  ///< empty: any text
  std::function<std::string()> get;
  std::function<void(const std::string&)> set;
  std::string hint = {};  ///< added to the error message for an unknown name
};

struct Parameter {
  std::string name;  ///< dotted, as in the TOML tables: table.key
  std::variant<unsigned*, std::uint64_t*, double*, bool*, Choice> value;
  Range range;  ///< for numbers
  std::string unit;
  std::string description;
  Origin origin;
};

/// A constraint that a range of a single parameter cannot express.
struct ParameterRule {
  std::string name;  ///< of the parameter to change
  std::function<bool()> holds;
  std::string rule;
};

/// The parameters and rules of a unit, or of a whole machine with each unit's under its prefix. They point into the
/// Config, which must outlive them.
class ParameterList {
 public:
  template <typename Number>  // unsigned, std::uint64_t, double
  Parameter& add(const char* key, Number& value, Range range, const char* unit, std::string description,
                 Origin origin) {
    return items_.emplace_back(Parameter{prefix_ + key, &value, range, unit, std::move(description), origin});
  }
  Parameter& add(const char* key, bool& value, std::string description, Origin origin) {
    return items_.emplace_back(Parameter{prefix_ + key, &value, {}, "", std::move(description), origin});
  }
  /// A text that must be one of `names`, for example the registered policies; any text if there are no names. hint:
  /// added to the error message for an unknown name.
  Parameter& add(const char* key, std::string& value, std::vector<std::string> names, std::string description,
                 Origin origin, std::string hint = {}) {
    return choice(key,
                  {std::move(names), [&value] { return value; }, [&value](const std::string& name) { value = name; },
                   std::move(hint)},
                  std::move(description), origin);
  }
  template <NamedEnum Enum>
  Parameter& add(const char* key, Enum& value, const std::string& description, Origin origin) {
    return choice(key,
                  {names_of<Enum>(),
                   [&value] { return std::string(name_of(value)); },
                   [&value](const std::string& name) { value = *from_name<Enum>(name); },
                   {}},
                  description, origin);
  }
  /// A condition on values that are each within their range; checked by require_rules().
  void rule(const char* key, std::function<bool()> holds, std::string rule) {
    rules_.push_back({prefix_ + key, std::move(holds), std::move(rule)});
  }
  /// Puts everything that list(*this) adds under "prefix.".
  template <typename List>
  void under(const std::string& prefix, List&& list) {
    const std::string outer = prefix_;
    prefix_ += prefix + ".";
    list(*this);
    prefix_ = outer;
  }
  /// Adds the parameters of a part under "prefix.".
  template <typename Config>
  void part(const std::string& prefix, Config& config) {
    under(prefix, [&](ParameterList& list) { config.parameters(list); });
  }
  const std::vector<Parameter>& items() const { return items_; }
  const std::vector<ParameterRule>& rules() const { return rules_; }

 private:
  Parameter& choice(const char* key, Choice choice, std::string description, Origin origin) {
    return items_.emplace_back(Parameter{prefix_ + key, std::move(choice), {}, "", std::move(description), origin});
  }

  std::string prefix_;
  std::vector<Parameter> items_;
  std::vector<ParameterRule> rules_;
};

/// Current value as text: doubles in the shortest form that reads back exactly, names unquoted.
std::string value_text(const Parameter& parameter);
/// Allowed values as text, e.g. "1 to 64" or "true, false".
std::string range_text(const Parameter& parameter);

/// Assigns a value given as text (for --set). Returns "" or the broken rule.
std::string assign_text(const Parameter& parameter, const std::string& text);
/// Assign a typed TOML value. Return "" or the broken rule.
std::string assign_integer(const Parameter& parameter, std::int64_t value);
std::string assign_real(const Parameter& parameter, double value);
std::string assign_bool(const Parameter& parameter, bool value);
std::string assign_string(const Parameter& parameter, const std::string& value);

/// Throws Error{origin, key, rule} for the first rule that does not hold.
void require_rules(const ParameterList& list, const std::string& origin);
/// Throws Error{"configuration", key, rule} for the first value out of range or the first rule that does not hold.
/// Called by units, whose configuration may not come from a checked file.
void require_allowed(const ParameterList& list);
template <typename Config>
void require_allowed(const std::string& prefix, Config config) {
  ParameterList list;
  list.part(prefix, config);
  require_allowed(list);
}

}  // namespace grtx::declare
