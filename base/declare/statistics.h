// SPDX-License-Identifier: Apache-2.0
// Statistics with name, unit, description and kind. Modules count in plain integers and describe them once, at the end.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "grtx/base/declare/named_enum.h"

namespace grtx::declare {

/// How a statistic follows from those of several units, or of the parts of a run.
enum class StatisticKind : std::uint8_t {
  count,      ///< their sum
  exact,      ///< their sum, and a total of the trace: the same on every machine and in every mode
  largest,    ///< the largest of them
  smallest,   ///< the smallest of them
  mean,       ///< the sum of all values over their number
  ratio,      ///< the sum of one count over the sum of another
  histogram,  ///< values in a bin: their sum
  bound,      ///< a lower bound on cycles: that of the unit with most work
  state,      ///< what is so at the end of a run: follows from none of them
  share       ///< a ratio of a part to its whole, from 0 to 1: hit rates, utilisations
};
constexpr auto enum_names(StatisticKind) {
  return names_in_order<StatisticKind>(
      {"count", "exact", "largest", "smallest", "mean", "ratio", "histogram", "bound", "state", "share"});
}

/// part / whole; 0 if whole is 0.
inline double ratio(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// The two counts of a mean or a ratio.
struct Quotient {
  std::uint64_t part = 0, whole = 0;
  std::string part_name, whole_name;  ///< of the statistics that they are; "": of none
  double value() const { return ratio(part, whole); }
};

struct Statistic {
  std::string name;  ///< hierarchical, lower_snake_case, dots between levels, e.g. gpu.rt.node_fetches
  std::variant<std::uint64_t, double> value;
  std::string unit;
  std::string description;
  double picojoules = 0.0;  ///< energy per count; 0: none, or accounted for elsewhere
  StatisticKind kind;
  Quotient of{};  ///< of a mean or a ratio; 0 / 0 where it is made from no two counts

  double number() const {
    return std::visit([](auto v) { return static_cast<double>(v); }, value);
  }
};

/// An ordered list of statistics, filled by modules' `statistics(StatisticList&)`.
class StatisticList {
 public:
  StatisticList() = default;
  /// A list for the documentation: a group of similar statistics appears once, with a placeholder name in <>.
  static StatisticList of_reference() {
    StatisticList list;
    list.reference_ = true;
    return list;
  }
  bool is_reference() const { return reference_; }

  void add(std::string name, std::uint64_t value, std::string unit, std::string description, StatisticKind kind) {
    items_.push_back({std::move(name), value, std::move(unit), std::move(description), 0.0, kind});
  }
  void add(std::string name, double value, std::string unit, std::string description, StatisticKind kind) {
    items_.push_back({std::move(name), value, std::move(unit), std::move(description), 0.0, kind});
  }
  void add(std::string name, const Quotient& of, std::string unit, std::string description, StatisticKind kind) {
    items_.push_back({std::move(name), of.value(), std::move(unit), std::move(description), 0.0, kind, of});
  }
  void add(Statistic statistic) { items_.push_back(std::move(statistic)); }
  const std::vector<Statistic>& items() const { return items_; }

 private:
  bool reference_ = false;
  std::vector<Statistic> items_;
};

/// Count, sum, maximum and power-of-two histogram (bin b counts values in [2^(b-1), 2^b), bin 0 zeros).
class Distribution {
 public:
  void add(std::uint64_t value, std::uint64_t times = 1) {
    count_ += times;
    sum_ += value * times;
    if (value > max_ && times > 0) max_ = value;
    const auto bin = static_cast<unsigned>(std::bit_width(value));
    bins_[bin < kBins ? bin : kBins - 1] += times;
  }
  /// Adds all values of another distribution.
  void merge(const Distribution& other) {
    count_ += other.count_;
    sum_ += other.sum_;
    if (other.max_ > max_) max_ = other.max_;
    for (unsigned i = 0; i < kBins; ++i) bins_[i] += other.bins_[i];
  }
  std::uint64_t count() const { return count_; }
  std::uint64_t sum() const { return sum_; }
  std::uint64_t max() const { return max_; }
  double mean() const { return count_ == 0 ? 0.0 : static_cast<double>(sum_) / static_cast<double>(count_); }
  static constexpr unsigned kBins = 33;
  std::uint64_t bin(unsigned i) const { return bins_[i]; }

 private:
  std::uint64_t count_ = 0;
  std::uint64_t sum_ = 0;
  std::uint64_t max_ = 0;
  std::uint64_t bins_[kBins] = {};
};

}  // namespace grtx::declare
