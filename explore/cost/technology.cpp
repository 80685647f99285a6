// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/technology.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "grtx/base/error.h"

namespace grtx::explore {
namespace {

struct Scaling {
  double nm, volts, area;
  double a3, a2, a1, a0;  // delay = a3 V^3 + a2 V^2 + a1 V + a0
  double b2, b1, b0;      // energy = b2 V^2 + b1 V + b0
  double delay() const { return ((a3 * volts + a2) * volts + a1) * volts + a0; }
  double energy() const { return (b2 * volts + b1) * volts + b0; }
};

// Coefficients of the HP devices, as transcribed in wromaszkan/nodeScale.
constexpr std::array<Scaling, 7> kScalings = {{
    {45, 1.00, 1.000, -501.6, 1567, -1619, 566.1, 1.018, -0.3107, 0.1539},
    {32, 0.90, 0.460, -1047, 2982, -2797, 873.5, 0.8367, -0.4341, 0.1701},
    {20, 0.90, 0.210, 0, 34.63, -66.37, 41.15, 0.373, -0.1582, 0.04104},
    {16, 0.85, 0.190, 0, 24.8, -47.52, 28.87, 0.2958, -0.1241, 0.03024},
    {14, 0.80, 0.170, -40.66, 109.2, -100.6, 35.92, 0.2363, -0.09675, 0.02239},
    {10, 0.75, 0.100, -34.95, 93.65, -85.99, 30.4, 0.2068, -0.09311, 0.02375},
    {7, 0.70, 0.059, -28.58, 76.6, -70.26, 24.69, 0.1776, -0.09097, 0.02447},
}};

template <typename Value>
double on_log_line(double nm, Value value) {
  std::size_t i = 0;
  while (i + 2 < kScalings.size() && kScalings[i + 1].nm > nm) ++i;
  const Scaling &a = kScalings[i], &b = kScalings[i + 1];
  const double share = std::log(nm / a.nm) / std::log(b.nm / a.nm);
  const double reference = value(kScalings[0]);
  return std::exp((1.0 - share) * std::log(value(a) / reference) + share * std::log(value(b) / reference));
}

// Operator energies were measured at 1.1 V: energy at 45 nm and 1.1 V relative to the table's 1.0 V.
double energy_at_45nm() {
  const Scaling& s = kScalings[0];
  return ((s.b2 * 1.1 + s.b1) * 1.1 + s.b0) / s.energy();
}

// Measured from 45 nm to 7 nm (Nangate45 and ASAP7): delay only 0.75, energy 0.055 to 0.075. The slow end of a node is
// interpolated logarithmically between 1 and 0.75.
Range delay_of(double nm) {
  const double fast = stillmaker_delay(nm);
  const double slow = std::exp(std::log(0.75) * std::log(nm / 45.0) / std::log(7.0 / 45.0));
  return {std::min(fast, slow), std::sqrt(fast * slow), std::max(fast, slow)};
}

Range energy_of(double nm) {
  if (nm == 45) return Range::exactly(1.0);  // where operators were measured, at 1.1 V
  const double central = stillmaker_energy(nm) / energy_at_45nm();
  return {central, central, nm < 45 ? central * 1.6 : central};
}

Technology make(unsigned nm, double volts, Range um2, char confidence, const char* source) {
  // Leakage: Nangate45 typical 23.8 nW/um^2; ASAP7 1.6 (typical, 25 C) to 21.6 (slow, 100 C). In between: not measured.
  const Range leakage = nm == 45 ? Range{12.0, 23.8, 48.0} : Range{1.6, 6.0, 21.6};
  return {nm, volts, um2, delay_of(nm), energy_of(nm), leakage, source, confidence};
}

const std::vector<Technology>& all() {
  static const std::vector<Technology> technologies = [] {
    const auto scaled = [](double nm) {
      const double um2 = 0.798 * stillmaker_area(nm);
      return Range{0.85 * um2, um2, 1.15 * um2};
    };
    return std::vector<Technology>{
        make(45, 1.1, Range::exactly(0.798), 'A', "NAND2 of the Nangate45 library"),
        make(32, 0.9, scaled(32), 'C', "45 nm times the area factor of Stillmaker and Baas"),
        make(28, 0.9, {0.30, 0.35, 0.40}, 'B', "45 nm x 0.377, and a published TSMC 28 nm chip's gate density"),
        make(22, 0.9, scaled(22), 'C', "45 nm times the interpolated area factor of Stillmaker and Baas"),
        make(16, 0.85, {0.138, 0.145, 0.152}, 'B', "4 transistors at 28.9 MTr/mm2, and 45 nm x 0.19"),
        make(12, 0.80, {0.138, 0.138, 0.152}, 'B', "4 transistors at 28.9 MTr/mm2 (TSMC 16/12), and 45 nm x 0.19"),
        make(7, 0.70, {0.0439, 0.047, 0.058}, 'B', "4 transistors at 91.2 MTr/mm2, 45 nm x 0.059, ASAP7's NAND2"),
        make(5, 0.70, {0.026, 0.0289, 0.036}, 'B', "4 transistors at about 138 MTr/mm2; band as at 7 nm"),
    };
  }();
  return technologies;
}

}  // namespace

double stillmaker_area(double nm) {
  return on_log_line(nm, [](const Scaling& s) { return s.area; });
}
double stillmaker_delay(double nm) {
  return on_log_line(nm, [](const Scaling& s) { return s.delay(); });
}
double stillmaker_energy(double nm) {
  return on_log_line(nm, [](const Scaling& s) { return s.energy(); });
}

const std::vector<unsigned>& technology_nodes() {
  static const std::vector<unsigned> nodes = [] {
    std::vector<unsigned> list;
    for (const Technology& t : all()) list.push_back(t.nm);
    return list;
  }();
  return nodes;
}

const Technology& technology(unsigned nm) {
  for (const Technology& t : all()) {
    if (t.nm == nm) return t;
  }
  throw Error("--node", std::to_string(nm), fmt::format("must be one of {}", fmt::join(technology_nodes(), ", ")));
}

}  // namespace grtx::explore
