#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "grtx/explore/search/search.h"
#include "grtx/explore/sweep/axis.h"

namespace grtx::sim {
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

std::string front_text(const ordered_json& result, const std::vector<std::string>& objectives) {
  const ordered_json& front = result.at("front");
  const bool evaluated = result.at("reference").contains("evaluation");
  std::string text = fmt::format("\nfront, over the reference ({} on the search scenes{})\n{}{}   design\n",
                                 result.at("confirming").at("mode").get<std::string>(),
                                 evaluated ? ", then once on the evaluation scenes" : "", titles(objectives),
                                 evaluated ? "  |" + titles(objectives) : "");
  for (const ordered_json& at : front) {
    const ordered_json& candidate = result.at("candidates")[at.get<std::size_t>()];
    text += figures(candidate.at("confirming"), objectives);
    if (evaluated) text += "  |" + figures(candidate.at("evaluation"), objectives);
    text += "   " + words(candidate.at("coordinates")) + "\n";
  }
  if (front.empty()) text += "  none\n";
  return text;
}

std::string path_text(const ordered_json& result, const std::vector<std::string>& objectives) {
  const ordered_json& path = result.at("path");
  if (path.empty()) return "";
  std::string text = fmt::format("\nfrom the reference to the first of the front, one change at a time\n{}   change\n",
                                 titles(objectives));
  for (const ordered_json& step : path) {
    const std::string from = step.at("from").is_null() ? "base" : text_of(step.at("from"));
    text += fmt::format("{}   {}: {} -> {}", figures(step, objectives), step.at("key").get<std::string>(), from,
                        text_of(step.at("to")));
    if (step.contains("reason")) text += fmt::format(" ({})", step.at("reason").get<std::string>());
    text += step.contains("together") ? ", only with the next\n" : "\n";
  }
  return text;
}

std::string effects_text(const ordered_json& result) {
  std::string text;
  for (const ordered_json& of : result.at("effects")) {
    text += fmt::format("\nwhat each parameter contributes to {} (additive model, explains {:.0f} %)\n",
                        of.at("objective").get<std::string>(), 100.0 * of.at("explained").get<double>());
    for (const ordered_json& parameter : of.at("parameters")) {
      text += fmt::format("  {:<28}", parameter.at("key").get<std::string>());
      for (const ordered_json& value : parameter.at("values")) {
        text += fmt::format("  {}: {:.3f}", text_of(value.at("value")), value.at("factor").get<double>());
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace

std::string search_text(const ordered_json& result) {
  const auto objectives = result.at("objectives").get<std::vector<std::string>>();
  const ordered_json& counts = result.at("counts");
  const auto count = [&](const char* name) { return counts.at(name).get<std::size_t>(); };
  std::string text = fmt::format(
      "{} candidates of {:.0f} in {} generations: {} broken, {} too dear, {} failed, {} screened ({}), {} confirmed "
      "({}), {} on the front\n",
      count("candidates"), counts.at("space").get<double>(), count("generations") + 1, count("broken"),
      count("too_dear"), count("failed"), count("screened"), result.at("screening").at("mode").get<std::string>(),
      count("confirmed"), result.at("confirming").at("mode").get<std::string>(), count("front"));
  text += front_text(result, objectives) + path_text(result, objectives) + effects_text(result);
  if (!result.at("invalid").empty()) text += "\nnot on the front by rule\n";
  for (const ordered_json& group : result.at("invalid")) {
    text += fmt::format("{:>7}  {}: {}\n", group.at("candidates").get<std::size_t>(),
                        group.at("outcome").get<std::string>(), group.at("reason").get<std::string>());
  }
  return text;
}

}  // namespace grtx::sim
