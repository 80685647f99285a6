// SPDX-License-Identifier: Apache-2.0
// The first screen of a run: the answer, the picture, speed-ups with what binds each design, where the bytes went.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "grtx/report/page/charts.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/paper_targets.h"
#include "grtx/report/page/part_bars.h"
#include "grtx/report/page/run_traffic.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

std::string picture_html(const RunResults& run) {
  if (!run.picture.empty()) return picture(picture_uri(run.picture), "The picture as simulated: " + run.label);
  if (run.picture_problem.empty()) return "";
  return "<p class=\"note\">No picture: " + escape(run.picture_problem) + ".</p>\n";
}

/// The paper's speed-up of a design over another; NaN if it has none.
double paper_speedup(const std::string& design, const std::string& over) {
  for (const RunTarget& target : run_targets()) {
    if (target.statistic == "gpu.cycles" && target.of == design && target.over == over) return target.paper;
  }
  return std::nan("");
}

/// How far a design's pictures are from those of the speed-ups' reference, and from the reference in its own order.
std::string picture_cells(const DesignResult& design, const std::string& over) {
  const PictureResult picture = design.picture.value_or(PictureResult());
  return fmt::format(
      "<td class=\"db\" data-what=\"picture against {}:\">{}</td><td class=\"db\" data-what=\"against the "
      "reference:\">{}"
      "</td>",
      escape(over), decibels_text(picture.over), decibels_text(picture.reference));
}

/// Which pictures are bit-identical, by what the others are blended, and what the reference is.
std::string pictures_note(const RunResults& run) {
  std::map<std::string, std::string> by_order;
  std::vector<std::string> orders, traced;
  double pixels = 0.0;
  for (const DesignResult& d : run.designs) {
    if (!d.picture) continue;
    std::string& names = by_order[d.picture->order];
    if (names.empty()) orders.push_back(d.picture->order);
    names += (names.empty() ? "" : ", ") + d.name;
    if (d.picture->fp64) pixels = d.picture->pixels;
    if (!d.picture->fp64) traced.push_back(d.name);
  }
  if (orders.empty()) return "";
  std::string text = "Hits are blended by";
  for (std::size_t i = 0; i < orders.size(); ++i) {
    text += fmt::format("{} {} ({}{})", i == 0 ? "" : ";", orders[i], by_order[orders[i]],
                        by_order[orders[i]].find(',') == std::string::npos ? ""
                        : run.images_identical                             ? ": bit-identical pictures"
                                                                           : ": their pictures should be identical");
  }
  text += ".";
  if (pixels > 0.0) {
    text += fmt::format(" The reference is the fp64 brute force, on {} pixels of each frame.", number(pixels));
  }
  if (!traced.empty()) {
    text += fmt::format(" Of {} it is the tracer at full precision, on whole frames.", fmt::join(traced, ", "));
  }
  return "<p class=\"note\">" + escape(text) + "</p>\n";
}

