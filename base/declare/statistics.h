// SPDX-License-Identifier: Apache-2.0
// Statistics with name, unit and description. Modules count in plain integers and describe them once, at the end.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace grtx::declare {

struct Statistic {
  std::string name;  ///< hierarchical, lower_snake_case, dots between levels, e.g. gpu.rt.node_fetches
  std::variant<std::uint64_t, double> value;
  std::string unit;
  std::string description;
  double picojoules = 0.0;  ///< energy per count; 0: none, or accounted for elsewhere
};

/// part / whole; 0 if whole is 0.
inline double ratio(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// An ordered list of statistics, filled by modules' `statistics(StatisticList&)`.
class StatisticList {
 public:
  StatisticList() = default;
  /// A list for the documentation: a group of similar statistics appears once, with a placeholder name in <>.
  static StatisticList of_kinds() {
    StatisticList list;
    list.kinds_ = true;
    return list;
  }
  bool lists_kinds() const { return kinds_; }

  void add(std::string name, std::uint64_t value, std::string unit, std::string description) {
    items_.push_back({std::move(name), value, std::move(unit), std::move(description), 0.0});
  }
  void add(std::string name, double value, std::string unit, std::string description) {
    items_.push_back({std::move(name), value, std::move(unit), std::move(description), 0.0});
  }
  void add(Statistic statistic) { items_.push_back(std::move(statistic)); }
  const std::vector<Statistic>& items() const { return items_; }

 private:
  bool kinds_ = false;
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
