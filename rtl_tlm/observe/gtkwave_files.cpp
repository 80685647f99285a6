// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/gtkwave_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <string_view>

namespace grtx::sim {
namespace {

// Trace flags of GTKWave's save files.
constexpr unsigned kHex = 0x22;           // hexadecimal, right-justified
constexpr unsigned kDecimal = 0x24;       // decimal, right-justified
constexpr unsigned kBinary = 0x28;        // for single bits
constexpr unsigned kTranslated = 0x2022;  // hexadecimal through a filter file
constexpr unsigned kAnalogStep = 0x8024;  // decimal, drawn as a stepped curve
constexpr unsigned kAnalogRow = 0x20000;  // one more row for the curve above
constexpr unsigned kGroupBegin = 0x800200, kGroupEnd = 0x1000200;
constexpr unsigned kClosedBegin = 0xC00200, kClosedEnd = 0x1401200;

enum Colour : unsigned { kNormal = 0, kRed = 1, kOrange = 2, kYellow = 3, kGreen = 4, kBlue = 5, kIndigo = 6 };

struct Scope {
  std::string name;  ///< last part
  std::vector<const SignalInfo*> signals;
  std::vector<std::unique_ptr<Scope>> scopes;

  Scope& child(std::string_view part) {
    for (const auto& scope : scopes) {
      if (scope->name == part) return *scope;
    }
    scopes.push_back(std::make_unique<Scope>());
    scopes.back()->name = part;
    return *scopes.back();
  }
};

std::string_view leaf_of(std::string_view name) { return name.substr(name.rfind('.') + 1); }

bool is_level(std::string_view leaf) {
  return leaf == "occupancy" || leaf == "mshr" || leaf == "resident" || leaf == "outstanding" || leaf == "queued" ||
         leaf == "timer" || leaf == "running";
}

Colour colour_of(std::string_view leaf) {
  if (leaf.starts_with("lanes_waiting") || leaf == "timer" || leaf == "timeouts") return kRed;
  if (leaf.starts_with("lanes_") || leaf == "active" || leaf == "node_lanes") return kOrange;
  if (leaf == "cycle" || leaf == "round" || leaf == "group" || leaf == "slot") return kYellow;
  if (leaf == "issue" || leaf == "busy" || leaf == "valid") return kGreen;
  if (is_level(leaf)) return kBlue;
  if (leaf.starts_with("node_") || leaf == "address") return kIndigo;
  return kNormal;
}

void write_trace(std::string& out, const SignalInfo& signal, const std::string& save_path) {
  const std::string_view leaf = leaf_of(signal.name);
  const std::string name = signal.width == 1 ? signal.name : fmt::format("{}[{}:0]", signal.name, signal.width - 1);
  const bool mask = leaf.starts_with("lanes_") && signal.width == 32;
  const bool bits = mask || leaf == "active" || leaf == "replay" || leaf == "t_max_lowered" || leaf == "node_lanes" ||
                    leaf == "address" || leaf == "node_address" || leaf == "ready_warps";
  if (signal.enumeration != nullptr) {
    out += fmt::format("@{:x}\n^1 {}\n{}\n", kTranslated, filter_file_of(save_path, *signal.enumeration), name);
    return;
  }
  out += fmt::format("[color] {}\n", static_cast<unsigned>(colour_of(leaf)));
  if (is_level(leaf)) {
    out += fmt::format("@{:x}\n{}\n@{:x}\n-\n", kAnalogStep, name, kAnalogRow);
  } else {
    out += fmt::format("@{:x}\n{}\n", signal.width == 1 ? kBinary : bits ? kHex : kDecimal, name);
  }
}

/// Whether a group begins closed. Units begin open; links, shader slots, all warps but the first and all SMs but the
/// first of the file begin closed.
bool closed(const Scope& scope, const Scope& outer, const std::string& path) {
  static const std::set<std::string, std::less<>> open = {"rt", "rt_scheduler", "warp_walk_scheduler", "warp_buffer",
                                                          "any_hit_collector"};
  if (open.contains(scope.name)) return false;
  const char* first_opens = path == "gpu." ? "sm" : outer.name == "warp_buffer" ? "w" : nullptr;
  if (first_opens == nullptr || !scope.name.starts_with(first_opens)) return true;
  for (const auto& sibling : outer.scopes) {
    if (sibling->name.starts_with(first_opens)) return sibling.get() != &scope;
  }
  return true;
}

void write_scope(std::string& out, const Scope& scope, const std::string& path, const std::string& save_path) {
  for (const SignalInfo* signal : scope.signals) write_trace(out, *signal, save_path);
  for (const auto& inner : scope.scopes) {
    const bool shut = closed(*inner, scope, path);
    out += fmt::format("@{:x}\n-{}{}\n", shut ? kClosedBegin : kGroupBegin, path, inner->name);
    write_scope(out, *inner, path + inner->name + ".", save_path);
    out += fmt::format("@{:x}\n-{}{}\n", shut ? kClosedEnd : kGroupEnd, path, inner->name);
  }
}

std::string filter_text(const Enumeration& enumeration, unsigned width) {
  std::string text;
  for (std::size_t i = 0; i < enumeration.values.size(); ++i) {
    const std::string colour = i < enumeration.colours.size() ? "?" + enumeration.colours[i] + "?" : "";
    text += fmt::format("{:0{}X} {}{}\n", i, (width + 3) / 4, colour, enumeration.values[i]);
  }
  return text;
}

}  // namespace

std::string filter_file_of(const std::string& save_path, const Enumeration& enumeration) {
  return save_path.substr(0, save_path.rfind('.')) + "." + enumeration.name + ".filter";
}

void write_gtkwave_files(const std::string& vcd_path, const std::string& save_path,
                         const std::vector<SignalInfo>& signals, const WaveformSpan& span) {
  constexpr double kPixels = 1050.0;  // of the wave area in a window of kWidth
  constexpr double kFrame = 200.0;    // pixels to which GTKWave's zoom exponent refers
  constexpr unsigned kWidth = 1500, kHeight = 950;
  constexpr std::uint64_t kViewCycles = 600;  // at most, so that words fit between transitions
  const std::string vcd = std::filesystem::absolute(vcd_path).string();
  const std::string save = std::filesystem::absolute(save_path).string();
  Scope root;
  std::set<const Enumeration*> written;
  for (const SignalInfo& signal : signals) {
    Scope* scope = &root;
    std::string_view rest = signal.name;
    for (std::size_t dot; (dot = rest.find('.')) != std::string_view::npos; rest.remove_prefix(dot + 1)) {
      scope = &scope->child(rest.substr(0, dot));
    }
    scope->signals.push_back(&signal);
    if (signal.enumeration != nullptr && written.insert(signal.enumeration).second) {
      write_file(filter_file_of(save, *signal.enumeration), filter_text(*signal.enumeration, signal.width));
    }
  }
  const std::uint64_t shown = std::max(span.period, std::min(span.last - span.first, kViewCycles * span.period));
  std::string out = fmt::format("[*]\n[*] GTKWave save file written by grtx {}\n[*]\n", GRTX_VERSION);
  out += fmt::format("[dumpfile] \"{}\"\n[savefile] \"{}\"\n[timestart] {}\n[size] {} {}\n[pos] -1 -1\n", vcd, save,
                     span.first, kWidth, kHeight);
  out += fmt::format("*{:.6f} {}", -std::log2(static_cast<double>(shown) / kPixels * kFrame), span.first);
  for (int marker = 0; marker < 26; ++marker) out += " -1";
  out += "\n[treeopen] gpu.\n";
  out += "[sst_width] 200\n[signals_width] 370\n[sst_expanded] 1\n[sst_vpaned_height] 400\n";
  for (const auto& top : root.scopes) {
    out += fmt::format("@{:x}\n-{}\n", kGroupBegin, top->name);
    write_scope(out, *top, top->name + ".", save);
    out += fmt::format("@{:x}\n-{}\n", kGroupEnd, top->name);
  }
  out += "[pattern_trace] 1\n[pattern_trace] 0\n";
  write_file(save_path, out);
}

}  // namespace grtx::sim
