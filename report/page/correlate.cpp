// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/correlate.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/geometric_mean.h"
#include "grtx/base/json.h"
#include "grtx/base/printable.h"
#include "grtx/base/wrapped.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/report/page/mode_agreement.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

/// Fields of a line of a CSV file, without the blanks around them.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream rest(line + ',');
  for (std::string field; std::getline(rest, field, ',');) {
    const std::size_t begin = field.find_first_not_of(" \r");
    fields.push_back(begin == std::string::npos ? "" : field.substr(begin, field.find_last_not_of(" \r") - begin + 1));
  }
  return fields;
}

const std::map<std::string, std::string Measured::*> kTexts = {
    {"card", &Measured::card},     {"source", &Measured::source}, {"scene", &Measured::scene},
    {"design", &Measured::design}, {"over", &Measured::over},     {"quantity", &Measured::quantity},
    {"why", &Measured::why}};
const std::map<std::string, double Measured::*> kNumbers = {{"value", &Measured::value}, {"low", &Measured::low},
                                                            {"high", &Measured::high},   {"pixels", &Measured::pixels},
                                                            {"sms", &Measured::sms},     {"mhz", &Measured::mhz}};

/// Rule that the header line violates; "" if none.
std::string fault_of_names(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (!kTexts.contains(name) && !kNumbers.contains(name) && name.find('.') == std::string::npos) {
      return "column '" + printable(name) +
             "' is none of card, source, scene, design, over, quantity, value, low, high, pixels, sms, mhz, why, and "
             "no KEY.NAME of a plan";
    }
    if (std::count(names.begin(), names.end(), name) > 1) return "column '" + printable(name) + "' is there twice";
  }
  for (const char* needed : {"design", "value"}) {
    if (std::count(names.begin(), names.end(), needed) == 0) return std::string("column '") + needed + "' is missing";
  }
  return "";
}

/// Design name used in databases: that of the design that is no more than this structure, if there is one.
std::string design_of(const std::string& name) {
  for (const explore::Design& design : explore::designs()) {
    if (design.keys.empty() && name == design.accel + (design.checkpoint ? "+checkpoint" : "")) return design.name;
  }
  return name;
}

/// Label without the scene, shared by the values of several scenes.
std::string group_of(const Measured& m) {
  std::string label = m.source.empty() ? "" : m.source + ": ";
  label += m.design;
  if (!m.over.empty()) label += " over " + m.over;
  if (m.quantity != "gpu.time_us") label += ", " + m.quantity;
  for (const auto& [name, value] : m.coordinates) label += ", " + name + " " + value;
  return label;
}

/// The card's frame in ms, if each of its SMs does as those of the crop. A crop's last warps leave SMs empty, which a
/// whole frame does not: only cycles count in which the RT units' warp buffers are full, or their share that is.
double frame_ms(const ReportedPoint& point, const Measured& m) {
  const auto of = [](const ordered_json& object, const char* name) {
    return object.contains(name) && object.at(name).is_number() ? object.at(name).get<double>()
                                                                : std::numeric_limits<double>::quiet_NaN();
  };
  const double full = point.value("gpu.rt.occupancy") / of(point.config, "rt.warp_buffer.entries");
  const double cycles = point.value("gpu.cycles") * full;
  if (!m.over.empty()) return cycles;  // a ratio on one machine
  if (point.trace == nullptr) return std::numeric_limits<double>::quiet_NaN();
  const double crops = m.pixels / (of(*point.trace, "width") * of(*point.trace, "height"));
  return cycles * crops * of(point.config, "gpu.sms") / m.sms / (1000.0 * m.mhz);
}

/// A coordinate of the point, or what its whole plan has in common: an option of its trace or a key of its machine. "":
/// neither.
std::string input_of(const ReportedPoint& point, const std::string& name) {
  for (const ordered_json* inputs : {&point.coordinates, point.trace.get(), &point.config}) {
    if (inputs != nullptr && inputs->contains(name)) return explore::text_of(inputs->at(name));
  }
  return "";
}

