// SPDX-License-Identifier: Apache-2.0
// Table of points in a sweep's database that are not in its plan.
#include <fmt/format.h>

#include "grtx/explore/sweep/axis.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {

std::string earlier_table(const SweepResults& results) {
  Table table(results.file + ": points of an earlier plan, which nothing above compares or counts",
              {{"point"},
               {"machine", false},
               {"mode", false},
               {"scene", false},
               {"design", false},
               {"coordinates", false},
               {"status", false},
               {"time, µs"}});
  for (const ReportedPoint& p : results.earlier) {
    std::string coordinates;
    for (const auto& [name, value] : p.coordinates.items()) {
      coordinates += (coordinates.empty() ? "" : ", ") + name + " = " + explore::text_of(value);
    }
    table.row({fmt::format("#{}", p.id), escape(p.machine), escape(p.mode), escape(p.scene), escape(p.design),
               escape(coordinates), escape(p.status), number(p.value(kTime))});
  }
  const std::string summary =
      fmt::format("{} {} of an earlier plan", table.rows(), table.rows() == 1 ? "point" : "points");
  return table.rows() == 0 ? "" : details(summary, table.html());
}

}  // namespace grtx::report
