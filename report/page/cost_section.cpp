// SPDX-License-Identifier: Apache-2.0
// Storage and area by hierarchy, and the resolved configuration.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "grtx/explore/cost/cost_tree.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

// A bar behind a number: its share of the whole.
std::string with_bar(const std::string& text, double share) {
  return fmt::format("<span class=\"bar\" style=\"--share:{:.1f}%\">{}</span>", 100.0 * std::clamp(share, 0.0, 1.0),
                     text);
}

/// Three digits, since bands are tens of percent wide; of small parts those that mm² have in tenths of 1,000 µm².
std::string mm2(const ordered_json& range, const char* end) {
  const double value = range.at(end).get<double>();
  return fmt::format("{:.{}f}", value, value < 1.0 ? 4 : value < 9.995 ? 2 : 1);
}

std::string milliwatts(double value) { return value > 0.0 && value < 0.005 ? "< 0.01" : fmt::format("{:.2f}", value); }

void node_rows(Table& table, const ordered_json& node, unsigned level, double copies, double whole) {
  const double own = copies * node.at("copies").get<double>();
  const ordered_json& area = node.at("area_mm2");
  const std::string name =
      escape(node.at("name").get<std::string>()) +
      (node.at("copies").get<unsigned>() == 1 ? "" : fmt::format(" ×{}", node.at("copies").get<unsigned>()));
  const double all = own * area.at("central").get<double>();
  table.row({fmt::format("<span style=\"padding-left:{}em\">{}</span>", level, name),
             number(node.at("flip_flop_bits").get<double>()), number(node.at("memory_bits").get<double>()),
             number(std::round(node.at("gate_equivalents").at("central").get<double>() * 1e-2) * 0.1), mm2(area, "low"),
             mm2(area, "central"), mm2(area, "high"), with_bar(share_text(all / whole), all / whole),
             milliwatts(node.at("leakage_mw").at("central").get<double>())});
  for (const ordered_json& child : node.at("children")) node_rows(table, child, level + 1, own, whole);
}

void item_rows(Table& table, const ordered_json& node, const std::string& path) {
  for (const ordered_json& item : node.at("items")) {
    const bool logic = item.at("kind") == name_of(explore::CostItemKind::logic);
    table.row({escape(path),
               escape(item.at("name").get<std::string>()) +
                   (item.at("added_by_grtx").get<bool>() ? " <strong>[GRTX]</strong>" : ""),
               escape(item.at("kind").get<std::string>()),
               logic ? number(item.at("count").get<double>()) : number(item.at("bits").get<double>()),
               number(item.at("area_mm2").at("central").get<double>() * 1e6),
               escape(item.at("estimator").get<std::string>())});
  }
  for (const ordered_json& child : node.at("children")) {
    item_rows(table, child, path + "." + child.at("name").get<std::string>());
  }
}

std::string energy_table(const MachineFigures& machine, const std::string& title) {
  if (machine.energy.empty()) return "";
  Table table(title + ": energy by part",
              {{"part", false}, {"actions"}, {"µJ low"}, {"central"}, {"high"}, {"an action is", false}});
  for (const ordered_json& part : machine.energy) {
    const ordered_json& nj = part.at("nanojoules");
    table.row({escape(part.at("name").get<std::string>()), number(std::round(part.at("actions").get<double>())),
               fmt::format("{:.2f}", nj.at("low").get<double>() * 1e-3),
               fmt::format("{:.2f}", nj.at("central").get<double>() * 1e-3),
               fmt::format("{:.2f}", nj.at("high").get<double>() * 1e-3), escape(part.at("basis").get<std::string>())});
  }
  return details("Energy by part, with its band", table.html());
}

