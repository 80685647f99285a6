// SPDX-License-Identifier: Apache-2.0
// The answer of a run in sentences: which design wins, by how much, what binds it, and why it wins.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string_view>

#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/launch_size.h"
#include "grtx/report/page/run_latency.h"
#include "grtx/report/page/run_traffic.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/speedup_terms.h"

namespace grtx::report {
namespace {

/// Readable name of a lower bound.
std::string words_of_bound(std::string_view bound) {
  constexpr std::array<std::pair<std::string_view, const char*>, 7> kWords = {
      {{"l1_port", "the ports of the L1"},
       {"l1_miss_port", "the port of the L1 to its misses"},
       {"l2_port", "the ports of the L2"},
       {"dram_bandwidth", "the bandwidth of the DRAM"},
       {"simt_issue", "the issue of shader instructions"},
       {"longest_ray", "the longest ray"},
       {"longest_warp", "the longest warp"}}};
  for (const auto& [name, words] : kWords) {
    if (bound == name) return words;
  }
  for (const modules::PartInfo& part : modules::part_table({}, {})) {
    for (const modules::PartBound& of : part.bounds) {
      if (bound == of.name) return of.words;
    }
  }
  return std::string(bound);
}

std::string words_of_stall(std::string_view stall) {
  for (const modules::PartInfo& part : modules::part_table({}, {})) {
    for (const modules::StallWords& of : part.stalls) {
      if (stall == of.stall) return of.words;
    }
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

/// "3.0", "112": a factor in plain digits.
std::string factor(double ratio) { return ratio < 9.95 ? fmt::format("{:.1f}", ratio) : number(std::round(ratio)); }

/// Share of the run in which the slowest traceRay call of a warp was under way; NaN if not recorded. Of a sequence at
/// least that of the frame of the call: it is over the longest.
double longest_call_share(const DesignResult& design) {
  const std::size_t frames = design.frames();
  double cycles = frames == 1 ? design.value("gpu.cycles") : 0.0;
  for (std::size_t i = 0; frames > 1 && i < frames; ++i) {
    cycles = std::max(cycles, design.value(fmt::format("gpu.frame{}.cycles", i)));
  }
  return design.value("gpu.rt.warp_latency_max") / cycles;
}

/// Whether a single warp takes most of the run, and more than any bound explains: then latency binds, and no resource.
bool latency_binds(const DesignResult& design) {
  constexpr double kMost = 0.5;
  const double share = longest_call_share(design), bound = design.value("gpu.bound.fraction");
  return share >= kMost && share <= 1.0 && !(bound >= share);
}

std::string latency_text(const DesignResult& design) {
  return fmt::format("latency: the slowest call of a warp is {:.0f} % of {}", 100.0 * longest_call_share(design),
                     design.frames() == 1 ? "the run" : "its frame or more");
}

/// ", most of it by waits of shaders for memory (26.36×) and visits (1.42×)": the largest terms of a speed-up; "" if
/// they are not recorded.
std::string largest_terms(const DesignResult& over, const DesignResult& design) {
  constexpr std::size_t kMost = 2;
  std::vector<SpeedupTerm> terms = speedup_terms(over, design);
  std::ranges::stable_sort(terms, std::greater(), &SpeedupTerm::factor);
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, terms.size()); ++i) {
    if (terms[i].factor < 1.05) continue;
    text +=
        fmt::format("{}{} ({})", text.empty() ? ", most of it by " : " and ", terms[i].name, times(terms[i].factor));
  }
  return text;
}

/// "Of the 3.22 ms of baseline shading takes 2.10 ms and traversal 1.12 ms, of the 0.135 ms of walk 0.02 and 0.11. ":
/// in what part of the time a speed-up lies, and where each design has its hits.
std::string parts_of_time(const DesignResult& over, const DesignResult& design) {
  const double all = over.frame_seconds(), own = design.frame_seconds();
  const double before = traversal_share(over), after = traversal_share(design);
  if (!std::isfinite(all * own * before * after)) return "";
  const std::vector<std::string> ms =
      in_one_unit({all, all * (1.0 - before), all * before, own, own * (1.0 - after), own * after}, "s");
  std::string text =
      fmt::format("Of the {}{} of {} shading takes {} and traversal {}; of the {} of {}, {} and {}. ", ms[0],
                  over.frames() == 1 ? "" : " a frame", over.name, ms[1], ms[2], ms[3], design.name, ms[4], ms[5]);
  const auto in_registers = [](const DesignResult& one) {
    const auto unit = one.config.find("rt.any_hit_unit.enabled");
    return unit != one.config.end() && (*unit == true || *unit == "true");
  };
  if (in_registers(design) && !in_registers(over)) {
    text += fmt::format("{} keeps its hits in k-buffers in memory, {} in heaps in registers. ", over.name, design.name);
  }
  return text;
}

/// "fetches 3.0 times fewer nodes": ratios of reference to design that differ from 1 by more than 5 %.
std::string reasons(const DesignResult& reference, const DesignResult& design) {
  std::vector<std::string> list;
  const auto ratio = [&](const char* name) {
    const double own = design.value(name);
    return own > 0.0 ? reference.value(name) / own : 0.0;  // "infinitely fewer" says nothing
  };
  if (const double r = ratio("gpu.rt.node_fetches"); r > 1.05) {
    list.push_back("fetches " + factor(r) + " times fewer nodes");
  }
  if (const double r = ratio("gpu.rt.node_fetch_latency"); r > 1.05) {
    list.push_back("waits " + factor(r) + " times shorter for a node");
  }
  const double before = reference.value("gpu.l1.node.hit_rate"), after = design.value("gpu.l1.node.hit_rate");
  if (after - before > 0.01) {
    list.push_back(fmt::format("finds {:.0f} % of its nodes in the L1 ({} {:.0f} %)", 100.0 * after, reference.name,
                               100.0 * before));
  }
  if (const double r = ratio("gpu.dram.bytes"); r > 1.05) {
    list.push_back("moves " + factor(r) + " times fewer bytes to and from the DRAM");
  }
  std::string text;
  for (std::size_t i = 0; i < list.size(); ++i) text += (i == 0 ? "" : i + 1 == list.size() ? " and " : ", ") + list[i];
  return text;
}

/// How the fastest design's pictures differ; "" if its pictures are those of the reference, or not recorded.
std::string other_picture(const DesignResult& design, const std::string& reference) {
  if (!design.picture || design.picture->over.empty()) return "";
  if (std::isinf(*std::min_element(design.picture->over.begin(), design.picture->over.end()))) return "";
  return fmt::format(", and draws another picture, {} from that of {}", decibels_text(design.picture->over), reference);
}

}  // namespace

std::string decibels_text(const std::vector<double>& frames) {
  if (frames.empty()) return "";
  const auto [least, most] = std::minmax_element(frames.begin(), frames.end());
  const auto shown = [](double psnr) { return std::isinf(psnr) ? "identical" : fmt::format("{:.1f} dB", psnr); };
  return *least == *most ? shown(*least) : shown(*least) + " to " + shown(*most);
}

std::string binding_text(const DesignResult& design) {
  const double fraction = design.value("gpu.bound.fraction");
  if (latency_binds(design)) return latency_text(design);
  if (design.binding_bound.empty() || !std::isfinite(fraction)) return "";
  return fmt::format("{}, {:.0f} %", words_of_bound(design.binding_bound), 100.0 * fraction);
}

std::string speedup_text(const ReportRun& run, const DesignResult& design) {
  const DesignResult* reference = run.results.design(run.results.speedup_over);
  if (reference == nullptr) return "";
  return times(reference->value("gpu.cycles") / design.value("gpu.cycles")) +
         interval_html(run.results.speedup_interval(design), times);
}

const DesignResult& fastest(const RunResults& run) {
  const auto faster = [](const DesignResult& a, const DesignResult& b) {
    return a.value("gpu.cycles") < b.value("gpu.cycles");
  };
  return *std::min_element(run.designs.begin(), run.designs.end(), faster);
}

const DesignResult* next_to(const DesignResult& best, const RunResults& run) {
  const DesignResult* next = nullptr;
  for (const DesignResult& design : run.designs) {
    if (&design == &best) continue;
    if (next == nullptr || design.value("gpu.cycles") < next->value("gpu.cycles")) next = &design;
  }
  return next;
}

std::string run_answer(const ReportRun& run) {
  const DesignResult* reference = run.results.design(run.results.speedup_over);
  const DesignResult& best = fastest(run.results);
  const bool several = run.results.designs.size() > 1;
  std::string text;
  if (several) {
    text += fmt::format("<strong>{} is fastest</strong>", escape(best.name));
    if (reference != nullptr && reference != &best) {
      text += fmt::format(", <strong>{:.2f} times as fast as {}</strong>",
                          reference->value("gpu.cycles") / best.value("gpu.cycles"), escape(reference->name)) +
              interval_html(run.results.speedup_interval(best), times);
      text += escape(largest_terms(*reference, best)) + escape(other_picture(best, reference->name));
    }
    if (const DesignResult* next = next_to(best, run.results); next != nullptr && next != reference) {
      text += fmt::format("; and {:.2f} times as fast as {}, the next{}",
                          next->value("gpu.cycles") / best.value("gpu.cycles"), escape(next->name),
                          escape(largest_terms(*next, best)));
    }
    text += ". ";
  } else {
    const double seconds = best.value("gpu.time_us") * 1e-6;
    text += fmt::format("{} takes <strong>{}{} cycles</strong>{}. ", escape(best.name),
                        std::isfinite(seconds) ? with_unit(seconds, "s") + ", " : "", number(best.value("gpu.cycles")),
                        interval_html(best.cycles_interval(), number));
  }
  const double fraction = best.value("gpu.bound.fraction");
  if (latency_binds(best)) {
    text += fmt::format("What binds {} most is <strong>{}</strong>", several ? escape(best.name) : "it",
                        latency_text(best));
    if (std::isfinite(fraction) && !best.binding_bound.empty()) {
      text += fmt::format("; of its resources {}, at {:.0f} %", escape(words_of_bound(best.binding_bound)),
                          100.0 * fraction);
    }
    text += ".";
  } else if (std::isfinite(fraction) && fraction < 0.5 && !best.binding_bound.empty()) {
    text += fmt::format(
        "No resource binds {} for half of its cycles: the largest lower bound, <strong>{}</strong>, is "
        "{:.0f} % of them.",
        several ? escape(best.name) : "it", escape(words_of_bound(best.binding_bound)), 100.0 * fraction);
  } else if (std::isfinite(fraction) && !best.binding_bound.empty()) {
    text +=
        fmt::format("What binds {} most is <strong>{}</strong>: it alone takes {:.0f} % of the cycles.",
                    several ? escape(best.name) : "it", escape(words_of_bound(best.binding_bound)), 100.0 * fraction);
  }
  if (const std::string small = too_small_text(launch_sizes(run.results), several ? "designs" : "with another run");
      !small.empty()) {
    text += fmt::format(" <strong class=\"bad\">Mind: {}.</strong>", escape(small));
  }
  return text.empty() ? "" : "<p class=\"answer\">" + text + "</p>\n";
}

std::string run_verdict(const ReportRun& run) {
  const DesignResult* reference = run.results.design(run.results.speedup_over);
  const DesignResult& best = fastest(run.results);
  const std::string whose = run.results.designs.size() > 1 ? escape(best.name) : "it";
  std::string text;
  if (reference != nullptr && reference != &best) {
    text += escape(parts_of_time(*reference, best));
    if (const std::string why = reasons(*reference, best); !why.empty()) {
      text += fmt::format("Against {}, {} {}. ", escape(reference->name), whose, escape(why));
    }
  }
  if (const double all = bytes_for_all(best, MemoryLevel::l2); all > 0.0) {
    std::string shares;
    for (std::size_t purpose = 0; purpose < kPurposes; ++purpose) {
      const double share = bytes_for(best, MemoryLevel::l2, purpose) / all;
      if (share < 0.005) continue;
      shares += fmt::format("{}{:.0f} % {}", shares.empty() ? "" : ", ", 100.0 * share, purpose_name(purpose));
    }
    text += fmt::format("It asks the L2 for {}: {}. ", with_unit(all, "B"), shares);
  }
  if (const auto traffic = run.results.config.find("rt.checkpoint.traffic");
      traffic != run.results.config.end() && *traffic == "uncharged") {
    text += "On this machine checkpoint traffic is free: its bytes are not counted. ";
  }
  if (const auto [stall, share] = largest_stall(best); !stall.empty() && std::isfinite(share)) {
    const std::string levels = stall == "memory" ? node_read_levels_text(best) : "";
    text += fmt::format("Its RT units wait mostly for {} ({:.0f} % of their cycles{}).", escape(words_of_stall(stall)),
                        100.0 * share, levels.empty() ? "" : "; of a read's time " + levels);
  }
  return text.empty() ? "" : "<p class=\"verdict\">" + text + "</p>\n";
}

}  // namespace grtx::report
