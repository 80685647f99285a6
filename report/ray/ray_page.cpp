// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/ray_page.h"

#include <fmt/format.h>

#include <bit>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/report/page/assets.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/page.h"
#include "grtx/traces/dump.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using traces::LeafOutcome;

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

template <typename T>
std::string packed(const std::vector<T>& values) {
  static_assert(std::endian::native == std::endian::little);
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

/// Data embedded in the page, decoded by the script on demand.
std::string part(const std::string& id, const std::string& text) {
  return fmt::format("<script type=\"text/plain\" id=\"{}\">{}</script>\n", id, text);
}

/// The nodes of a warp, stored by column.
ordered_json node_columns(const std::vector<RayNode>& nodes, std::uint64_t unit) {
  std::vector<double> address;
  std::vector<std::uint8_t> kind;
  std::vector<std::uint32_t> parent, first, gaussian;
  std::vector<float> box;
  bool boxed = false;
  for (const RayNode& node : nodes) boxed = boxed || node.boxed;
  for (const RayNode& node : nodes) {
    address.push_back(static_cast<double>(node.units * unit));
    kind.push_back(static_cast<std::uint8_t>(node.kind));
    parent.push_back(node.parent);
    first.push_back(node.first_child);
    gaussian.push_back(node.gaussian);
    if (!boxed) continue;
    for (const float edge : node.box) box.push_back(node.boxed ? edge : std::numeric_limits<float>::quiet_NaN());
  }
  return {{"count", nodes.size()},  {"address", packed(address)},   {"kind", packed(kind)}, {"parent", packed(parent)},
          {"first", packed(first)}, {"gaussian", packed(gaussian)}, {"box", packed(box)}};
}

ordered_json gaussian_columns(const std::vector<DrawnGaussian>& gaussians) {
  std::vector<std::uint32_t> number;
  std::vector<float> shape;
  for (const DrawnGaussian& g : gaussians) {
    number.push_back(g.number);
    shape.insert(shape.end(), g.mean.begin(), g.mean.end());
    shape.insert(shape.end(), g.half_axes.begin(), g.half_axes.end());
    shape.insert(shape.end(), g.colour.begin(), g.colour.end());
    shape.push_back(g.opacity);
    shape.push_back(g.kernel_radius);
  }
  return {{"number", packed(number)}, {"shape", packed(shape)}};
}

/// The effects of outcomes of hits, by their numbers: the script knows no rule.
ordered_json outcomes_of_hits() {
  ordered_json outcomes = ordered_json::array();
  for (std::size_t o = 0; o < kCountOf<LeafOutcome>; ++o) {
    const auto outcome = static_cast<LeafOutcome>(o);
    outcomes.push_back({{"name", name_of(outcome)},
                        {"enters", traces::enters(outcome)},
                        {"replaces", traces::replaces(outcome)},
                        {"evicts", traces::evicts(outcome)}});
  }
  return outcomes;
}

std::uint32_t nodes_read(const RayRound& r) { return r.visits[0] + r.visits[1] + r.visits[2]; }

std::uint32_t hits_of(const RayRound& r, bool (*chosen)(LeafOutcome)) {
  std::uint32_t hits = 0;
  for (std::size_t o = 0; o < kCountOf<LeafOutcome>; ++o)
    hits += chosen(static_cast<LeafOutcome>(o)) ? r.outcomes[o] : 0;
  return hits;
}

ordered_json round_summary(const RayRound& r) {
  return {{"events", r.round.event_count},
          {"replay", r.round.replay},
          {"overflow", r.round.overflow},
          {"terminated", r.round.terminated},
          {"preloaded", r.round.preloaded},
          {"hits", r.round.k_count},
          {"processed", r.round.processed_count},
          {"blended", r.blended},
          {"read", nodes_read(r)},
          {"evicted", hits_of(r, traces::evicts)},
          {"written", r.written},
          {"taken", r.taken},
          {"forwarded", r.forwarded}};
}

std::string ray_name(const DrawnRay& ray, const traces::Header& header) {
  std::string name = fmt::format("pixel {},{}", ray.pixel % header.width, ray.pixel / header.width);
  if (ray.kind != traces::RayKind::primary) name += fmt::format(", {}", name_of(ray.kind));
  if (!header.frame_groups.empty()) name += fmt::format(", frame {}", ray.frame);
  return name + fmt::format(" (warp {}, lane {})", ray.group, ray.lane);
}

ordered_json description(const RayPage& page) {
  const traces::Header& h = *page.header;
  const traces::NodeSizes sizes = h.node_sizes();
  ordered_json json = {
      {"k", h.k},
      {"checkpoint", h.checkpoint},
      {"capacity", h.checkpoint_capacity},
      {"order", name_of(h.checkpoint_order)},
      {"tracing", name_of(h.tracing)},
      {"sorted", traces::RoundRules(h).sorted()},
      {"bounded", h.opacity_bound == traces::OpacityBound::on},
      {"ahead", h.ahead},
      {"kinds", names_of<traces::EventKind>()},
      {"outcomes", outcomes_of_hits()},
      {"size", {h.width, h.height}},
      {"picture", page.picture},
      {"median", page.median_visits},
      {"kernel_degree", h.inputs.contains("kernel_degree") && h.inputs.at("kernel_degree") == "4" ? 4 : 2},
      {"two_level", h.two_level},
      {"blas_base", h.blas_base},
      {"objects_base", h.objects_base()},
      {"reads",
       {{"internal", sizes.read_bytes(traces::NodeKind::internal)},
        {"instance", sizes.read_bytes(traces::NodeKind::instance)},
        {"leaf", sizes.read_bytes(traces::has_procedural_leaves(h.accel) ? traces::NodeKind::procedural
                                                                         : traces::NodeKind::triangle)},
        {"wide", sizes.read_bytes(traces::NodeKind::wide_instance)},
        {"header", sizes.short_instances() ? 0 : sizes.header_bytes()}}},
      {"entry_bytes",
       {{"checkpoint", traces::kCheckpointEntryBytes},
        {"eviction", std::uint64_t{4} * modules::MemoryMap::hit_fields(h)}}},
      {"gaussians", gaussian_columns(page.gaussians)}};
  json["warps"] = ordered_json::array();
  json["rays"] = ordered_json::array();
  for (std::size_t w = 0; w < page.warps.size(); ++w) {
    const DrawnWarp& warp = page.warps[w];
    ordered_json slices = ordered_json::array();
    for (const WarpSlice& slice : warp.timeline) slices.push_back({slice.name, slice.round, slice.begin, slice.end});
    json["warps"].push_back(
        {{"nodes", node_columns(warp.nodes.nodes(), sizes.unit())}, {"timeline", std::move(slices)}});
    for (const DrawnRay& ray : warp.rays) {
      ordered_json rounds = ordered_json::array();
      for (std::size_t r = 0; r < ray.replayed.rounds.size(); ++r) {
        rounds.push_back(round_summary(ray.replayed.rounds[r]));
        if (ray.traced_again) rounds.back()["transmittance"] = ray.transmittance[r];
      }
      json["rays"].push_back({{"name", ray_name(ray, h)},
                              {"pixel", {ray.pixel % h.width, ray.pixel / h.width}},
                              {"warp", w},
                              {"values", ray.traced_again},
                              {"origin", ray.origin},
                              {"direction", ray.direction},
                              {"rounds", std::move(rounds)}});
    }
  }
  return json;
}

/// Part of the page that is visible without JavaScript.
std::string round_table(const RayPage& page) {
  Table table("Rounds", {{"ray", false},
                         {"round"},
                         {"starts at", false},
                         {"events"},
                         {"nodes read"},
                         {"any-hit calls"},
                         {"evicted"},
                         {"checkpoints read"},
                         {"written"},
                         {"preloaded"},
                         {"hits"},
                         {"blended"},
                         {"ends", false}});
  table.stacks_when_narrow();
  for (const DrawnWarp& warp : page.warps) {
    for (const DrawnRay& ray : warp.rays) {
      for (std::size_t i = 0; i < ray.replayed.rounds.size(); ++i) {
        const RayRound& r = ray.replayed.rounds[i];
        const std::uint32_t evicted = page.header->checkpoint ? hits_of(r, traces::evicts) : 0;
        table.row({escape(ray_name(ray, *page.header)), number(static_cast<double>(i)),
                   r.round.replay ? "its checkpoints" : "the root", number(r.round.event_count), number(nodes_read(r)),
                   number(hits_of(r, traces::calls_any_hit)), number(evicted), number(r.taken + r.forwarded),
                   number(r.written), number(r.round.preloaded), number(r.round.k_count), number(r.blended),
                   r.round.terminated ? "ray is opaque"
                   : r.round.overflow ? "its list ran full"
                                      : ""});
      }
    }
  }
  return table.html();
}

std::string beside_table(const RayPage& page) {
  if (page.beside.empty()) return "";
  Table table("The same pixel in other traces of the view", {{"trace", false},
                                                             {"design", false},
                                                             {"rounds"},
                                                             {"nodes read"},
                                                             {"times the frame's median"},
                                                             {"hits looked at"}});
  table.stacks_when_narrow();
  for (const PixelBeside& one : page.beside) {
    table.row({escape(file_name(one.trace)), escape(one.design), number(static_cast<double>(one.rounds)),
               number(static_cast<double>(one.visits)),
               one.median == 0 ? "" : times(static_cast<double>(one.visits) / static_cast<double>(one.median)),
               number(static_cast<double>(one.processed))});
  }
  return table.html();
}

std::string facts(const RayPage& page) {
  const traces::Header& h = *page.header;
  const auto input = [&h](const char* name) {
    const auto found = h.inputs.find(name);
    return found == h.inputs.end() ? std::string() : found->second;
  };
  std::string of = input("scene");
  if (!input("camera").empty()) of += (of.empty() ? "view " : ", view ") + input("camera");
  std::string text = fmt::format(
      "<p>{}: {}structure {}, tracing {}, k = {}, {}{}{}checkpoints {}, {} x {} pixels, {} Gaussians.</p>\n",
      escape(file_name(page.trace)), of.empty() ? "" : escape(of) + ", ", name_of(h.accel), name_of(h.tracing), h.k,
      h.ahead > 1 ? fmt::format("up to {} nodes of a ray under way, ", h.ahead) : "",
      h.opacity_bound == traces::OpacityBound::on ? "bounded by opacity, " : "",
      h.any_hit == traces::AnyHit::delayed ? "any-hit shaders delayed to the end of the warp's traversal, " : "",
      h.checkpoint ? fmt::format("on ({}, up to {} entries)", name_of(h.checkpoint_order), h.checkpoint_capacity)
                   : "off",
      h.width, h.height, number(static_cast<double>(h.gaussians)));
  if (h.ahead > 1) {
    text +=
        "<p class=\"note\">Events stand in the order in which the ray came to them: of the nodes under way the one "
        "that was started first is done first.</p>\n";
  }
  if (page.scene.empty()) {
    text +=
        "<p class=\"note\">This page is made from the trace alone. The trace holds every event, so the "
        "tree, the stack and the checkpoint lists are exact. It holds no distances: t and t_max are missing, Gaussians "
        "are named "
        "where the trace names them (once they are processed), and of several evicted hits it is not known which comes "
        "first. With --scene and --cameras the ray is traced again, and all of it is shown.</p>\n";
  } else {
    text += fmt::format(
        "<p class=\"note\">The ray was traced again in {}: every event is that of the trace. t, t_max "
        "and Gaussians are what the tracer held after each event.</p>\n",
        escape(file_name(page.scene)));
  }
  return text;
}

}  // namespace

