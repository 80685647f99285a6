// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/cost_report.h"

#include <fmt/format.h>

#include <functional>

#include "grtx/base/wrapped.h"
#include "grtx/explore/cost/operator_cost.h"
#include "grtx/explore/cost/technology.h"
#include "grtx/explore/cost/unit_latency.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

std::string label(const CostNode& node) {
  return node.copies == 1 ? node.name : fmt::format("{} x{}", node.name, node.copies);
}

// Numbers that leave a blank before them in their columns, however large.
std::string fitting(double value, int decimals, std::size_t most = 6) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  while (text.size() > most && decimals > 0) text = fmt::format("{:.{}f}", value, --decimals);
  return text;
}

std::string bits_text(std::uint64_t bits) {
  return bits < 100'000'000 ? fmt::format("{}", bits) : fmt::format("{:.1f}M", static_cast<double>(bits) * 1e-6);
}
std::string kilo_gates_text(double gates) {
  return gates < 1e9 ? fmt::format("{:.{}f}", gates * 1e-3, gates < 1e6 ? 1 : 0) : fmt::format("{:.2f}M", gates * 1e-9);
}
std::string area_text(double mm2) { return fitting(mm2, mm2 < 1.0 ? 4 : mm2 < 10.0 ? 3 : 2); }

// A row of 80 columns; a name that is too long has a line of its own.
std::string row(const std::string& name, const std::string& flip_flops, const std::string& memory, const Range& gates,
                const Range& area, const Range& leakage, double delay) {
  constexpr std::size_t kName = 21;
  return fmt::format("{:<21}{:>9}{:>9}{:>7}{:>7}{:>7}{:>7}{:>7}{:>6}\n",
                     name.size() > kName ? name + "\n" + std::string(kName, ' ') : name, flip_flops, memory,
                     kilo_gates_text(gates.central), area_text(area.low), area_text(area.central), area_text(area.high),
                     fitting(leakage.central, 2), fitting(delay, 2, 5));
}

void print_node(std::string& out, const CostNode& node, unsigned level, unsigned depth, bool items) {
  out += row(std::string(level, ' ') + label(node), bits_text(node.flip_flop_bits), bits_text(node.memory_bits),
             node.gates, node.area_mm2, node.leakage_mw, node.delay_ns);
  if (items) {
    for (const CostItem& item : node.items) {
      const std::string what = std::string(level + 1, ' ') + "- " + item.name +
                               (item.kind == CostItemKind::logic ? fmt::format(" x{:.0f}", item.count) : "") +
                               (item.added_by_grtx ? " [GRTX]" : "");
      out += row(what, item.kind == CostItemKind::flip_flops ? bits_text(item.bits) : "",
                 item.kind == CostItemKind::sram || item.kind == CostItemKind::cache ? bits_text(item.bits) : "",
                 item.gates, item.area_mm2, item.leakage_mw, item.delay_ns);
    }
  }
  if (level == depth) return;
  for (const CostNode& child : node.children) print_node(out, child, level + 1, depth, items);
}

ordered_json json_of(const Range& r) { return {{"low", r.low}, {"central", r.central}, {"high", r.high}}; }

ordered_json json_of(const CostNode& node) {
  ordered_json json;
  json["name"] = node.name;
  json["copies"] = node.copies;
  json["flip_flop_bits"] = node.flip_flop_bits;
  json["memory_bits"] = node.memory_bits;
  json["gate_equivalents"] = json_of(node.gates);
  json["area_mm2"] = json_of(node.area_mm2);
  json["leakage_mw"] = json_of(node.leakage_mw);
  json["slowest_ns"] = node.delay_ns;
  json["items"] = ordered_json::array();
  for (const CostItem& item : node.items) {
    ordered_json i;
    i["name"] = item.name;
    i["kind"] = name_of(item.kind);
    if (item.kind == CostItemKind::logic) {
      i["count"] = item.count;
      i["operation_pj"] = json_of(item.operation_pj);
    } else {
      i["bits"] = item.bits;
      i["read_pj"] = item.read_pj;
      i["write_pj"] = item.write_pj;
    }
    i["gate_equivalents"] = json_of(item.gates);
    i["area_mm2"] = json_of(item.area_mm2);
    i["leakage_mw"] = json_of(item.leakage_mw);
    i["delay_ns"] = item.delay_ns;
    i["added_by_grtx"] = item.added_by_grtx;
    i["estimator"] = item.estimator;
    json["items"].push_back(std::move(i));
  }
  json["children"] = ordered_json::array();
  for (const CostNode& child : node.children) json["children"].push_back(json_of(child));
  return json;
}