class Matcher {
 public:
  Matcher(const SweepResults& sweep, const std::string& path) : sweep_(sweep), path_(path) {}

  /// The simulated value by scene, for all scenes that have it.
  std::map<std::string, double> figures(const Measured& m) const {
    std::map<std::string, double> found;
    for (const auto& [scene, value] : values(m, m.design)) {
      if (m.over.empty()) {
        found[scene] = value;
        continue;
      }
      const std::map<std::string, double> others = values(m, m.over);
      if (const auto other = others.find(scene); other != others.end()) found[scene] = other->second / value;
    }
    return found;
  }

 private:
  std::map<std::string, double> values(const Measured& m, const std::string& design) const {
    std::map<std::string, double> found;
    for (const ReportedPoint& point : sweep_.points) {
      const double value = m.quantity == kFrameMs ? frame_ms(point, m) : point.value(m.quantity);
      if (!point.done() || point.design != design || !std::isfinite(value) || value <= 0.0) continue;
      const bool fits = std::all_of(m.coordinates.begin(), m.coordinates.end(),
                                    [&](const auto& wanted) { return input_of(point, wanted.first) == wanted.second; });
      if (!fits) continue;
      if (!found.emplace(point.scene, value).second) {
        throw Error(path_, "scene " + point.scene,
                    "has several points of " + design + " that line " + std::to_string(m.line) +
                        " fits: name what tells them apart in a column of the measured figures");
      }
    }
    return found;
  }

  const SweepResults& sweep_;
  std::string path_;
};

struct Spread {
  double mean = 0.0, low = std::numeric_limits<double>::infinity(), high = 0.0;
};

/// Square of the standard error of the mean of logarithms; 0 of a single value.
double squared_error(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  if (n < 2.0) return 0.0;
  const double mean = std::log(geometric_mean(values));
  double sum = 0.0;
  for (const double value : values) sum += (std::log(value) - mean) * (std::log(value) - mean);
  return sum / (n - 1.0) / n;
}

Spread spread_of(const std::vector<double>& values) {
  Spread spread{geometric_mean(values)};
  for (const double value : values) {
    spread.low = std::min(spread.low, value);
    spread.high = std::max(spread.high, value);
  }
  return spread;
}

std::vector<double> column(const Correlation& c, double Comparison::*field) {
  std::vector<double> values;
  for (const Comparison& one : c.comparisons) values.push_back(one.*field);
  return values;
}

void summarise(Correlation& c) {
  const auto count = static_cast<double>(c.comparisons.size());
  std::vector<double> factors;
  for (const Comparison& one : c.comparisons) {
    c.mean_error += std::abs(one.error()) / count;
    factors.push_back(one.simulated / one.measured);
  }
  c.factor = geometric_mean(factors);
  std::vector<double> left;
  for (const double factor : factors) left.push_back(std::abs(factor / c.factor - 1.0));
  c.scaled_error = std::accumulate(left.begin(), left.end(), 0.0) / count;
  const std::vector<double> measured = column(c, &Comparison::measured), simulated = column(c, &Comparison::simulated);
  const double none = std::numeric_limits<double>::quiet_NaN();
  c.spearman = c.several_units ? none : spearman_rho(measured, simulated);
  c.kendall = c.several_units ? none : kendall_tau(measured, simulated);
  std::vector<double> sorted = left;
  std::sort(sorted.begin(), sorted.end());
  const double bound = std::max(0.1, 2.0 * sorted[sorted.size() / 2]);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i] > bound) c.outliers.push_back(c.comparisons[i].label);
  }
}

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i + 1;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    for (std::size_t j = i; j < end; ++j) rank[order[j]] = static_cast<double>(i + end - 1) / 2.0;
    i = end;
  }
  return rank;
}

}  // namespace

