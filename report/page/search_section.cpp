// SPDX-License-Identifier: Apache-2.0
// Sections on searches: the front, the way from the reference to the best design, what each parameter contributes, and
// candidates that were not measured, by reason.
#include <fmt/format.h>

#include <algorithm>

#include "grtx/explore/search/search.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/report/page/charts.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

std::string words(const ordered_json& coordinates) {
  std::string text;
  for (const auto& [name, value] : coordinates.items())
    text += (text.empty() ? "" : ", ") + name + " = " + explore::text_of(value);
  return text;
}

/// A search's document, with data used by all its tables.
class SearchPage {
 public:
  explicit SearchPage(const ReportSweep& sweep)
      : sweep_(sweep),
        search_(sweep.results.search),
        objectives_(search_.at("objectives").get<std::vector<std::string>>()) {
    for (const ordered_json& parameter : search_.at("parameters")) parameters_.push_back(parameter.at("key"));
    machines_ = machines_of(sweep.results);
    if (!machines_.empty()) of_ = "; " + machines_;
  }

  std::string headlines() const {
    const ordered_json& counts = search_.at("counts");
    std::string cards =
        headline(cell(counts.at("candidates")), "Candidates",
                 fmt::format("{} screened, {} confirmed, {} on the front", explore::text_of(counts.at("screened")),
                             explore::text_of(counts.at("confirmed")), explore::text_of(counts.at("front"))));
    if (!search_.at("front").empty()) {
      const ordered_json& best = candidate(search_.at("front").front());
      for (std::size_t o = 0; o < objectives_.size(); ++o) {
        cards += headline(times(ratio(best.at("confirming"), o)), objectives_[o] + " of the best",
                          o == 0 ? words(best.at("coordinates")) : "over the reference");
      }
    }
    return fmt::format("<h3>Search {}</h3>\n{}<dl class=\"cards\">\n{}</dl>\n", escape(sweep_.results.file),
                       front_table() + best_html(), cards);
  }

  std::string html() const {
    const ordered_json& counts = search_.at("counts");
    std::string constraints;
    for (const ordered_json& rule : search_.at("constraints")) {
      constraints += (constraints.empty() ? "" : "; ") + rule.get<std::string>();
    }
    return fmt::format(
               "<section id=\"{}_search\" class=\"sweep\"><h2>Search {}</h2>\n{}"
               "<p>{} candidates of {} in {} generations: {} broken, {} too dear, {} failed, {} screened ({}), {} "
               "confirmed ({}), {} on the front. Reference: {}.{}</p>\n",
               sweep_.id, escape(sweep_.results.file), subject_html(sweep_.results, sweep_.id),
               cell(counts.at("candidates")), cell(counts.at("space")), counts.at("generations").get<std::size_t>() + 1,
               cell(counts.at("broken")), cell(counts.at("too_dear")), cell(counts.at("failed")),
               cell(counts.at("screened")), escape(explore::screening_words(search_.at("screening"))),
               cell(counts.at("confirmed")), cell(search_.at("confirming").at("mode")), cell(counts.at("front")),
               escape(words(search_.at("reference").at("coordinates"))),
               constraints.empty() ? "" : " Constraints: " + escape(constraints) + ".") +
           candidates_html() + path_html() + effects_html() + invalid_table() + "</section>\n";
  }

 private:
  const ordered_json& candidate(const ordered_json& index) const {
    return search_.at("candidates").at(index.get<std::size_t>());
  }
  static double ratio(const ordered_json& verdict, std::size_t objective) {
    return verdict.at("ratios").at(objective).get<double>();
  }
  bool is_evaluated() const { return search_.at("reference").contains("evaluation"); }

  ordered_json explored(const ordered_json& coordinates, const ordered_json& ratios, const std::string& stage,
                        std::size_t id) const {
    ordered_json fields = {stage}, metrics = ratios;
    std::string name = stage;
    for (const std::string& parameter : parameters_) {
      fields.push_back(coordinates.contains(parameter) ? coordinates.at(parameter) : ordered_json());
      if (!fields.back().is_null()) name += ", " + parameter + " = " + explore::text_of(fields.back());
    }
    return {{"id", id},         {"label", fmt::format("candidate {}", id)},
            {"name", name},     {"view", 0},
            {"fields", fields}, {"metrics", metrics}};
  }

