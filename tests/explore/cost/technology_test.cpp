// SPDX-License-Identifier: Apache-2.0
// Scaling against the published evaluations, operator coefficients against their bounds, latencies against hand sums.
#include "grtx/explore/cost/technology.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "error_of.h"
#include "grtx/base/error.h"
#include "grtx/explore/cost/operator_cost.h"
#include "grtx/explore/cost/unit_latency.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"

namespace grtx::explore {
namespace {

TEST(Technology, StillmakerAndBaasAtTheirNodes) {
  // Evaluated by hand from the published coefficients, relative to 45 nm at 1.0 V.
  const struct {
    double nm, area, delay, energy;
  } cases[] = {{45, 1, 1, 1},
               {32, 0.46, 0.669, 0.531},
               {20, 0.21, 0.757, 0.233},
               {16, 0.19, 0.512, 0.161},
               {14, 0.17, 0.361, 0.112},
               {10, 0.10, 0.307, 0.082},
               {7, 0.059, 0.259, 0.056}};
  for (const auto& c : cases) {
    EXPECT_NEAR(stillmaker_area(c.nm), c.area, 1e-9) << c.nm;
    EXPECT_NEAR(stillmaker_delay(c.nm), c.delay, 0.006) << c.nm;
    EXPECT_NEAR(stillmaker_energy(c.nm), c.energy, 0.006) << c.nm;
  }
}

TEST(Technology, NodesShrinkAndBandsAreOrdered) {
  const Technology* last = nullptr;
  for (const unsigned nm : technology_nodes()) {
    const Technology& t = technology(nm);
    EXPECT_EQ(t.nm, nm);
    for (const Range& r : {t.um2_per_ge, t.delay, t.energy, t.leakage_nw_per_um2}) {
      EXPECT_GT(r.low, 0.0);
      EXPECT_LE(r.low, r.central);
      EXPECT_LE(r.central, r.high);
    }
    if (last != nullptr) {
      EXPECT_LT(t.um2_per_ge.low, last->um2_per_ge.high) << nm;
      EXPECT_LE(t.energy.central, last->energy.central) << nm;
    }
    last = &t;
  }
  EXPECT_THROW(technology(10), Error);
}

TEST(OperatorCosts, MeasurementsLieInTheirBands) {
  for (const OperatorCost& o : operator_costs()) {
    EXPECT_LE(o.gates.low, o.gates.central) << o.name;
    EXPECT_LE(o.gates.central, o.gates.high) << o.name;
    EXPECT_LE(o.energy_pj.low, o.energy_pj.central) << o.name;
    EXPECT_LE(o.energy_pj.central, o.energy_pj.high) << o.name;
    EXPECT_FALSE(o.source.empty()) << o.name;
    if (o.measured_gates > 0.0) {
      EXPECT_GE(o.measured_gates, o.gates.low) << o.name;
      EXPECT_LE(o.measured_gates, o.gates.high) << o.name;
    }
  }
}

TEST(OperatorCosts, WidthScalesWhatIsBuiltBitByBit) {
  EXPECT_NEAR(operator_cost("int_add", 64).gates.central, 2.0 * operator_cost("int_add", 32).gates.central, 1e-9);
}

TEST(OperatorCosts, AnOperatorOfSomebodysUnitThatHasNoCostIsNamed) {
  const auto fault = [](const std::string& name, unsigned width) {
    return test::error_of([&] { operator_cost(name, width); });
  };
  EXPECT_EQ(fault("fp_add", 16), "inventory: operator fp_add: has a cost of 32 bits, not of 16");
  EXPECT_TRUE(fault("fp_ad", 32).ends_with("not 'fp_ad'; the nearest is 'fp_add'")) << fault("fp_ad", 32);
}

// The rule "sum of operators and flip-flops" against a box unit as synthesised: 51,927 GE, within 9 %.
TEST(OperatorCosts, ABoxUnitSumsUpToWhatWasSynthesised) {
  const double sum = 6 * operator_cost("fp_add", 32).measured_gates + 6 * operator_cost("fp_mul", 32).measured_gates +
                     10 * operator_cost("fp_compare", 32).measured_gates + 1089 * 5.67;
  EXPECT_NEAR(sum, 55700, 100);
  EXPECT_NEAR(sum / 51927, 1.0, 0.09);
}

TEST(UnitLatency, SumsTheStagesOfEachOperator) {
  // ceil(delay x factor / (0.7326 ns - 0.10 ns)) by hand: add 6, mul 5, min/max 2, compare 1 at 45 nm, and so on.
  const struct {
    double factor;
    unsigned box, triangle, sphere, gaussian, transform;
  } cases[] = {
      {1.00, 18, 34, 28, 50, 17}, {0.75, 12, 24, 20, 37, 12}, {0.512, 10, 18, 15, 28, 9}, {0.26, 8, 12, 10, 19, 6}};
  for (const auto& c : cases) {
    const std::map<std::string, unsigned> expected = {{"ray_box", c.box},
                                                      {"ray_triangle", c.triangle},
                                                      {"ray_sphere", c.sphere},
                                                      {"ray_gaussian", c.gaussian},
                                                      {"ray_transform", c.transform}};
    std::size_t checked = 0;
    for (const modules::PartInfo& part : modules::part_table({}, {})) {
      if (!part.pipelines) continue;
      EXPECT_EQ(cycles_needed(part.pipelines->critical_path, c.factor, 1365), expected.at(part.name))
          << part.name << " at " << c.factor;
      ++checked;
    }
    EXPECT_EQ(checked, expected.size());
  }
  EXPECT_THROW(cycles_needed({"add"}, 1.0, 10000), Error);
}

}  // namespace
}  // namespace grtx::explore