double spearman_rho(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mean = (static_cast<double>(x.size()) - 1.0) / 2.0;
  double both = 0.0, of_x = 0.0, of_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    both += (x[i] - mean) * (y[i] - mean);
    of_x += (x[i] - mean) * (x[i] - mean);
    of_y += (y[i] - mean) * (y[i] - mean);
  }
  if (of_x == 0.0 || of_y == 0.0) return std::numeric_limits<double>::quiet_NaN();
  return both / std::sqrt(of_x * of_y);
}

std::vector<Measured> read_measured(const std::string& path) {
  std::istringstream text(read_file(path));
  std::vector<Measured> all;
  std::vector<std::string> names;
  std::size_t number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (line.find_first_not_of(" \r") == std::string::npos || line.front() == '#') continue;
    const auto require = [&](bool holds, const std::string& rule) {
      if (!holds) throw Error(path, "line " + std::to_string(number), rule);
    };
    const std::vector<std::string> fields = fields_of(line);
    if (names.empty()) {
      names = fields;
      const std::string fault = fault_of_names(names);
      require(fault.empty(), fault);
      continue;
    }
    require(fields.size() == names.size(), fmt::format("has {} fields in place of {}", fields.size(), names.size()));
    Measured& m = all.emplace_back();
    m.line = number;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string &name = names[i], &field = fields[i];
      if (field.empty() && name != "value") continue;
      if (const auto word = kTexts.find(name); word != kTexts.end()) {
        m.*word->second = name == "design" || name == "over" ? design_of(field) : field;
      } else if (const auto figure = kNumbers.find(name); figure != kNumbers.end()) {
        double& value = m.*figure->second;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        require(error == std::errc() && stop == field.data() + field.size() && value > 0.0 && std::isfinite(value),
                name + " '" + printable(field) + "' must be a number above 0");
      } else {
        m.coordinates.emplace_back(name, field);
      }
    }
    require(!m.design.empty(), "design must be named");
    if (m.quantity == kFrameMs && m.over.empty() && m.why.empty()) {
      require(m.pixels > 0.0 && m.sms > 0.0 && m.mhz > 0.0, "frame.ms needs pixels, sms and mhz of the measured frame");
    }
    if (m.low == 0.0) m.low = m.value;
    if (m.high == 0.0) m.high = m.value;
    require(m.low <= m.value && m.high >= m.value, "value must lie between low and high");
  }
  if (all.empty()) throw Error(path, "", "holds no measured figure");
  return all;
}

std::vector<Measured> of_card(const std::vector<Measured>& measured, const std::string& card, const std::string& path) {
  std::vector<Measured> found;
  std::string cards;
  for (const Measured& m : measured) {
    if (card.empty() && m.card != measured.front().card) {
      throw Error(path, "line " + std::to_string(m.line),
                  "is of another card than the lines before: name one with --card");
    }
    if (card.empty() || m.card == card) found.push_back(m);
    if (!m.card.empty() && cards.find(m.card) == std::string::npos) cards += (cards.empty() ? "" : ", ") + m.card;
  }
  if (found.empty()) throw Error(path, "card " + printable(card), "is none of " + printable(cards));
  return found;
}

double Comparison::deviations() const {
  return standard_error > 0.0 ? std::log(simulated / measured) / standard_error
                              : std::numeric_limits<double>::quiet_NaN();
}