std::string ray_page(const RayPage& page) {
  const bool timeline = !page.timeline.empty();
  std::string out = page_head(page.title);
  out += page_style();
  out += ray_style();
  out += fmt::format(
      "</style>\n</head>\n<body class=\"ray\">\n<a class=\"skip\" href=\"#player\">To the player</a>\n"
      "<header><h1>{}</h1>\n{}</header>\n<main id=\"content\">\n"
      "<noscript><p>The player needs JavaScript; the table below holds the rounds.</p></noscript>\n"
      "<div id=\"player\"></div>\n",
      escape(page.title), facts(page));
  if (timeline) {
    out += fmt::format(
        "<p class=\"note\">Times are core cycles of {}{}. A timeline holds a warp's rounds and what the warp did in "
        "them; the "
        "events inside a round have no times of their own.</p>\n",
        escape(file_name(page.timeline)),
        page.timeline_config.empty() ? "" : ", of the configuration " + escape(page.timeline_config));
  }
  out += beside_table(page) + details("All rounds as a table", round_table(page));
  out += "</main>\n<footer><p>Written by grtx " GRTX_VERSION " ray. Trace " + escape(page.trace_hash) +
         ". This file holds everything it shows and loads nothing.</p></footer>\n";
  out += "<script type=\"application/json\" id=\"page\">" + script_json(description(page)) + "</script>\n";
  std::size_t ray_number = 0;
  for (const DrawnWarp& warp : page.warps) {
    for (const DrawnRay& ray : warp.rays) {
      for (std::size_t r = 0; r < ray.replayed.rounds.size(); ++r) {
        out += part(fmt::format("r{}_{}", ray_number, r), packed(ray.replayed.rounds[r].packed));
      }
      ++ray_number;
    }
  }
  out += "<script type=\"module\">\n";
  out += ray_script();
  return out + "</script>\n</body>\n</html>\n";
}

}  // namespace grtx::report
