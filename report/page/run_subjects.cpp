// SPDX-License-Identifier: Apache-2.0
// Describes what the results of runs refer to, and their limitations; used by every section with results.
#include <fmt/format.h>

#include <algorithm>

#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

std::vector<Subject> subjects_of(const std::vector<ReportRun>& runs) {
  std::vector<Subject> subjects;
  subjects.reserve(runs.size());
  for (const ReportRun& run : runs) subjects.push_back(run.results.subject);
  return subjects;
}

std::string joined_designs(const RunResults& results) {
  std::string names;
  for (const DesignResult& design : results.designs) names += (names.empty() ? "" : ", ") + design.name;
  return names;
}

}  // namespace

std::string ReportRun::bar_label(std::size_t design) const {
  const std::string& own = results.designs[design].name;
  return name.empty() ? own : name + ": " + own;
}

void name_runs(std::vector<ReportRun>& runs) {
  if (runs.size() < 2) return;
  std::vector<std::string> otherwise;
  for (const ReportRun& run : runs) {
    const bool one = run.results.designs.size() == 1;
    otherwise.push_back(one ? run.results.designs.front().name + ", " + run.results.file : run.results.file);
  }
  const std::vector<std::string> names = set_apart(subjects_of(runs), otherwise);
  for (std::size_t r = 0; r < runs.size(); ++r) runs[r].name = names[r];
}

std::string machines_of(const std::vector<ReportRun>& runs) { return machines_text(subjects_of(runs)); }

std::string interval_text(const std::optional<Interval>& interval, std::string (*shown)(double)) {
  return interval ? shown(interval->low) + " to " + shown(interval->high) : "";
}

std::string interval_html(const std::optional<Interval>& interval, std::string (*shown)(double)) {
  const std::string text = interval_text(interval, shown);
  return text.empty() ? "" : " <span class=\"interval\">(" + text + ")</span>";
}

std::string notes_html(const std::vector<std::pair<std::string, sim::ResultNotes>>& by_name) {
  struct Said {
    std::string id;
    std::vector<std::pair<std::string, std::string>> texts;  // {names, text of the note}, in order of appearance
  };
  std::vector<Said> all;
  for (const auto& [name, notes] : by_name) {
    for (const sim::ResultNote& note : notes) {
      auto said = std::find_if(all.begin(), all.end(), [&](const Said& s) { return s.id == note.id; });
      if (said == all.end()) said = all.insert(all.end(), {note.id, {}});
      auto known =
          std::find_if(said->texts.begin(), said->texts.end(), [&](const auto& t) { return t.second == note.text; });
      if (known == said->texts.end()) {
        said->texts.emplace_back(name, note.text);
      } else {
        known->first += ", " + name;
      }
    }
  }
  std::string out;
  for (const Said& said : all) {
    out += "<p class=\"limit\">";
    for (std::size_t i = 0; i < said.texts.size(); ++i) {
      out += fmt::format("{}<strong>Mind ({}):</strong> {}", i == 0 ? "" : "; ", escape(said.texts[i].first),
                         escape(said.texts[i].second));
    }
    out += "</p>\n";
  }
  return out;
}

std::string notes_chip(std::size_t notes, const std::string& html, const std::string& id) {
  return fmt::format("<details class=\"chip\"{}><summary>What limits these figures: {} {}</summary>\n{}</details>\n",
                     id.empty() ? "" : " id=\"" + id + "\"", notes, notes == 1 ? "note" : "notes", html);
}

std::string subject_html(const ReportRun& run, bool limits) {
  const std::string name = run.name.empty() ? "" : "<strong>" + escape(run.name) + "</strong>: ";
  std::string out = "<p class=\"subject\">" + name + escape(run.results.label) + ".";
  const auto estimated = [](const DesignResult& d) { return d.cycles_interval().has_value(); };
  if (std::any_of(run.results.designs.begin(), run.results.designs.end(), estimated)) {
    out +=
        " Estimated from a sample: intervals in brackets hold the true cycles with 95 % confidence; all other "
        "figures are estimates, too.";
  }
  out += "</p>\n";
  std::vector<std::pair<std::string, sim::ResultNotes>> notes;
  for (const DesignResult& design : run.results.designs) notes.emplace_back(design.name, design.notes);
  const std::string text = notes_html(notes);
  if (text.empty()) return out;
  const std::size_t count = static_cast<std::size_t>(std::ranges::count(text, '\n'));
  if (limits) return out + notes_chip(count, text);
  return out + "<p class=\"note\"><a href=\"#headline\">What limits these figures</a> stands with the answer.</p>\n";
}

std::string subjects_html(const std::vector<ReportRun>& runs) {
  std::string out;
  for (const ReportRun& run : runs) out += subject_html(run);
  return out;
}

std::string apart_table(const std::vector<ReportRun>& runs) {
  if (runs.size() < 2) return "";
  const std::vector<Subject> subjects = subjects_of(runs);
  std::vector<std::string> facts;
  for (const Subject& a : subjects) {
    for (const Subject& b : subjects) {
      for (const Fact& fact : a.differences(b, MayDiffer::designs)) {
        if (std::find(facts.begin(), facts.end(), fact.name) == facts.end()) facts.push_back(fact.name);
      }
    }
  }
  std::vector<Table::Column> columns = {{"fact", false}};
  for (const ReportRun& run : runs) columns.push_back({run.name, false});
  const auto beside = [&](const ReportRun& run) { return &run == runs.data() || are_side_by_side(runs.front(), run); };
  const std::string held = estimates_held(runs);
  Table table(std::all_of(runs.begin(), runs.end(), beside)
                  ? "In what the runs differ, but for keys: their times stand side by side above"
              : !held.empty() ? "In what the runs differ"
                              : "In what the runs differ: they are not compared with each other",
              columns);
  for (const std::string& fact : facts) {
    std::vector<std::string> cells = {escape(fact)};
    for (const Subject& subject : subjects) cells.push_back(escape(subject.fact(fact)));
    table.row(cells);
  }
  std::vector<std::string> designs = {"designs"}, unknown = {"not said by its file"};
  for (const ReportRun& run : runs) {
    designs.push_back(escape(joined_designs(run.results)));
    unknown.push_back(escape(run.results.subject.unknown()));
  }
  if (std::any_of(designs.begin() + 2, designs.end(), [&](const std::string& own) { return own != designs[1]; })) {
    table.row(designs);
  }
  if (std::any_of(unknown.begin() + 1, unknown.end(), [](const std::string& text) { return !text.empty(); })) {
    table.row(unknown);
  }
  return held + (table.rows() == 0 ? "" : table.html());
}

}  // namespace grtx::report
