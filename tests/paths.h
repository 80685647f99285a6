// SPDX-License-Identifier: Apache-2.0
// Where the tests find the source tree and the programs they run. One file knows, so that a compiler cache can serve
// the others in any folder.
#pragma once

#include <string>

namespace grtx::paths {

std::string source_dir();      ///< the checkout
std::string program();         ///< grtx
std::string own_dram();        ///< examples/own_dram
std::string own_regression();  ///< examples/own_regression
std::string own_experiment();  ///< examples/own_experiment
std::string own_unit();        ///< examples/own_unit
std::string own_policy();      ///< examples/own_policy
std::string platform();        ///< examples/platform
std::string own_rtl();         ///< examples/own_rtl; empty: no Verilator
std::string charts_folder();   ///< the chart library as it was fetched; empty: built without charts

}  // namespace grtx::paths
