// Files that the build links into the program: what a report's page is made of besides its content.
#pragma once

#include <string_view>

namespace grtx::sim {

/// vega, vega-lite and vega-embed, minified, with their licences; empty in a build with GRTX_REPORT_CHARTS=OFF.
std::string_view chart_library();
std::string_view page_style();
std::string_view page_script();
/// paper_targets.toml
std::string_view paper_targets_text();

}  // namespace grtx::sim
