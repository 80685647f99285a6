// SPDX-License-Identifier: Apache-2.0
// The counters of a unit, each declared once: how it is combined over units, and which statistic of which kind it
// becomes. A field is a pointer to a member, or f(counters) returning a reference to a nested field.
//
//   const CounterTable<Counters>& Counters::table() {
//     static const auto table = CounterTable<Counters>()
//                                   .sum(&Counters::calls, "calls", "calls", "traceRay calls accepted")
//                                   .largest(&Counters::depth, "depth", "entries", "deepest stack");
//     return table;
//   }
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/declare/own_counts.h"
#include "grtx/base/declare/statistics.h"

namespace grtx::declare {

/// `text` with "{}" replaced by `name`.
std::string with_name(std::string_view text, std::string_view name);

/// An array of counters indexed by an enumeration: statistics "name.NAME"; "{}" in the description is replaced by NAME.
template <typename Field>
struct CounterColumn {
  Field field;
  const char* name;
  const char* unit;
  const char* description;
};

template <typename Counters>
class CounterTable {
 public:
  /// A counter that is summed over units.
  template <typename Field>
  CounterTable& sum(Field field, const char* name, const char* unit, const char* description) {
    sum(field);
    return value(field, name, unit, description, StatisticKind::count);
  }
  /// The same, without a statistic.
  template <typename Field>
  CounterTable& sum(Field field) {
    return own(field, [](auto& total, const auto& more) { total += more; });
  }
  /// A counter that is summed over units, and that the trace gives, too (StatisticKind::exact).
  template <typename Field>
  CounterTable& exact(Field field, const char* name, const char* unit, const char* description) {
    sum(field);
    return value(field, name, unit, description, StatisticKind::exact);
  }
  /// A counter whose maximum over units is taken.
  template <typename Field>
  CounterTable& largest(Field field, const char* name, const char* unit, const char* description) {
    own(field, [](auto& total, const auto& more) { total = std::max(total, more); });
    return value(field, name, unit, description, StatisticKind::largest);
  }
  /// A Distribution, merged over units: statistics "name" (mean) and "name_max".
  template <typename Field>
  CounterTable& distribution(Field field, const std::string& name, const char* unit, const char* mean,
                             const char* max) {
    own(field, [](auto& total, const auto& more) { total.merge(more); });
    this->mean({"", [field](const Counters& c) { return std::invoke(field, c).sum(); }},
               {"", [field](const Counters& c) { return std::invoke(field, c).count(); }}, name, unit, mean);
    return value([field](const Counters& c) { return std::invoke(field, c).max(); }, name + "_max", unit, max,
                 StatisticKind::largest);
  }
  /// Arrays of summed counters, indexed by an enumeration. Statistics are ordered by enumeration value, then column.
  /// keep: selects the values that become statistics; nullptr: all.
  template <NamedEnum Enum, typename... Fields>
  CounterTable& by_name(bool (*keep)(Enum), CounterColumn<Fields>... columns) {
    const auto elementwise = [](auto& total, const auto& more) {
      static_assert(std::tuple_size_v<std::remove_cvref_t<decltype(total)>> == kCountOf<Enum>);
      for (std::size_t i = 0; i < total.size(); ++i) total[i] += more[i];
    };
    (own(columns.field, elementwise), ...);
    for (std::size_t i = 0; i < kCountOf<Enum>; ++i) {
      if (keep == nullptr || keep(static_cast<Enum>(i))) (place(columns, i, name_at<Enum>(i)), ...);
    }
    return *this;
  }
  template <NamedEnum Enum, typename Field>
  CounterTable& by_name(Field field, const char* name, const char* unit, const char* description) {
    return by_name<Enum>(nullptr, CounterColumn<Field>{field, name, unit, description});
  }
  /// A statistic derived from the counters. f(counters) returns an integer.
  template <typename F>
  CounterTable& value(F f, std::string name, const char* unit, std::string description, StatisticKind kind) {
    static_assert(std::integral<std::remove_cvref_t<std::invoke_result_t<F, const Counters&>>>,
                  "a real number is a mean or a ratio");
    return described([f, name = "." + std::move(name), unit, description = std::move(description), kind](
                         const Counters& c, StatisticList& list, const std::string& prefix) {
      list.add(prefix + name, static_cast<std::uint64_t>(std::invoke(f, c)), unit, description, kind);
    });
  }
  /// One of the two counts of a mean or a ratio. name: of the statistic that it is, of this table; "": of none.
  struct Count {
    const char* name;
    std::function<std::uint64_t(const Counters&)> of;
  };
  /// part / whole of the sums over units; 0 if whole is 0.
  CounterTable& ratio(Count part, Count whole, std::string name, const char* unit, std::string description) {
    return quotient(std::move(part), std::move(whole), std::move(name), unit, std::move(description),
                    StatisticKind::ratio);
  }
  /// The same, where `part` is of `whole`.
  CounterTable& share(Count part, Count whole, std::string name, const char* unit, std::string description) {
    return quotient(std::move(part), std::move(whole), std::move(name), unit, std::move(description),
                    StatisticKind::share);
  }
  /// The same, where `part` sums up the values of so many as `whole` counts.
  CounterTable& mean(Count part, Count whole, std::string name, const char* unit, std::string description) {
    return quotient(std::move(part), std::move(whole), std::move(name), unit, std::move(description),
                    StatisticKind::mean);
  }
  /// A nested counter struct with its own table, combined over units but without statistics.
  template <typename Field>
  CounterTable& part(Field field) {
    return own(field, [](auto& total, const auto& more) { total.table().add(total, more); });
  }
  /// The same, with its statistics under prefix + `name`.
  template <typename Field>
  CounterTable& part(Field field, const std::string& name) {
    part(field);
    return described([field, name](const Counters& c, StatisticList& list, const std::string& prefix) {
      const auto& inner = std::invoke(field, c);
      inner.table().describe(inner, list, prefix + name);
    });
  }
  /// An OwnCounts field: combined by name, with its statistics.
  template <typename Field>
  CounterTable& own_counts(Field field) {
    own(field, [](OwnCounts& total, const OwnCounts& more) { total.add(more); });
    return described([field](const Counters& c, StatisticList& list, const std::string& prefix) {
      std::invoke(field, c).describe(list, prefix);
    });
  }
  /// A field with its own rule to combine units: rule(total, more).
  template <typename Field, typename F>
  CounterTable& own(Field field, F rule) {
    bytes_ += sizeof(std::remove_cvref_t<std::invoke_result_t<Field, Counters&>>);
    adds_.push_back(
        [field, rule](Counters& total, const Counters& c) { rule(std::invoke(field, total), std::invoke(field, c)); });
    return *this;
  }
  /// Statistics appended by rule(counters, list, prefix).
  template <typename F>
  CounterTable& described(F rule) {
    describes_.push_back(
        [shown = shown_, rule = std::move(rule)](const Counters& c, StatisticList& list, const std::string& prefix) {
          if (!shown || list.is_reference() || shown(c)) rule(c, list, prefix);
        });
    return *this;
  }
  /// All following statistics are listed only if shown(counters) is true.
  template <typename F>
  CounterTable& when(F shown) {
    shown_ = std::move(shown);
    return *this;
  }

