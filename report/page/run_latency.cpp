// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/run_latency.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "grtx/modules/cache/request_stages.h"
#include "grtx/report/page/html.h"

namespace grtx::report {
namespace {

using modules::MemoryStage;
using modules::ReadKind;

std::string words_of(MemoryStage stage) {
  switch (stage) {
    case MemoryStage::l1:
      return "L1";
    case MemoryStage::l2:
      return "L2";
    case MemoryStage::dram:
      return "DRAM";
    case MemoryStage::queue:
    case MemoryStage::crossbar:
      break;
  }
  return std::string(name_of(stage));
}

std::string statistic_of(ReadKind kind, const std::string& what) {
  return fmt::format("gpu.latency.{}.{}", name_of(kind), what);
}

}  // namespace

std::vector<Part> node_read_levels(const DesignResult& design) {
  std::vector<Part> parts;
  double sum = 0.0;
  for (std::size_t stage = 0; stage < modules::kStages; ++stage) {
    Part part{words_of(static_cast<MemoryStage>(stage)), 0.0};
    for (const ReadKind kind : {ReadKind::nodes, ReadKind::leaves}) {
      const double reads = design.value(statistic_of(kind, "reads"));
      const double mean = design.value(statistic_of(kind, std::string(name_at<MemoryStage>(stage))));
      if (std::isfinite(reads * mean)) part.value += reads * mean;
    }
    sum += part.value;
    parts.push_back(part);
  }
  if (!(sum > 0.0)) return {};
  for (Part& part : parts) part.value /= sum;
  return parts;
}

std::string node_read_levels_text(const DesignResult& design) {
  std::vector<Part> parts = node_read_levels(design);
  std::ranges::stable_sort(parts, [](const Part& a, const Part& b) { return a.value > b.value; });
  std::string text;
  for (const Part& part : parts) {
    if (part.value < 0.005) continue;
    text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", part.name, 100.0 * part.value);
  }
  return text;
}

std::string read_latency_html(const std::vector<DesignResult>& designs, const std::string& caption) {
  std::vector<Table::Column> columns = {{"design", false}, {"reads for", false}, {"reads"}, {"mean, p95"}};
  for (std::size_t stage = 0; stage < modules::kStages; ++stage) {
    columns.push_back({words_of(static_cast<MemoryStage>(stage))});
  }
  Table table(caption, columns);
  for (const DesignResult& design : designs) {
    for (std::size_t k = 0; k < modules::kReadKinds; ++k) {
      const auto kind = static_cast<ReadKind>(k);
      if (!std::isfinite(design.value(statistic_of(kind, "reads")))) continue;
      const auto both = [&](const std::string& what) {
        return fmt::format("{:.1f}, {}", design.value(statistic_of(kind, what)),
                           number(design.value(statistic_of(kind, what + "_p95"))));
      };
      std::vector<std::string> cells = {escape(design.name), std::string(name_of(kind)),
                                        number(design.value(statistic_of(kind, "reads"))), both("whole")};
      for (std::size_t stage = 0; stage < modules::kStages; ++stage) {
        cells.push_back(both(std::string(name_at<MemoryStage>(stage))));
      }
      table.row(cells);
    }
  }
  return table.rows() == 0 ? "" : table.html();
}

}  // namespace grtx::report