// key -> value of each machine; keys whose values differ come first.
std::string configuration_table(const std::string& caption, const std::vector<std::string>& names,
                                const std::vector<const ordered_json*>& configs) {
  std::vector<Table::Column> columns = {{"key", false}};
  for (const std::string& name : names) columns.push_back({name});
  Table table(caption, columns);
  std::vector<std::string> keys;
  for (const ordered_json* config : configs) {
    for (const auto& [key, value] : config->items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  for (const std::string& key : keys) {
    std::vector<std::string> cells = {escape(key)};
    bool differs = false;
    for (const ordered_json* config : configs) {
      const ordered_json value = config->contains(key) ? config->at(key) : ordered_json();
      const ordered_json first = configs.front()->contains(key) ? configs.front()->at(key) : ordered_json();
      differs = differs || value != first;
      cells.push_back(cell(value));
    }
    table.row(cells, differs ? " class=\"differs\"" : "");
  }
  return table.html();
}

}  // namespace

std::string cost_section(const MachineFigures& machine, const std::string& title) {
  if (machine.cost.is_null()) {
    return "<p class=\"note\">" + escape(title) +
           ": the cost model cannot price this machine: " + escape(machine.problem) + "</p>\n";
  }
  const ordered_json& cost = machine.cost;
  const std::string caption = fmt::format("{}, {} nm", title, cost.at("technology").at("nm").get<unsigned>());
  Table tree(caption, {{"module", false},
                       {"flip-flop bits"},
                       {"RAM bits"},
                       {"kGE"},
                       {"mm² low"},
                       {"central"},
                       {"high"},
                       {"share of all"},
                       {"leakage, mW"}});
  node_rows(tree, cost.at("tree"), 0, 1.0, cost.at("tree").at("area_mm2").at("central").get<double>());
  Table items(caption + ": what each module is made of", {{"module", false},
                                                          {"part", false},
                                                          {"kind", false},
                                                          {"bits or operators"},
                                                          {"µm², central, one copy"},
                                                          {"estimator", false}});
  item_rows(items, cost.at("tree"), cost.at("tree").at("name").get<std::string>());
  std::string out = tree.html() + "<p class=\"note\">Figures are of one copy; the share counts all copies.</p>\n" +
                    details("What each module is made of", items.html());
  if (cost.at("checkpoint_storage").contains("bits")) {
    Table storage(title + ": added to an RT unit by checkpointing", {{"field", false}, {"bits"}});
    for (const auto& [name, bits] : cost.at("checkpoint_storage").at("bits").items()) {
      storage.row({escape(name), number(bits.get<double>())});
    }
    const double bytes = cost.at("checkpoint_storage").at("bytes").get<double>();
    storage.row({"total", fmt::format("{} B", number(bytes))}, " class=\"sum\"");
    out += storage.html();
  }
  return out + energy_table(machine, title);
}

std::string configuration_section(const std::vector<ReportRun>& runs, const std::vector<ReportSweep>& sweeps) {
  std::string out = "<section id=\"configuration\"><h2>Resolved configuration</h2>\n";
  if (!runs.empty()) {
    std::vector<std::string> names;
    std::vector<const ordered_json*> configs;
    for (const ReportRun& run : runs) {
      const std::size_t first = configs.size();
      for (const DesignResult& design : run.results.designs) {
        const auto same = [&](const ordered_json* config) { return *config == design.config; };
        const auto own = configs.begin() + static_cast<std::ptrdiff_t>(first);
        if (std::any_of(own, configs.end(), same)) continue;
        names.push_back(run.title() + (configs.size() == first ? "" : ": " + design.name));
        configs.push_back(&design.config);
      }
    }
    out += details(runs.size() == 1 ? "Configuration of the run" : "Configurations of the runs",
                   configuration_table("Every key of the runs", names, configs));
  }
  for (const ReportSweep& sweep : sweeps) {
    std::vector<std::string> names;
    std::vector<const ordered_json*> configs;
    for (const ReportSweep::Machine& machine : sweep.machines) {
      const ReportedPoint& point = sweep.results.points[machine.point];
      names.push_back(fmt::format("#{} ({})", point.id, machine.what));
      configs.push_back(&point.config);
    }
    if (configs.empty()) continue;
    out += details(escape(sweep.results.file) + ": configurations at the ends of the front",
                   configuration_table("Every key of " + sweep.results.file, names, configs));
  }
  return out + "</section>\n";
}

}  // namespace grtx::report