void csv_rows(std::string& out, const CostNode& node, const std::string& path) {
  const auto row = [&](const std::string& item, const std::string& kind, std::uint64_t bits, double count,
                       const Range& gates, const Range& area, const Range& leak, double delay,
                       const std::string& estimator) {
    out += fmt::format("{},{},{},{},{},{:g},{:g},{:g},{:g},{:g},{:g},{:g},{:g},\"{}\"\n", path, node.copies, item, kind,
                       bits, count, gates.low, gates.central, gates.high, area.low, area.central, area.high, delay,
                       estimator + fmt::format("; leakage {:g} mW", leak.central));
  };
  row("", "sum", node.flip_flop_bits + node.memory_bits, 0, node.gates, node.area_mm2, node.leakage_mw, node.delay_ns,
      "");
  for (const CostItem& i : node.items) {
    row(i.name, std::string(name_of(i.kind)), i.bits, i.count, i.gates, i.area_mm2, i.leakage_mw, i.delay_ns,
        i.estimator);
  }
  for (const CostNode& child : node.children) csv_rows(out, child, path + "." + child.name);
}

std::string human_bytes(std::uint64_t bytes) {
  if (bytes >= std::uint64_t{1} << 30) return fmt::format("{:.2f} GiB", static_cast<double>(bytes) / (1u << 30));
  if (bytes >= 1u << 20) return fmt::format("{:.2f} MiB", static_cast<double>(bytes) / (1u << 20));
  return fmt::format("{:.2f} KiB", static_cast<double>(bytes) / 1024.0);
}

}  // namespace

MachineCost machine_cost(const sim::GpuConfig& config, const std::string& design,
                         const std::vector<modules::Inventory>& inventories, const CostOptions& options) {
  MachineCost cost;
  cost.config = config;
  cost.design = design;
  cost.options = options;
  cost.options.clock_mhz = config.core_mhz;
  cost.tree = cost_tree(inventories, cost.options);
  std::vector<modules::Inventory> first_unit;
  for (const modules::Inventory& i : inventories) {
    if (i.module.starts_with("gpu.sm0.rt.")) first_unit.push_back(i);
  }
  cost.storage = checkpoint_storage(first_unit);
  cost.buffers.sms = config.sms;
  cost.buffers.resident_warps = config.resident();
  cost.buffers.checkpoint_entry_bytes = config.rt.checkpoint.entry_bytes;
  const Technology& t = technology(options.nm);
  for (const modules::PartInfo& part : modules::part_table(config.rt, config.own)) {
    if (!part.pipelines || find(cost.tree, "sm0.rt." + part.name) == nullptr) continue;
    const std::vector<std::string>& path = part.pipelines->critical_path;
    cost.latencies.push_back({part.name, part.pipelines->latency, cycles_needed(path, t.delay.low, config.core_mhz),
                              cycles_needed(path, t.delay.high, config.core_mhz)});
  }
  return cost;
}

