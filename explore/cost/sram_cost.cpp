// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/sram_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "grtx/explore/cost/sram_table.h"
#include "grtx/explore/cost/technology.h"

namespace grtx::explore {
namespace {

struct Point {
  double bytes = 0.0;
  // area mm2, access ns, read pJ, write pJ, leakage mW
  std::array<double, 5> values{};
};

// cache, word bytes (ram) or bus bits (cache), two ports, node, device
using Family = std::tuple<bool, unsigned, bool, unsigned, std::string>;

const std::map<Family, std::vector<Point>>& table() {
  static const std::map<Family, std::vector<Point>> families = [] {
    std::map<Family, std::vector<Point>> result;
    std::istringstream text{std::string(kSramTable)};
    std::string line;
    std::getline(text, line);  // header
    while (std::getline(text, line)) {
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (cells.size() != 13) throw std::logic_error("SRAM table: a row has not 13 cells: " + line);
      const bool cache = cells[0] == "cache";
      if (cache && cells[3] != "16") continue;
      const auto width = static_cast<unsigned>(std::stoul(cells[cache ? 7 : 2]));
      Point point;
      point.bytes = std::stod(cells[1]);
      for (std::size_t i = 0; i < 5; ++i) point.values[i] = std::stod(cells[8 + i]);
      result[{cache, width, cells[4] == "1R1W", static_cast<unsigned>(std::stoul(cells[5])), cells[6]}].push_back(
          point);
    }
    for (auto& [family, points] : result) {
      std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.bytes < b.bytes; });
    }
    return result;
  }();
  return families;
}

double log_line(double x, double x0, double y0, double x1, double y1) {
  const double share = std::log(x / x0) / std::log(x1 / x0);
  return std::exp((1.0 - share) * std::log(y0) + share * std::log(y1));
}

// Below the table: extrapolates the line through the first two points. Above: several banks of the largest size in
// parallel.
std::array<double, 5> at_size(const std::vector<Point>& points, double bytes) {
  const Point& last = points.back();
  if (bytes > last.bytes) {
    std::array<double, 5> banked = last.values;
    banked[0] *= bytes / last.bytes;
    banked[4] *= bytes / last.bytes;
    return banked;
  }
  std::size_t i = 0;
  while (i + 2 < points.size() && points[i + 1].bytes < bytes) ++i;
  std::array<double, 5> values{};
  for (std::size_t v = 0; v < 5; ++v) {
    values[v] = log_line(bytes, points[i].bytes, points[i].values[v], points[i + 1].bytes, points[i + 1].values[v]);
  }
  return values;
}

const std::vector<Point>& family(bool cache, unsigned width, bool two_ports, unsigned nm, const std::string& device) {
  const auto found = table().find({cache, width, two_ports, nm, device});
  if (found == table().end()) throw std::logic_error("SRAM table: a family is missing");
  return found->second;
}

// um2 of a 6T high-density cell: Intel and TSMC as published (WikiChip).
double cell_um2(unsigned nm) {
  switch (nm) {
    case 16:
      return 0.074;
    case 12:
      return 0.074;  // 12FFC keeps the cell of 16FF
    case 7:
      return 0.027;
    case 5:
      return 0.021;
    default:
      throw std::logic_error("no bit cell");
  }
}

}  // namespace

SramCost sram_cost(const SramRequest& request) {
  const double bytes = std::max(1.0, static_cast<double>(request.bits) / 8.0);
  unsigned width = 256;  // bus of a cache
  if (!request.cache) {
    width = 4;
    for (const unsigned w : {16u, 32u, 128u}) {
      if (request.word_bits > w * 8 / 2) width = w;
    }
  }
  const auto values_at = [&](unsigned nm, const std::string& device) {
    return at_size(family(request.cache, width, request.two_ports && !request.cache, nm, device), bytes);
  };
  // Time, energy and area are those of high-performance cells. Leakage: high end of high-performance cells, low end of
  // low-standby-power cells (in the table for 32 B words).
  const auto leakage_at = [&](unsigned nm, double high) {
    const unsigned table_nm = nm >= 32 ? 45 : 22;
    const double low = at_size(family(request.cache, request.cache ? 256 : 32, false, table_nm, "itrs-lstp"), bytes)[4];
    return Range{std::min(low, high), std::sqrt(std::min(low, high) * high), high};
  };
  SramCost cost;
  std::array<double, 5> v{};
  if (request.nm >= 32 || request.nm == 22) {
    v = values_at(request.nm, "itrs-hp");
    cost.estimator = "CACTI 7.0";
    // CACTI's 22 nm cell is 1.3 times smaller than the published one.
    const double high = request.nm == 22 ? 1.5 * 1.3 : 1.5;
    cost.area_mm2 = {0.8 * v[0], request.nm == 22 ? 1.15 * v[0] : v[0], high * v[0]};
  } else if (request.nm == 28) {
    const auto a = values_at(32, "itrs-hp"), b = values_at(22, "itrs-hp");
    for (std::size_t i = 0; i < 5; ++i) v[i] = log_line(28, 32, a[i], 22, b[i]);
    cost.estimator = "CACTI 7.0, between 32 and 22 nm";
    cost.area_mm2 = {0.8 * v[0], v[0], 1.5 * v[0]};
  } else {
    v = values_at(22, "itrs-hp");
    // Array efficiency 0.35 at 4 Kib to 0.70 from 1 Mib on; an 8T cell for two ports is 1.4 times larger. Tags: 1.1.
    const double share = std::clamp(std::log2(bytes * 8.0 / 4096.0) / 8.0, 0.0, 1.0);
    const double efficiency = 0.35 + 0.35 * share;
    const double mm2 = bytes * 8.0 * cell_um2(request.nm) * (request.two_ports ? 1.4 : 1.0) *
                       (request.cache ? 1.1 : 1.0) / efficiency * 1e-6;
    cost.area_mm2 = {0.8 * mm2, mm2, 1.5 * mm2};
    v[1] *= stillmaker_delay(request.nm) / stillmaker_delay(22);
    v[2] *= stillmaker_energy(request.nm) / stillmaker_energy(22);
    v[3] *= stillmaker_energy(request.nm) / stillmaker_energy(22);
    cost.estimator = "bit cell; CACTI 7.0 at 22 nm, scaled";
  }
  cost.access_ns = v[1];
  cost.read_pj = v[2];
  cost.write_pj = v[3];
  cost.leakage_mw = leakage_at(request.nm, v[4]);
  return cost;
}

}  // namespace grtx::explore
