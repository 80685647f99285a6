// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>
#include <vector>

#include "grtx/base/wrapped.h"
#include "grtx/explore/search/search.h"
#include "grtx/explore/sweep/axis.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kWidth = 12;  ///< of a figure's column, at least

std::string words(const ordered_json& coordinates) {
  std::string text;
  for (const auto& [name, value] : coordinates.items()) {
    text += (text.empty() ? "" : " ") + name + "=" + text_of(value);
  }
  return text;
}

std::string figures(const ordered_json& verdict, const std::vector<std::string>& objectives) {
  std::string text;
  for (std::size_t o = 0; o < objectives.size(); ++o) {
    const std::size_t width = std::max(kWidth, objectives[o].size() + 2);
    text += verdict.contains("ratios") ? fmt::format("{:>{}.4f}", verdict.at("ratios")[o].get<double>(), width)
                                       : fmt::format("{:>{}}", verdict.at("outcome").get<std::string>(), width);
  }
  return text;
}

std::string titles(const std::vector<std::string>& objectives) {
  std::string text;
  for (const std::string& name : objectives) text += fmt::format("{:>{}}", name, std::max(kWidth, name.size() + 2));
  return text;
}

/// What the reference itself has of each objective: the geometric mean over its scenes and views. Limits are in these
/// units, the front's figures are not.
std::string reference_values(const ordered_json& result, const std::vector<std::string>& objectives) {
  const ordered_json views = result.at("reference").value("confirming", ordered_json::array());
  std::string text;
  for (std::size_t o = 0; o < objectives.size() && !views.empty(); ++o) {
    double logarithms = 0.0;
    for (const ordered_json& view : views) logarithms += std::log(view.at("values")[o].get<double>());
    text += fmt::format("{} {} {:.4g}", text.empty() ? "the reference has" : ",", objectives[o],
                        std::exp(logarithms / static_cast<double>(views.size())));
  }
  return text.empty() ? "" : wrapped(text) + "\n";
}

std::string front_text(const ordered_json& result, const std::vector<std::string>& objectives) {
  const ordered_json& front = result.at("front");
  const bool evaluated = result.at("reference").contains("evaluation");
  std::string text = "\n" +
                     wrapped(fmt::format("front, over the reference ({} on the search scenes{})",
                                         result.at("confirming").at("mode").get<std::string>(),
                                         evaluated ? ", then once on the evaluation scenes" : "")) +
                     "\n" + reference_values(result, objectives) + titles(objectives) + "\n";
  for (const ordered_json& at : front) {
    const ordered_json& candidate = result.at("candidates")[at.get<std::size_t>()];
    text += figures(candidate.at("confirming"), objectives);
    if (evaluated) text += "\n" + figures(candidate.at("evaluation"), objectives) + "   evaluation";
    text += "\n" +
            wrapped(fmt::format("    candidate {}: {}", at.get<std::size_t>(), words(candidate.at("coordinates"))), 4) +
            "\n";
  }
  if (front.empty()) text += "  none\n";
  return text;
}

std::string path_text(const ordered_json& result, const std::vector<std::string>& objectives) {
  const ordered_json& path = result.at("path");
  if (path.empty()) return "";
  std::string text = fmt::format("\nfrom the reference to the first of the front, one change at a time\n{}   change\n",
                                 titles(objectives));
  std::string idle;
  for (const ordered_json& step : path) {
    if (is_idle_step(path, step)) {
      idle += (idle.empty() ? "" : ", ") + step_words(step);
      continue;
    }
    std::string line = fmt::format("{}   {}", figures(step, objectives), step_words(step));
    if (step.contains("reason")) line += fmt::format(" ({})", step.at("reason").get<std::string>());
    text += wrapped(line + (step.contains("together") ? ", only with the next" : ""), 6) + "\n";
  }
  return text + (idle.empty() ? "" : wrapped("without effect, and left out: " + idle) + "\n");
}

std::string effects_text(const ordered_json& result) {
  std::string text;
  for (const ordered_json& of : result.at("effects")) {
    text += "\n" +
            wrapped(fmt::format("what each parameter contributes to {} (additive model, explains {:.0f} %)",
                                of.at("objective").get<std::string>(), 100.0 * of.at("explained").get<double>())) +
            "\n";
    for (const ordered_json& parameter : of.at("parameters")) {
      std::string line = fmt::format("  {:<28}", parameter.at("key").get<std::string>());
      for (const ordered_json& value : parameter.at("values")) {
        const std::string one =
            fmt::format("  {}: {:.3f}", text_of(value.at("value")), value.at("factor").get<double>());
        if (line.size() + one.size() > kLineWidth) {
          text += line + "\n";
          line = std::string(30, ' ');
        }
        line += one;
      }
      text += line + "\n";
    }
  }
  return text;
}

}  // namespace