std::string cost_text(const MachineCost& cost, unsigned depth, bool items) {
  const Technology& t = technology(cost.options.nm);
  std::string out =
      wrapped(fmt::format("design {}, {} nm ({}), {:g} MHz, utilisation {:g}, control factor {:g}", cost.design, t.nm,
                          t.source, cost.options.clock_mhz, cost.options.utilisation, cost.options.control)) +
      "\nThe paper gives no area and no energy: these figures are this model's own.\n\n";
  out += fmt::format("{:<21}{:>9}{:>9}{:>7}{:>7}{:>7}{:>7}{:>7}{:>6}\n", "module", "FF bits", "RAM bits", "kGE",
                     "mm2 lo", "centr.", "high", "mW lk", "ns");
  print_node(out, cost.tree, 0, depth, items);
  if (!cost.storage.fields.empty()) {
    out += "\nAdded to an RT unit by checkpointing (the paper's table):\n";
    for (const auto& field : cost.storage.fields) out += fmt::format("  {:<24}{:>8} bits\n", field.name, field.bits);
    out += fmt::format("  {:<24}{:>8} B = {}\n", "total", cost.storage.bytes(), human_bytes(cost.storage.bytes()));
    out += wrapped(fmt::format(
               "Buffers in global memory: {} B per ray, {} for {} SMs ({} checkpoint entries x{}, {} evictions)",
               cost.buffers.bytes_per_ray(), human_bytes(cost.buffers.bytes()), cost.buffers.sms,
               cost.buffers.checkpoint_entries, cost.buffers.checkpoint_copies, cost.buffers.eviction_entries)) +
           "\n";
  }
  out += "\nCycles that the operators' delays ask for, against the configured latency:\n";
  for (const auto& l : cost.latencies) {
    out += fmt::format("  {:<16}{:>3} to {:<3} configured {:<4}{}\n", l.unit, l.fast, l.slow, l.configured,
                       l.configured >= l.slow   ? ""
                       : l.configured >= l.fast ? "needs the fast end of the node"
                                                : "too short at this node and clock");
  }
  return out;
}

ordered_json cost_json(const MachineCost& cost) {
  const Technology& t = technology(cost.options.nm);
  ordered_json json;
  json["schema"] = "grtx.cost/1";
  json["design"] = cost.design;
  json["config"] = sim::config_json(cost.config);
  json["config_hash"] = sim::config_hash(cost.config);
  json["technology"] = {{"nm", t.nm},
                        {"um2_per_ge", json_of(t.um2_per_ge)},
                        {"delay", json_of(t.delay)},
                        {"energy", json_of(t.energy)},
                        {"source", t.source},
                        {"confidence", std::string(1, t.confidence)},
                        {"utilisation", cost.options.utilisation},
                        {"control", cost.options.control}};
  json["tree"] = json_of(cost.tree);
  json["checkpoint_storage"]["bytes"] = cost.storage.bytes();
  for (const auto& field : cost.storage.fields) json["checkpoint_storage"]["bits"][field.name] = field.bits;
  json["buffers"] = {
      {"bytes_per_ray", cost.buffers.bytes_per_ray()},         {"bytes", cost.buffers.bytes()},
      {"checkpoint_entries", cost.buffers.checkpoint_entries}, {"eviction_entries", cost.buffers.eviction_entries},
      {"checkpoint_copies", cost.buffers.checkpoint_copies},   {"resident_warps", cost.buffers.resident_warps}};
  for (const auto& l : cost.latencies) {
    json["latency"][l.unit] = {{"configured", l.configured}, {"fast", l.fast}, {"slow", l.slow}};
  }
  return json;
}

std::string energy_text(const std::vector<EnergyPart>& parts, std::size_t frames) {
  const Range sum = total(parts);
  std::string out =
      fmt::format("{:<26}{:>14}{:>10}{:>10}{:>11}{:>8}\n", "part", "actions", "uJ low", "central", "high", "share");
  std::string actions = "\nAn action is\n";
  for (const EnergyPart& part : parts) {
    if (part.actions == 0.0) continue;
    out += fmt::format("{:<26}{:>14.0f}{:>10.2f}{:>10.2f}{:>11.2f}{:>7.1f}%\n", part.name, part.actions,
                       part.nanojoules.low * 1e-3, part.nanojoules.central * 1e-3, part.nanojoules.high * 1e-3,
                       100.0 * part.nanojoules.central / sum.central);
    actions += fmt::format("  {:<20}{}\n", part.name + ' ', part.basis);
  }
  const auto whole = [&out](const std::string& of, const Range& nanojoules) {
    out += fmt::format("{:<26}{:>14}{:>10.2f}{:>10.2f}{:>11.2f}\n", of, "", nanojoules.low * 1e-3,
                       nanojoules.central * 1e-3, nanojoules.high * 1e-3);
  };
  whole("run", sum);
  if (frames > 1) whole(fmt::format("a frame, mean of {}", frames), sum * (1.0 / static_cast<double>(frames)));
  return out + actions;
}