  /// Adds `counters` to `total`.
  void add(Counters& total, const Counters& counters) const {
    for (const auto& one : adds_) one(total, counters);
  }
  /// Appends all statistics as prefix + ".name", in the order of the table.
  void describe(const Counters& counters, StatisticList& list, const std::string& prefix) const {
    for (const auto& one : describes_) one(counters, list, prefix);
  }
  /// Total size of the fields in the table; equals sizeof(Counters) if none was forgotten.
  std::size_t bytes() const { return bytes_; }

 private:
  CounterTable& quotient(Count part, Count whole, std::string name, const char* unit, std::string description,
                         StatisticKind kind) {
    return described([part = std::move(part), whole = std::move(whole), name = "." + std::move(name), unit,
                      description = std::move(description),
                      kind](const Counters& c, StatisticList& list, const std::string& prefix) {
      const auto full = [&prefix](const char* of) { return *of == 0 ? std::string() : prefix + "." + of; };
      list.add(prefix + name, Quotient{part.of(c), whole.of(c), full(part.name), full(whole.name)}, unit, description,
               kind);
    });
  }
  template <typename Field>
  void place(const CounterColumn<Field>& column, std::size_t i, std::string_view name) {
    value([field = column.field, i](const Counters& c) { return std::invoke(field, c)[i]; },
          std::string(column.name) + "." + std::string(name), column.unit, with_name(column.description, name),
          StatisticKind::count);
  }

  std::size_t bytes_ = 0;
  std::function<bool(const Counters&)> shown_;  ///< condition of the statistics added next; empty: always
  std::vector<std::function<void(Counters&, const Counters&)>> adds_;
  std::vector<std::function<void(const Counters&, StatisticList&, const std::string&)>> describes_;
};

}  // namespace grtx::declare