/// "4.1 ms, 12 Mrays/s, 5.6 mm², 2.1 Mrays/s per mm², 0.9 mJ", for each design: what a ratio does not say. A figure has
/// one unit for all; those of a sequence are means of its frames.
std::vector<std::string> absolute_texts(const ReportRun& run) {
  std::vector<double> seconds, rays, speed, joules;
  std::vector<std::string> area;
  for (std::size_t i = 0; i < run.results.designs.size(); ++i) {
    const DesignResult& design = run.results.designs[i];
    const MachineFigures machine = i < run.machines.size() ? run.machines[i] : MachineFigures();
    const double mm2 = chip_mm2(machine);
    const auto frames = static_cast<double>(design.frames());
    seconds.push_back(design.frame_seconds());
    rays.push_back(design.value("tracer.rays") / frames / seconds.back());
    area.push_back(std::isfinite(mm2) ? number(mm2) + " mm²" : "");
    speed.push_back(rays.back() / mm2);
    joules.push_back(energy_nj(design, machine) * 1e-9 / frames);
  }
  std::vector<std::string> per_mm2 = in_one_unit(speed, "rays/s");
  for (std::string& text : per_mm2) text += text.empty() ? "" : " per mm²";
  const bool sequence = run.results.designs.front().frames() > 1;
  const auto of_a_frame = [sequence](std::vector<std::string> figures) {
    for (std::string& text : figures) text += sequence && !text.empty() ? " a frame" : "";
    return figures;
  };
  std::vector<std::string> texts(seconds.size());
  for (const std::vector<std::string>& figures : {of_a_frame(in_one_unit(seconds, "s")), in_one_unit(rays, "rays/s"),
                                                  area, per_mm2, of_a_frame(in_one_unit(joules, "J"))}) {
    for (std::size_t i = 0; i < texts.size(); ++i) {
      if (!figures[i].empty()) texts[i] += (texts[i].empty() ? "" : ", ") + figures[i];
    }
  }
  return texts;
}

/// Bars of the speed-ups as a table, which needs no script: design, bar and figure, what binds it.
std::string speedups_html(const ReportRun& run) {
  const DesignResult* reference = run.results.design(run.results.speedup_over);
  const double reference_cycles = (reference == nullptr ? fastest(run.results) : *reference).value("gpu.cycles");
  double most = 0.0;
  for (const DesignResult& d : run.results.designs) most = std::max(most, reference_cycles / d.value("gpu.cycles"));
  // A column that no design fills is left out.
  const auto any = [&run](const auto& has) { return std::ranges::any_of(run.results.designs, has); };
  const auto paper_of = [&](const DesignResult& d) {
    return reference == nullptr ? std::nan("") : paper_speedup(d.name, run.results.speedup_over);
  };
  const bool any_paper = any([&](const DesignResult& d) { return std::isfinite(paper_of(d)); });
  const bool any_picture = any([](const DesignResult& d) { return d.picture.has_value(); });
  const bool any_bound = any([](const DesignResult& d) { return !binding_text(d).empty(); });
  bool any_other_k = false;
  const std::vector<std::string> absolute = absolute_texts(run);
  std::string rows;
  for (std::size_t i = 0; i < run.results.designs.size(); ++i) {
    const DesignResult& d = run.results.designs[i];
    const double speedup = reference_cycles / d.value("gpu.cycles");
    const std::string shown = reference == nullptr
                                  ? number(d.value("gpu.cycles")) + interval_html(d.cycles_interval(), number)
                                  : speedup_text(run, d);
    const std::string k = d.subject.setting("k");
    const bool other_k = reference != nullptr && !k.empty() && k != reference->subject.setting("k");
    any_other_k = any_other_k || other_k;
    rows += fmt::format(
        "<tr><th scope=\"row\">{}</th><td><span class=\"speed\" style=\"--share:{:.4f};--own:{}\"></span><span "
        "class=\"figure\">{}</span><span class=\"absolute\">{}</span></td>{}{}{}</tr>\n",
        escape(d.name), most > 0.0 && std::isfinite(speedup) ? speedup / most : 0.0, design_colour(d.name),
        shown + (other_k ? " <span class=\"interval\">at k = " + escape(k) + "</span>" : ""), escape(absolute[i]),
        any_paper ? "<td class=\"n\">" + times(paper_of(d)) + "</td>" : "",
        any_picture ? picture_cells(d, run.results.speedup_over) : "",
        any_bound ? "<td class=\"binds\">" + escape(binding_text(d)) + "</td>" : "");
  }
  const std::string column =
      reference == nullptr ? "cycles"
      : any_other_k        ? fmt::format("speed-up over {} at k = {}", reference->name, reference->subject.setting("k"))
                           : "speed-up";
  const std::string caption = (reference == nullptr ? "Cycles" : "Speed-up over " + reference->name) + " by design" +
                              (any_bound ? ", and what binds it; " : "; ") + run.results.subject.machine_text();
  return fmt::format(
      "<table class=\"speeds\"><caption><span>{}</span></caption>\n<thead><tr><th scope=\"col\">design</th><th "
      "scope=\"col\">{}</th>{}{}{}</tr></thead>\n<tbody>\n{}</tbody></table>\n{}",
      escape(caption), escape(column),
      any_paper ? fmt::format("<th scope=\"col\" class=\"n\">paper's mean, k = {}</th>", paper_k()) : "",
      any_picture ? "<th scope=\"col\" class=\"n\">picture against that of " + escape(run.results.speedup_over) +
                        "</th><th scope=\"col\" class=\"n\">picture against the reference in its order</th>"
                  : "",
      any_bound ? "<th scope=\"col\">what binds it: its largest lower bound, of its cycles</th>" : "", rows,
      pictures_note(run.results));
}

