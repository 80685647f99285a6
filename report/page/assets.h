// SPDX-License-Identifier: Apache-2.0
// Styles, scripts and data files that the build links into the program.
#pragma once

#include <string_view>

namespace grtx::report {

/// vega, vega-lite and vega-embed, minified, with their licences; empty in a build with GRTX_REPORT_CHARTS=OFF.
std::string_view chart_library();
std::string_view page_style();
std::string_view page_script();
/// Additional script for pages with charts, to be loaded first.
std::string_view export_script();
/// Additional scripts for explorers of points, to be loaded in this order.
std::string_view explore_charts_script();
std::string_view explore_script();
/// Additional style and script for the page of grtx ray.
std::string_view ray_style();
std::string_view ray_script();
/// paper_targets.toml
std::string_view paper_targets_text();

}  // namespace grtx::report
