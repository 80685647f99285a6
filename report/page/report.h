// SPDX-License-Identifier: Apache-2.0
// grtx report: one self-contained HTML file. The same inputs give the same bytes.
#pragma once

#include <string>
#include <vector>

namespace grtx::report {

struct ReportOptions {
  std::vector<std::string> inputs;  ///< sweep databases, results.json of grtx run, statistics of grtx sim
  std::vector<std::string> images;  ///< pictures to show: PNG, JPEG, GIF or WebP
  std::string title = "GRTX-TLM report";
};

/// Returns the HTML page. Throws Error for inputs of another kind.
std::string report_page(const ReportOptions& options);

}  // namespace grtx::report
