// SPDX-License-Identifier: Apache-2.0
// Summary of a run: which design wins and why, its memory traffic, and its bottleneck.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/view/report/html.h"
#include "grtx/view/report/sections.h"

namespace grtx::view {
namespace {

using modules::Region;

struct Share {
  const char* title;
  std::vector<Region> regions;
};
const std::array<Share, 4>& shares() {
  static const std::array<Share, 4> list = {
      Share{"nodes", {Region::tlas, Region::blas, Region::leaf, Region::instance}},
      Share{"checkpoints", {Region::checkpoint}},
      Share{"k-buffers, evictions, stacks", {Region::k_buffer, Region::eviction, Region::stack}},
      Share{"Gaussians, colours, rays", {Region::gaussian, Region::sh, Region::ray}}};
  return list;
}

struct Level {
  const char* title;
  std::array<const char*, 2> counters;  // reads and writes of a region, in sectors
};
constexpr std::array<Level, 2> kLevels = {Level{"L2", {"gpu.l2.{}.reads", "gpu.l2.{}.writes"}},
                                          Level{"DRAM", {"gpu.l2.dram_reads.{}", "gpu.l2.dram_writes.{}"}}};

double megabytes(const DesignResult& design, const Level& level, const std::vector<Region>& regions) {
  double sectors = 0.0;
  for (const Region region : regions) {
    for (const char* counter : level.counters) {
      const double value = design.value(fmt::format(fmt::runtime(counter), name_of(region)));
      sectors += std::isfinite(value) ? value : 0.0;  // a region without accesses has no counter
    }
  }
  return sectors * static_cast<double>(modules::kSectorBytes) * 1e-6;
}

/// Readable name of a lower bound.
std::string words_of_bound(std::string_view bound) {
  constexpr std::array<std::pair<std::string_view, const char*>, 9> kWords = {
      {{"rt_port", "the port of the RT units to the L1"},
       {"l1_port", "the ports of the L1"},
       {"l1_miss_port", "the port of the L1 to its misses"},
       {"l2_port", "the ports of the L2"},
       {"dram_bandwidth", "the bandwidth of the DRAM"},
       {"issue", "the issue of the RT units, a warp a cycle"},
       {"simt_issue", "the issue of shader instructions"},
       {"longest_ray", "the longest ray"},
       {"longest_warp", "the longest warp"}}};
  for (const auto& [name, words] : kWords) {
    if (bound == name) return words;
  }
  return std::string(bound);
}

std::string words_of_stall(std::string_view stall) {
  constexpr std::array<std::pair<std::string_view, const char*>, 8> kWords = {{{"memory", "nodes under way"},
                                                                               {"queue_full", "their port to the L1"},
                                                                               {"checkpoint", "checkpoint entries"},
                                                                               {"any_hit", "any-hit shaders"},
                                                                               {"unit", "intersection units"},
                                                                               {"stack", "stack entries"},
                                                                               {"retire", "the end of a warp's rays"},
                                                                               {"empty", "a warp"}}};
  for (const auto& [name, words] : kWords) {
    if (stall == name) return words;
  }
  return std::string(stall);
}

/// Main stall reason, e.g. "memory", with its share of all RT unit cycles; "" if not recorded.
std::pair<std::string, double> largest_stall(const DesignResult& design) {
  constexpr std::string_view kPrefix = "gpu.rt.stall.";
  std::pair<std::string, double> largest;
  double sum = design.value("gpu.rt.selections");
  for (const auto& [name, entry] : design.statistics.items()) {
    if (!name.starts_with(kPrefix) || name.find('.', kPrefix.size()) != std::string::npos) continue;
    const double value = design.value(name);
    sum += value;
    if (value > largest.second) largest = {name.substr(kPrefix.size()), value};
  }
  largest.second /= sum;
  return largest;
}

/// "fetches 3.0 times fewer nodes": ratios of reference to design that differ from 1 by more than 5 %.
std::string reasons(const DesignResult& reference, const DesignResult& design) {
  std::vector<std::string> list;
  const auto ratio = [&](const char* name) { return reference.value(name) / design.value(name); };
  if (const double r = ratio("gpu.rt.node_fetches"); r > 1.05) {
    list.push_back(fmt::format("fetches {:.2g} times fewer nodes", r));
  }
  if (const double r = ratio("gpu.rt.node_fetch_latency"); r > 1.05) {
    list.push_back(fmt::format("waits {:.2g} times shorter for a node", r));
  }
  const double before = reference.value("gpu.l1.node.hit_rate"), after = design.value("gpu.l1.node.hit_rate");
  if (after - before > 0.01) {
    list.push_back(fmt::format("finds {:.0f} % of its nodes in the L1 ({} {:.0f} %)", 100.0 * after, reference.name,
                               100.0 * before));
  }
  if (const double r = ratio("gpu.dram.bytes"); r > 1.05) {
    list.push_back(fmt::format("moves {:.2g} times fewer bytes to and from the DRAM", r));
  }
  std::string text;
  for (std::size_t i = 0; i < list.size(); ++i) text += (i == 0 ? "" : i + 1 == list.size() ? " and " : ", ") + list[i];
  return text;
}

}  // namespace

std::string run_verdict(const ReportRun& run) {
  const DesignResult* reference = run.results.design(run.results.speedup_over);
  const DesignResult* best = &run.results.designs.front();
  for (const DesignResult& d : run.results.designs) {
    if (d.value("gpu.cycles") < best->value("gpu.cycles")) best = &d;
  }
  std::string text;
  if (run.results.designs.size() > 1) {
    text += fmt::format("<strong>{} is fastest</strong>", escape(best->name));
    if (reference != nullptr && reference != best) {
      text += fmt::format(", {:.2f} times as fast as {}", reference->value("gpu.cycles") / best->value("gpu.cycles"),
                          escape(reference->name)) +
              interval_html(run.results.speedup_interval(*best), times);
      const std::string why = reasons(*reference, *best);
      if (!why.empty()) text += ": it " + escape(why);
    }
    text += ". ";
  }
  const std::string whose = run.results.designs.size() > 1 ? escape(best->name) : "It";
  double all = 0.0;
  for (const Share& share : shares()) all += megabytes(*best, kLevels[0], share.regions);
  if (all > 0.0) {
    const double checkpoints = megabytes(*best, kLevels[0], shares()[1].regions);
    text += fmt::format("Of the {} MB that {} asks of the L2, {:.0f} % are nodes and {:.0f} % checkpoints. ",
                        number(all), run.results.designs.size() > 1 ? whose : "it",
                        100.0 * megabytes(*best, kLevels[0], shares()[0].regions) / all, 100.0 * checkpoints / all);
  }
  if (const auto traffic = run.results.config.find("rt.checkpoint.traffic");
      traffic != run.results.config.end() && *traffic == "uncharged") {
    text += "On this machine checkpoint traffic is free: its bytes are not counted. ";
  }
  if (const double fraction = best->value("gpu.bound.fraction");
      std::isfinite(fraction) && !best->binding_bound.empty()) {
    text += fmt::format("What binds {} most is {}: it alone takes {:.0f} % of the cycles. ",
                        run.results.designs.size() > 1 ? whose : "it", escape(words_of_bound(best->binding_bound)),
                        100.0 * fraction);
  }
  if (const auto [stall, share] = largest_stall(*best); !stall.empty() && std::isfinite(share)) {
    text += fmt::format("Its RT units wait mostly for {} ({:.0f} % of their cycles).", escape(words_of_stall(stall)),
                        100.0 * share);
  }
  return text.empty() ? "" : "<p class=\"verdict\">" + text + "</p>\n";
}

std::string bytes_table(const ReportRun& run) {
  std::vector<Table::Column> columns = {{"design", false}};
  for (const Level& level : kLevels) {
    for (const Share& share : shares()) columns.push_back({std::string(level.title) + ": " + share.title});
  }
  Table table(run.results.label + ": where the bytes went, MB read and written", columns);
  double all = 0.0;
  for (const DesignResult& d : run.results.designs) {
    std::vector<std::string> cells = {escape(d.name)};
    for (const Level& level : kLevels) {
      for (const Share& share : shares()) {
        const double own = megabytes(d, level, share.regions);
        all += own;
        cells.push_back(number(own));
      }
    }
    table.row(cells);
  }
  return all > 0.0 ? table.html() : "";
}

}  // namespace grtx::view
