// SPDX-License-Identifier: Apache-2.0
// A kernel with another time resolution than 1 fs gave wrong cycles without a word.
#include <gmock/gmock.h>

#include "error_of.h"
#include "grtx/base/error.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

TEST(TimeResolution, OtherThanOneFemtosecondIsAnErrorAndNotWrongCycles) {
  const auto with = [](double value, sc_core::sc_time_unit unit) -> std::string {
    sc_core::sc_curr_simcontext = new sc_core::sc_simcontext;
    sc_core::sc_default_global_context = sc_core::sc_curr_simcontext;
    sc_core::sc_set_time_resolution(value, unit);
    return grtx::test::error_of([&] { const ClockDomain clock("core_clock", 1365.0); });
  };
  EXPECT_EQ(with(1, sc_core::SC_FS), "");
  for (const auto& [value, unit, name] :
       {std::tuple(1.0, sc_core::SC_PS, "1 ps"), {10.0, sc_core::SC_FS, "10 fs"}, {1.0, sc_core::SC_NS, "1 ns"}}) {
    EXPECT_THAT(with(value, unit), ::testing::HasSubstr("clock domain core_clock: needs a time resolution of 1 fs"));
    EXPECT_THAT(with(value, unit), ::testing::HasSubstr(std::string("not ") + name));
  }
}

}  // namespace
}  // namespace grtx::modules
