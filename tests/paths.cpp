// SPDX-License-Identifier: Apache-2.0
#include "paths.h"

namespace grtx::paths {

std::string source_dir() { return GRTX_SOURCE_DIR; }
std::string program() { return GRTX_PROGRAM; }
std::string own_dram() { return GRTX_OWN_DRAM; }
std::string own_regression() { return GRTX_OWN_REGRESSION; }
std::string own_experiment() { return GRTX_OWN_STUDY; }
std::string own_unit() { return GRTX_OWN_UNIT; }
std::string own_policy() { return GRTX_OWN_POLICY; }
std::string platform() { return GRTX_PLATFORM; }
std::string own_rtl() { return GRTX_OWN_RTL; }
std::string charts_folder() { return GRTX_CHARTS_FOLDER; }

}  // namespace grtx::paths