  /// The candidates for web/explore.js: those that were confirmed as confirmed, the others as screened.
  std::string candidates_html() const {
    ordered_json data = {{"subject", machines_}, {"views", {"all candidates"}}, {"designs", ordered_json::array()}};
    data["fields"] = {"stage"};
    for (const std::string& parameter : parameters_) data["fields"].push_back(parameter);
    for (const std::string& objective : objectives_) {
      data["metrics"].push_back({{"title", objective + " / reference"}, {"unit", "×"}, {"more", false}});
      if (const auto limit = explore::limit_over_reference(search_, objective))
        data["metrics"].back()["limit"] = *limit;
    }
    data["points"] = ordered_json::array();
    const ordered_json& front = search_.at("front");
    std::size_t place = 0;
    for (const ordered_json& one : search_.at("candidates")) {
      const std::size_t id = place++;
      const bool on_front = std::find(front.begin(), front.end(), ordered_json(id)) != front.end();
      const bool confirmed = one.contains("confirming") && one.at("confirming").contains("ratios");
      const ordered_json& verdict = confirmed ? one.at("confirming") : one.at("screening");
      if (!verdict.contains("ratios")) continue;
      const char* stage = on_front ? "on the front" : confirmed ? "confirmed only" : "screened";
      data["points"].push_back(explored(one.at("coordinates"), verdict.at("ratios"), stage, id));
    }
    const ordered_json ones = std::vector<double>(objectives_.size(), 1.0);
    data["points"].push_back(explored(search_.at("reference").at("coordinates"), ones, "reference", place));
    data["points"].back()["label"] = "reference";
    return explorer(sweep_.id + "_search", data);
  }

  /// The best of the front in each objective, under the constraints.
  std::string best_html() const {
    const std::string text = explore::best_of_front(search_);
    return text.empty() ? "" : "<p class=\"note\">" + escape(text) + ".</p>\n";
  }

  std::string front_table() const {
    std::vector<Table::Column> columns = {{"candidate"}};
    for (const std::string& objective : objectives_) columns.push_back({objective});
    if (is_evaluated()) {
      for (const std::string& objective : objectives_) columns.push_back({objective + ", evaluation"});
    }
    for (const std::string& parameter : parameters_) columns.push_back({parameter});
    Table table("The front, over the reference; the least " + objectives_[0] + " first" + of_, columns);
    for (const ordered_json& index : search_.at("front")) {
      const ordered_json& one = candidate(index);
      std::vector<std::string> cells = {cell(index)};
      for (std::size_t o = 0; o < objectives_.size(); ++o) cells.push_back(times(ratio(one.at("confirming"), o)));
      for (std::size_t o = 0; is_evaluated() && o < objectives_.size(); ++o) {
        const ordered_json& verdict = one.at("evaluation");
        cells.push_back(verdict.contains("ratios") ? times(ratio(verdict, o)) : cell(verdict.at("outcome")));
      }
      for (const std::string& parameter : parameters_) cells.push_back(cell(one.at("coordinates").at(parameter)));
      table.row(cells);
    }
    return table.rows() == 0 ? "<p>No candidate is on the front.</p>\n" : table.html();
  }