Correlation correlate(const std::vector<Measured>& measured, const SweepResults& sweep, const std::string& path) {
  Correlation c;
  std::map<std::string, std::vector<const Measured*>> groups;
  std::vector<std::string> order;
  for (const Measured& m : measured) {
    std::vector<const Measured*>& group = groups[group_of(m)];
    if (group.empty()) order.push_back(group_of(m));
    group.push_back(&m);
  }
  const Matcher matcher(sweep, path);
  std::set<std::string> units;
  for (const std::string& label : order) {
    const std::vector<const Measured*>& group = groups[label];
    if (!group.front()->why.empty()) {
      c.unmatched.push_back(label + " (" + group.front()->why + ")");
      continue;
    }
    const std::map<std::string, double> simulated = matcher.figures(*group.front());
    if (simulated.empty()) {
      c.unmatched.push_back(label);
      continue;
    }
    units.insert(group.front()->over.empty() ? group.front()->quantity : "");  // "": a ratio
    bool paired = false;
    for (const Measured* m : group) {
      const auto same = simulated.find(m->scene);
      if (same == simulated.end()) continue;
      paired = true;
      c.comparisons.push_back({m->scene + ": " + label, true, 1, 1, m->value, m->low, m->high, same->second,
                               same->second, same->second, 0.0});
    }
    if (paired) continue;
    std::vector<double> values, all;
    for (const Measured* m : group) {
      values.push_back(m->value);
      all.insert(all.end(), {m->low, m->high});
    }
    std::vector<double> found;
    for (const auto& [scene, value] : simulated) found.push_back(value);
    const Spread spread = spread_of(found), band = spread_of(all);
    c.comparisons.push_back({label, false, group.size(), found.size(), spread_of(values).mean, band.low, band.high,
                             spread.mean, spread.low, spread.high,
                             std::sqrt(squared_error(found) + squared_error(values))});
  }
  if (c.comparisons.empty()) {
    throw Error(path, "", "has no point that a measured figure fits: first of them " + c.unmatched.front());
  }
  c.several_units = units.size() > 1;
  summarise(c);
  return c;
}

std::string correlation_text(const Correlation& c) {
  std::string text =
      fmt::format("figure\n  {:>22} {:>22} {:>8}  {}\n", "measured", "simulated", "error", "in range, std. errors");
  const auto range = [](double value, double low, double high) {
    return low == high ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} ({:.4g} to {:.4g})", value, low, high);
  };
  for (const Comparison& one : c.comparisons) {
    text += wrapped(one.label) + "\n";
    text += fmt::format("  {:>22} {:>22} {:>+7.0f}%  {}{}\n", range(one.measured, one.measured_low, one.measured_high),
                        range(one.simulated, one.simulated_low, one.simulated_high), 100.0 * one.error(),
                        one.inside_words(), one.standard_error > 0.0 ? fmt::format(", {:+.1f}", one.deviations()) : "");
  }
  for (const std::string& label : c.unmatched) text += wrapped("not simulated: " + label) + "\n";
  text += fmt::format("mean error {:.0f} %; simulated / measured {:.3g} in the mean, {:.0f} % beyond that\n",
                      100.0 * c.mean_error, c.factor, 100.0 * c.scaled_error);
  text += std::isfinite(c.spearman)
              ? fmt::format("rank correlation: Spearman {:.2f}, Kendall {:.2f}\n", c.spearman, c.kendall)
          : c.several_units ? "rank correlation: none, the figures are of several quantities\n"
                            : "rank correlation: none, one side ranks nothing\n";
  for (const std::string& label : c.outliers) text += wrapped("outlier: " + label) + "\n";
  return text;
}

ordered_json comparison_json(const Comparison& one) {
  return {{"label", one.label},
          {"paired", one.paired},
          {"measured", one.measured},
          {"measured_low", one.measured_low},
          {"measured_high", one.measured_high},
          {"simulated", one.simulated},
          {"simulated_low", one.simulated_low},
          {"simulated_high", one.simulated_high},
          {"error", one.error()},
          {"standard_error", one.standard_error},
          {"inside", one.inside()}};
}

ordered_json correlation_json(const Correlation& c) {
  ordered_json json;
  json["comparisons"] = ordered_json::array();
  for (const Comparison& one : c.comparisons) json["comparisons"].push_back(comparison_json(one));
  json["unmatched"] = c.unmatched;
  json["mean_error"] = c.mean_error;
  json["factor"] = c.factor;
  json["scaled_error"] = c.scaled_error;
  json["spearman"] = std::isfinite(c.spearman) ? ordered_json(c.spearman) : ordered_json(nullptr);
  json["kendall"] = std::isfinite(c.kendall) ? ordered_json(c.kendall) : ordered_json(nullptr);
  json["outliers"] = c.outliers;
  return json;
}

}  // namespace grtx::report
