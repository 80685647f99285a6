// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/dump.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/count_totals.h"
#include "grtx/traces/instance_levels.h"

namespace grtx::traces {
namespace {

class Dumper {
 public:
  Dumper(const RayGroup& group, const NodeSizes& sizes, const InstanceLevels& levels)
      : group_(group), sizes_(sizes), levels_(levels) {}

  void group_line() {
    line("group {}: {} rays, {} lanes, {} distinct internal nodes\n", group_.index, name_of(group_.kind),
         group_.rays.size(), group_.nodes.size());
  }

  void lane(unsigned lane) {
    const Ray& ray = group_.rays[lane];
    line("  lane {} pixel {}: {} rounds, {} events\n", lane, ray.pixel, ray.rounds.size(), ray.events.size());
    std::size_t next_event = 0;
    std::size_t next_processed = 0;
    for (std::size_t i = 0; i < ray.rounds.size(); ++i) {
      const Round& round = ray.rounds[i];
      line("    round {} {}, {} preloaded\n", i, round.replay ? "replays its source buffer" : "starts at the root",
           round.preloaded);
      if (!ray.bins.empty() && round.replay) {
        line("      reads from bin {} on, the far one after {}\n", round.bins.first, round.bins.before_far);
      }
      for (std::uint32_t e = 0; e < round.event_count; ++e) event(e, ray.events[next_event + e]);
      next_event += round.event_count;
      line("    round {} ends: k-buffer {}, processed {}", i, round.k_count, round.processed_count);
      if (round.overflow) line(", overflowed, {} evictions dropped", round.eviction_dropped);
      if (round.terminated) line(", terminated");
      line("\n");
      processed(ray, next_processed, round.processed_count);
      next_processed += round.processed_count;
    }
    if (!ray.bins.empty()) bins(ray);
  }

  std::string& text() { return text_; }

 private:
  template <typename... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

  void event(std::uint32_t index, const Event& e) {
    const bool internal = e.kind() == EventKind::visit_internal;
    const std::uint64_t address = (internal ? group_.nodes[e.node].address : std::uint64_t{e.node}) * sizes_.unit();
    line("      {:>5} {:<9} {:#012x}", index, name_of(e.kind()), address);
    switch (e.kind()) {
      case EventKind::visit_internal:
        children("pushed", e.pushed(), group_.nodes[e.node]);
        children("checkpointed", e.checkpoints, group_.nodes[e.node]);
        break;
      case EventKind::visit_instance:
        line("{}{}{}", levels_.is_scene(e.node) ? " of the scene" : "", e.wide() ? " wide" : "",
             e.detail != 0 ? " transform only" : "");
        break;
      case EventKind::visit_leaf:
        line(" {}{}", e.wide() ? "wide, " : "", name_of(e.outcome()));
        if (e.shifts() != 0) line(", {} shifted", e.shifts());
        if (e.hidden() != 0) line(", {} hidden", e.hidden());
        break;
      default:
        break;
    }
    if (!internal && e.written() != 0) line(", checkpointed");
    line("\n");
  }

  void children(const char* what, unsigned mask, const NodeDefinition& node) {
    if (mask == 0) return;
    line(" {}", what);
    std::uint64_t address = node.child_base * sizes_.unit();
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      if ((mask >> slot & 1) != 0) line(" {}:{:#x}", slot, address);
      address += sizes_.bytes(node.child_kinds[slot]);
    }
  }

  void bins(const Ray& ray) {
    line("    bins of the entries written");
    for (const std::uint8_t bin : ray.bins) line(" {}", bin);
    line("\n");
  }

  void processed(const Ray& ray, std::size_t first, std::size_t count) {
    if (count == 0) return;
    line("      processed");
    for (std::size_t i = first; i < first + count; ++i) {
      line(" {}{}", ray.processed[i].gaussian + 0U, ray.processed[i].blended != 0 ? "" : "(not blended)");
    }
    line("\n");
  }