  std::string path_html() const {
    const ordered_json& path = search_.at("path");
    if (path.empty()) return "";
    ordered_json rows = ordered_json::array();
    rows.push_back({{"label", "reference"}, {"order", 0}, {"before", 0.0}, {"after", 1.0}, {"change", "whole"}});
    std::vector<Table::Column> columns = {{"change", false}};
    for (const std::string& objective : objectives_) columns.push_back({objective});
    columns.push_back({"note", false});
    Table table("From the reference to the best design, one change at a time; figures after each change" + of_,
                columns);
    double before = 1.0;
    std::string idle;
    for (const ordered_json& step : path) {
      if (explore::is_idle_step(path, step)) {
        idle += (idle.empty() ? "" : ", ") + explore::step_words(step);
        continue;
      }
      const std::string label = explore::step_words(step);
      std::vector<std::string> cells = {escape(label)};
      for (std::size_t o = 0; o < objectives_.size(); ++o) {
        cells.push_back(step.contains("ratios") ? times(ratio(step, o)) : "");
      }
      cells.push_back(escape(step.value("reason", "") + (step.contains("together") ? " (only with the next)" : "")));
      table.row(cells);
      const double after = step.contains("ratios") ? ratio(step, 0) : before;
      rows.push_back({{"label", label},
                      {"order", rows.size()},
                      {"before", before},
                      {"after", after},
                      {"change", after <= before ? "gain" : "loss"}});
      before = after;
    }
    rows.push_back(
        {{"label", "best"}, {"order", rows.size()}, {"before", 0.0}, {"after", before}, {"change", "whole"}});
    return chart(sweep_.id + "_search_path", "What each change brings in " + objectives_[0],
                 objectives_[0] +
                     " over the reference, from the reference to the best design: of the changes left, the "
                     "one that gains most comes next. Green lowers it, red raises it.",
                 waterfall(rows, objectives_[0] + " / reference")) +
           table.html() +
           (idle.empty() ? "" : "<p class=\"note\">Without effect, and left out: " + escape(idle) + ".</p>\n");
  }

  std::string effects_html() const {
    std::string charts, tables;
    std::size_t place = 0;
    for (const ordered_json& effect : search_.at("effects")) {
      const std::string objective = effect.at("objective");
      ordered_json rows = ordered_json::array();
      Table table("What each value contributes to " + objective + of_,
                  {{"parameter", false}, {"value"}, {"candidates"}, {"factor"}});
      for (const ordered_json& parameter : effect.at("parameters")) {
        for (const ordered_json& value : parameter.at("values")) {
          rows.push_back({{"parameter", parameter.at("key")},
                          {"value", explore::text_of(value.at("value"))},
                          {"factor", value.at("factor")},
                          {"candidates", value.at("candidates")}});
          table.row({cell(parameter.at("key")), cell(value.at("value")), cell(value.at("candidates")),
                     fmt::format("{:.3f}", value.at("factor").get<double>())});
        }
      }
      if (rows.empty()) continue;
      charts += chart(fmt::format("{}_search_effects{}", sweep_.id, place++),
                      "What each parameter contributes to " + objective,
                      fmt::format("Factors on {} by value, of an additive model of the logarithms over all screened "
                                  "candidates; it explains {:.0f} % of their variance.",
                                  objective, 100.0 * effect.at("explained").get<double>()),
                      factor_chart(rows, parameters_, "factor on " + objective));
      tables += table.html();
    }
    return tables.empty() ? ""
                          : "<div class=\"pair\">" + charts + "</div>\n" + details("Contributions as tables", tables);
  }

  std::string invalid_table() const {
    Table table("Candidates that are not on any front, by reason",
                {{"outcome", false}, {"reason", false}, {"candidates"}});
    for (const ordered_json& group : search_.at("invalid")) {
      table.row({cell(group.at("outcome")), cell(group.at("reason")), cell(group.at("candidates"))});
    }
    return table.rows() == 0 ? "" : table.html();
  }

  const ReportSweep& sweep_;
  const ordered_json& search_;
  std::vector<std::string> objectives_, parameters_;
  std::string machines_;  ///< with modes
  std::string of_;        ///< the same, behind a caption
};

}  // namespace

std::string search_headline(const ReportSweep& sweep) {
  return sweep.results.search.is_null() ? "" : SearchPage(sweep).headlines();
}

std::string search_section(const ReportSweep& sweep) {
  return sweep.results.search.is_null() ? "" : SearchPage(sweep).html();
}

}  // namespace grtx::report