ordered_json energy_json(const std::vector<EnergyPart>& parts, std::size_t frames) {
  ordered_json json;
  json["schema"] = "grtx.energy/1";
  json["parts"] = ordered_json::array();
  for (const EnergyPart& part : parts) {
    if (part.actions == 0.0) continue;
    json["parts"].push_back({{"part", part.name},
                             {"actions", part.actions},
                             {"nanojoules", json_of(part.nanojoules)},
                             {"action", part.basis}});
  }
  const Range sum = total(parts);
  json["frames"] = frames;
  json["run_nanojoules"] = json_of(sum);
  json["frame_nanojoules"] = json_of(sum * (1.0 / static_cast<double>(frames)));
  return json;
}

std::string energy_csv(const std::vector<EnergyPart>& parts) {
  std::string out = "part,actions,nj_low,nj_central,nj_high,action\n";
  for (const EnergyPart& part : parts) {
    if (part.actions == 0.0) continue;
    out += fmt::format("{},{},{},{},{},\"{}\"\n", part.name, part.actions, part.nanojoules.low, part.nanojoules.central,
                       part.nanojoules.high, part.basis);
  }
  return out;
}

std::string cost_csv(const MachineCost& cost) {
  std::string out =
      "path,copies,item,kind,bits,count,ge_low,ge_central,ge_high,mm2_low,mm2_central,mm2_high,delay_ns,estimator\n";
  csv_rows(out, cost.tree, cost.tree.name);
  return out;
}

std::string coefficient_reference() {
  std::string out =
      "| operator | bits | GE low / central / high | GE synthesised | pJ at 45 nm, low / central / high | ns at 45 nm "
      "| "
      "source | confidence |\n|---|---|---|---|---|---|---|---|\n";
  for (const OperatorCost& o : operator_costs()) {
    out += fmt::format("| {} | {}{} | {:g} / {:g} / {:g} | {} | {:g} / {:g} / {:g} | {:g} | {} | {} |\n", o.name,
                       o.width, o.per_bit ? ", scales" : "", o.gates.low, o.gates.central, o.gates.high,
                       o.measured_gates > 0.0 ? fmt::format("{:g}", o.measured_gates) : "-", o.energy_pj.low,
                       o.energy_pj.central, o.energy_pj.high, o.delay_ns, o.source, o.confidence);
  }
  out += fmt::format(
      "| flip-flop bit | 1 | {:g} / {:g} / {:g} | 5.7 | {:g} / {:g} / {:g} | {:g} | five libraries; "
      "Aladdin | A |\n",
      kFlipFlopGates.low, kFlipFlopGates.central, kFlipFlopGates.high, kFlipFlopEnergyPj.low, kFlipFlopEnergyPj.central,
      kFlipFlopEnergyPj.high, kFlipFlopDelayNs);
  out +=
      "\n| nm | V | um2 a GE, low / central / high | delay / 45 nm, low to high | energy / 45 nm at 1.1 V | source | "
      "confidence |\n|---|---|---|---|---|---|---|\n";
  for (const unsigned nm : technology_nodes()) {
    const Technology& t = technology(nm);
    out += fmt::format("| {} | {:g} | {:.3g} / {:.3g} / {:.3g} | {:.2f} to {:.2f} | {:.3f} to {:.3f} | {} | {} |\n",
                       t.nm, t.volts, t.um2_per_ge.low, t.um2_per_ge.central, t.um2_per_ge.high, t.delay.low,
                       t.delay.high, t.energy.low, t.energy.high, t.source, t.confidence);
  }
  return out;
}

}  // namespace grtx::explore