  const RayGroup& group_;
  NodeSizes sizes_;
  const InstanceLevels& levels_;
  std::string text_;
};

/// The group given by --warp, or all groups.
class Groups {
 public:
  Groups(const Reader& reader, std::optional<std::uint64_t> group, std::optional<unsigned> lane)
      : first_(group.value_or(0)), end_(group ? *group + 1 : reader.group_count()) {
    if (group && *group >= reader.group_count()) {
      throw Error(reader.path(), "group " + std::to_string(*group),
                  "must be below the number of groups, " + std::to_string(reader.group_count()));
    }
    if (lane && *lane >= reader.header().warp_size) {
      throw Error(reader.path(), "lane " + std::to_string(*lane),
                  "must be below the warp size, " + std::to_string(reader.header().warp_size));
    }
  }
  std::uint64_t begin() const { return first_; }
  std::uint64_t end() const { return end_; }

 private:
  std::uint64_t first_;
  std::uint64_t end_;
};

/// One group as a line of JSON.
class JsonLine {
 public:
  JsonLine(const RayGroup& group, const NodeSizes& sizes) : group_(group), sizes_(sizes) {}

  std::string text(std::optional<unsigned> lane) {
    put(R"({{"group":{},"frame":{},"kind":"{}","nodes":[)", group_.index, group_.frame, name_of(group_.kind));
    list(group_.nodes, [this](const NodeDefinition& node) {
      put("[{},{}", bytes(node.address), bytes(node.child_base));
      for (unsigned slot = 0; slot < node.child_count; ++slot) {
        const NodeKind kind = node.child_kinds[slot];
        const auto stored = std::ranges::find(kStoredKinds, without_width(kind)) - kStoredKinds;
        put(",{}", is_wide(kind) ? stored + 4 : stored);
      }
      put("]");
    });
    put(R"(],"rays":[)");
    for (unsigned i = lane.value_or(0); i < group_.rays.size() && i <= lane.value_or(i); ++i) {
      if (i != lane.value_or(0)) put(",");
      ray(i, group_.rays[i]);
    }
    put("]}}\n");
    return std::move(text_);
  }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  template <typename Items, typename Put>
  void list(const Items& items, const Put& put_one) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (i != 0) put(",");
      put_one(items[i]);
    }
  }
  std::uint64_t bytes(std::uint64_t units) const { return units * sizes_.unit(); }

  void ray(unsigned lane, const Ray& ray) {
    put(R"({{"lane":{},"pixel":{},"rounds":[)", lane, ray.pixel);
    list(ray.rounds, [this](const Round& r) {
      put("[{},{:d},{:d},{:d},{},{},{},{}]", r.event_count, r.replay, r.overflow, r.terminated, r.preloaded, r.k_count,
          r.processed_count, r.eviction_dropped);
    });
    put(R"(],"events":[)");
    list(ray.events, [this](const Event& e) {
      const bool internal = e.kind() == EventKind::visit_internal;
      put("[{},{},{},{},{}]", static_cast<unsigned>(e.kind()), bytes(internal ? group_.nodes[e.node].address : e.node),
          e.detail, e.checkpoints, e.shifts());
    });
    put(R"(],"processed":[)");
    list(ray.processed, [this](const Processed& p) { put("[{},{}]", p.gaussian + 0U, p.blended + 0U); });
    put("]");
    if (!ray.bins.empty()) {
      put(R"(,"bins":[)");
      list(ray.bins, [this](std::uint8_t bin) { put("{}", bin); });
      put(R"(],"bin_orders":[)");
      list(ray.rounds, [this](const Round& r) { put("[{},{}]", r.bins.first, r.bins.before_far); });
      put("]");
    }
    put("}}");
  }

  const RayGroup& group_;
  NodeSizes sizes_;
  std::string text_;
};

/// The reads of one ray's visits.
class NodeReads {
 public:
  explicit NodeReads(const Header& header)
      : sizes_(header.node_sizes()),
        levels_(header),
        blas_base_(header.blas_base),
        leaf_(has_procedural_leaves(header.accel) ? NodeKind::procedural : NodeKind::triangle) {}

