// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/assets.h"

// Start and end of each file, defined in report_assets.S.
extern "C" {
extern const char grtx_asset_charts[], grtx_asset_charts_end[];
extern const char grtx_asset_style[], grtx_asset_style_end[];
extern const char grtx_asset_script[], grtx_asset_script_end[];
extern const char grtx_asset_export[], grtx_asset_export_end[];
extern const char grtx_asset_explore[], grtx_asset_explore_end[];
extern const char grtx_asset_explorecharts[], grtx_asset_explorecharts_end[];
extern const char grtx_asset_raystyle[], grtx_asset_raystyle_end[];
extern const char grtx_asset_rayscript[], grtx_asset_rayscript_end[];
extern const char grtx_asset_paper[], grtx_asset_paper_end[];
}

namespace grtx::report {

std::string_view chart_library() { return {grtx_asset_charts, grtx_asset_charts_end}; }
std::string_view page_style() { return {grtx_asset_style, grtx_asset_style_end}; }
std::string_view page_script() { return {grtx_asset_script, grtx_asset_script_end}; }
std::string_view export_script() { return {grtx_asset_export, grtx_asset_export_end}; }
std::string_view explore_charts_script() { return {grtx_asset_explorecharts, grtx_asset_explorecharts_end}; }
std::string_view explore_script() { return {grtx_asset_explore, grtx_asset_explore_end}; }
std::string_view ray_style() { return {grtx_asset_raystyle, grtx_asset_raystyle_end}; }
std::string_view ray_script() { return {grtx_asset_rayscript, grtx_asset_rayscript_end}; }
std::string_view paper_targets_text() { return {grtx_asset_paper, grtx_asset_paper_end}; }

}  // namespace grtx::report