std::string screening_words(const ordered_json& screening) {
  const auto mode = screening.at("mode").get<std::string>();
  const double scale = screening.value("scale", 1.0);
  return scale == 1.0 ? mode : fmt::format("{}, images × {}", mode, scale);
}

std::string search_text(const ordered_json& result) {
  const auto objectives = result.at("objectives").get<std::vector<std::string>>();
  const ordered_json& counts = result.at("counts");
  const auto count = [&](const char* name) { return counts.at(name).get<std::size_t>(); };
  const std::string machine = result.value("machine", "");
  std::string text = wrapped(fmt::format(
                         "{}{} candidates of {:.0f} in {} generations: {} broken, {} too dear, {} failed, {} screened "
                         "({}), {} confirmed "
                         "({}), {} on the front",
                         machine.empty() ? "" : "machine " + machine + ": ", count("candidates"),
                         counts.at("space").get<double>(), count("generations") + 1, count("broken"), count("too_dear"),
                         count("failed"), count("screened"), screening_words(result.at("screening")),
                         count("confirmed"), result.at("confirming").at("mode").get<std::string>(), count("front"))) +
                     "\n";
  text += path_text(result, objectives) + effects_text(result);
  if (!result.at("invalid").empty()) text += "\nnot on the front by rule\n";
  for (const ordered_json& group : result.at("invalid")) {
    text += wrapped(fmt::format("{:>7}  {}: {}", group.at("candidates").get<std::size_t>(),
                                group.at("outcome").get<std::string>(), group.at("reason").get<std::string>()),
                    9) +
            "\n";
  }
  text += front_text(result, objectives);
  const std::string best = best_of_front(result);
  return text + (best.empty() ? "" : wrapped(best) + "\n");
}

std::string best_of_front(const ordered_json& result) {
  const ordered_json& front = result.at("front");
  if (front.empty()) return "";
  std::string text;
  std::size_t o = 0;
  for (const ordered_json& objective : result.at("objectives")) {
    const auto ratio = [&](const ordered_json& at) {
      return result.at("candidates")[at.get<std::size_t>()].at("confirming").at("ratios")[o].get<double>();
    };
    const ordered_json& best = *std::ranges::min_element(front, {}, ratio);
    text += fmt::format("{}least {}: candidate {} ({:.3f})", o == 0 ? "" : ", ", objective.get<std::string>(),
                        best.get<std::size_t>(), ratio(best));
    ++o;
  }
  std::string rules;
  for (const ordered_json& rule : result.at("constraints")) {
    rules += (rules.empty() ? "" : "; ") + rule.get<std::string>();
  }
  return text + (rules.empty() ? "" : "; all keep " + rules);
}

std::string step_words(const ordered_json& step) {
  return fmt::format("{}: {} → {}", step.at("key").get<std::string>(),
                     step.at("from").is_null() ? "base" : text_of(step.at("from")), text_of(step.at("to")));
}

bool is_idle_step(const ordered_json& path, const ordered_json& step) {
  if (!step.contains("ratios") || step.contains("together")) return false;
  std::vector<double> before(step.at("ratios").size(), 1.0);
  for (const ordered_json& other : path) {
    if (&other == &step) return step.at("ratios").get<std::vector<double>>() == before;
    if (other.contains("ratios")) before = other.at("ratios").get<std::vector<double>>();
  }
  return false;
}

std::optional<double> limit_over_reference(const ordered_json& result, const std::string& objective) {
  for (const ordered_json& rule : result.at("constraints")) {
    static const std::regex form(R"(\s*([\w.]+)\s*<=\s*(?:([0-9.eE+-]+)\s*(\*\s*reference)?|(reference))\s*)");
    std::smatch parts;
    const auto text = rule.get<std::string>();
    if (!std::regex_match(text, parts, form) || parts[1].str() != objective) continue;
    const double bound = parts[4].matched ? 1.0 : std::strtod(parts[2].str().c_str(), nullptr);
    if (parts[3].matched || parts[4].matched) return bound;
    const auto views = result.at("reference").value("confirming", ordered_json::array());
    if (views.size() != 1) return std::nullopt;
    std::size_t o = 0;
    while (result.at("objectives")[o] != objective) ++o;
    return bound / views.front().at("values")[o].get<double>();
  }
  return std::nullopt;
}

}  // namespace grtx::explore