  void print(const RayGroup& group, unsigned lane, std::ostream& out) {
    const Ray& ray = group.rays[lane];
    const Event* event = ray.events.data();
    for (std::size_t round = 0; round < ray.rounds.size(); ++round) {
      before_ = fmt::format("{}\t{}\t{}", group.index, lane, round);
      for (std::uint32_t e = 0; e < ray.rounds[round].event_count; ++e) visit(group, *event++);
    }
    out << text_;
    text_.clear();
  }

 private:
  void visit(const RayGroup& group, const Event& event) {
    const std::uint64_t address = event.node * sizes_.unit();
    switch (event.kind()) {
      case EventKind::visit_internal:
        return read("internal", group.nodes[event.node].address * sizes_.unit(), sizes_.read_bytes(NodeKind::internal));
      case EventKind::visit_instance:
        read("instance", address, sizes_.read_bytes(of_width(event, NodeKind::instance)));
        if (event.detail == 0 && !sizes_.short_instances()) {
          const bool scene = levels_.is_scene(event.node);
          const std::uint64_t root = scene ? levels_.object_root(levels_.root_below(event.node)) * sizes_.unit() : 0;
          read("header", scene ? root - sizes_.header_bytes() : blas_base_, sizes_.header_bytes());
        }
        return;
      case EventKind::visit_leaf:
        return read(calls_any_hit(event.outcome()) ? "hit" : "leaf", address,
                    sizes_.read_bytes(of_width(event, leaf_)));
      default:
        return;  // nothing is read of the image
    }
  }
  static NodeKind of_width(const Event& event, NodeKind kind) { return event.wide() ? wide_kind(kind) : kind; }
  void read(const char* kind, std::uint64_t address, std::uint64_t bytes) {
    fmt::format_to(std::back_inserter(text_), "{}\t{}\t{}\t{}\n", before_, kind, address, bytes);
  }

  NodeSizes sizes_;
  InstanceLevels levels_;
  std::uint64_t blas_base_;
  NodeKind leaf_;
  std::string before_;
  std::string text_;
};

}  // namespace

void dump(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group, std::optional<unsigned> lane) {
  const Groups groups(reader, group, lane);
  out << "header " << header_to_json(reader.header()) << "\ntotals " << totals_to_json(reader.totals()) << "\ncontent "
      << reader.content_hash() << "\n";
  const InstanceLevels levels(reader.header());
  RayGroup decoded;
  for (std::uint64_t index = groups.begin(); index < groups.end(); ++index) {
    reader.read(index, decoded);
    Dumper dumper(decoded, reader.header().node_sizes(), levels);
    dumper.group_line();
    for (unsigned i = 0; i < decoded.rays.size(); ++i) {
      if (!lane || *lane == i) dumper.lane(i);
      out << dumper.text();
      dumper.text().clear();
    }
    out << dumper.text();
  }
}

void dump_json(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group,
               std::optional<unsigned> lane) {
  const Groups groups(reader, group, lane);
  out << R"({"schema":"grtx.trace-dump/1","version":)" << format_version(reader.header()) << R"(,"header":)"
      << header_to_json(reader.header()) << R"(,"totals":)" << totals_to_json(reader.totals()) << R"(,"content_hash":")"
      << reader.content_hash() << "\"}\n";
  RayGroup decoded;
  for (std::uint64_t index = groups.begin(); index < groups.end(); ++index) {
    reader.read(index, decoded);
    out << JsonLine(decoded, reader.header().node_sizes()).text(lane);
  }
}

void dump_nodes(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group,
                std::optional<unsigned> lane) {
  const Groups groups(reader, group, lane);
  out << "# grtx.node-reads/1 " << name_of(reader.header().accel) << ' ' << name_of(reader.header().layout)
      << " content " << reader.content_hash() << "\nwarp\tlane\tround\tkind\taddress\tbytes\n";
  NodeReads reads(reader.header());
  RayGroup decoded;
  for (std::uint64_t index = groups.begin(); index < groups.end(); ++index) {
    reader.read(index, decoded);
    for (unsigned i = 0; i < decoded.rays.size(); ++i) {
      if (!lane || *lane == i) reads.print(decoded, i, out);
    }
  }
}

}  // namespace grtx::traces