std::string bytes_html(const ReportRun& run, std::size_t index) {
  std::string out;
  for (const auto& [level, id, name] : {std::tuple(MemoryLevel::l2, "l2", "asked of the L2"),
                                        std::tuple(MemoryLevel::dram, "dram", "read from DRAM and written to it")}) {
    std::vector<Bar> bars;
    for (const DesignResult& d : run.results.designs) {
      Bar& bar = bars.emplace_back(Bar{d.name, {}});
      for (std::size_t p = 0; p < kPurposes; ++p) bar.parts.push_back({purpose_name(p), bytes_for(d, level, p)});
    }
    out += bars_chart({fmt::format("bytes{}_{}", index, id), std::string("bytes ") + name, "B", "for",
                       std::string("Where the bytes went: ") + name + "."},
                      bars);
  }
  return out.empty() ? "" : "<div class=\"pair\">" + out + "</div>\n";
}

/// Further lines worth reading: rays that end early, identical images, violated laws.
std::string asides_html(const RunResults& run) {
  const DesignResult& first = run.designs.front();  // all trace the same rays
  std::string text;
  const auto add = [&text](const std::string& words) { text += (text.empty() ? "" : " · ") + words; };
  if (const double share = first.value("tracer.ert_share"); std::isfinite(share)) {
    add(fmt::format("{:.1f} % of the rays end early", 100.0 * share));
  }
  if (const double behind = first.value("tracer.hits_behind_end"); std::isfinite(behind)) {
    add(times(behind) + " as many hits as are processed");
  }
  for (const auto& [name, why] : run.left_out) add(escape(name + " is left out: " + why));
  if (run.has_verdict) {
    if (!run.images_identical) add("<strong>IMAGES DIFFER</strong>");
    add(run.violations.empty() ? "no law of the model is violated"
                               : fmt::format("<strong>{} violated laws</strong>", run.violations.size()));
  }
  return text.empty() ? "" : "<p class=\"note\">" + text + ".</p>\n";
}

}  // namespace

std::string picture(const std::string& uri, const std::string& caption) {
  return fmt::format("<figure class=\"picture\"><img src=\"{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n", uri,
                     escape(caption), escape(caption));
}

std::string headline(const std::string& value_html, const std::string& what, const std::string& note) {
  return fmt::format("<div class=\"card\"><dt>{}</dt><dd>{}</dd>{}</div>\n", escape(what), value_html,
                     note.empty() ? "" : "<dd class=\"note\">" + breakable(note) + "</dd>");
}

std::string run_headline(const ReportRun& run, std::size_t index) {
  const std::string name = run.name.empty() ? "" : "<h3>" + escape(run.name) + "</h3>\n";
  return name + run_answer(run) + "<div class=\"first\">\n" + picture_html(run.results) + "<div>" + speedups_html(run) +
         "</div></div>\n" + bytes_html(run, index) + run_verdict(run) + asides_html(run.results) +
         subject_html(run, true);
}

}  // namespace grtx::report
