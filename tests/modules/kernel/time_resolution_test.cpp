// SPDX-License-Identifier: Apache-2.0
// A kernel with a time resolution that the clocks do not have gave wrong cycles without a word.
#include <gmock/gmock.h>

#include <string>

#include "error_of.h"
#include "grtx/base/error.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

std::string error_with(double value, sc_core::sc_time_unit unit, double mhz) {
  sc_core::sc_curr_simcontext = new sc_core::sc_simcontext;
  sc_core::sc_default_global_context = sc_core::sc_curr_simcontext;
  sc_core::sc_set_time_resolution(value, unit);
  return grtx::test::error_of([&] { const ClockDomain clock("core_clock", mhz); });
}

TEST(TimeResolution, OneThatDoesNotDivideTheClockIsAnErrorAndNotWrongCycles) {
  EXPECT_EQ(error_with(1, sc_core::SC_FS, 1365.0), "");
  struct Case {
    double value;
    sc_core::sc_time_unit unit;
    const char* name;
    double choose;  ///< in MHz, as the message has it
  };
  for (const Case& c : {Case{1.0, sc_core::SC_PS, "1 ps", 1364.256480},
                        Case{10.0, sc_core::SC_FS, "10 fs", 1365.001365}, Case{1.0, sc_core::SC_NS, "1 ns", 500.0}}) {
    const std::string error = error_with(c.value, c.unit, 1365.0);
    EXPECT_THAT(error,
                ::testing::HasSubstr("clock domain core_clock: the period of 1365 MHz, 732601 fs, is no multiple "
                                     "of the time resolution, " +
                                     std::string(c.name)));
    const std::size_t at = error.find("or choose ");
    ASSERT_NE(at, std::string::npos) << error;
    const double chosen = std::stod(error.substr(at + 10));
    EXPECT_NEAR(chosen, c.choose, 1e-5);
    EXPECT_EQ(error_with(c.value, c.unit, chosen), "");
  }
  EXPECT_NE(error_with(1.0, sc_core::SC_NS, 1000.0), "") << "nothing lies between two edges";
}

}  // namespace
}  // namespace grtx::modules
