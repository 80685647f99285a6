#include "grtx/traces/dump.h"

#include <fmt/format.h>

#include <iterator>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/instance_levels.h"

namespace grtx::traces {
namespace {

const char* name_of(LeafOutcome outcome) {
  switch (outcome) {
    case LeafOutcome::miss:
      return "miss";
    case LeafOutcome::behind:
      return "behind";
    case LeafOutcome::beyond:
      return "beyond";
    case LeafOutcome::inserted:
      return "inserted";
    case LeafOutcome::displaced:
      return "displaced";
    case LeafOutcome::rejected:
      return "rejected";
    case LeafOutcome::ignored:
      return "ignored";
    case LeafOutcome::nearest:
      return "nearest";
  }
  return "unknown";
}

const char* name_of(RayKind kind) {
  switch (kind) {
    case RayKind::primary:
      return "primary";
    case RayKind::glass:
      return "glass";
    case RayKind::mirror:
      return "mirror";
  }
  return "unknown";
}

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
      for (std::uint32_t e = 0; e < round.event_count; ++e) event(e, ray.events[next_event + e]);
      next_event += round.event_count;
      line("    round {} ends: k-buffer {}, processed {}", i, round.k_count, round.processed_count);
      if (round.overflow) line(", overflowed, {} evictions dropped", round.eviction_dropped);
      if (round.terminated) line(", terminated");
      line("\n");
      processed(ray, next_processed, round.processed_count);
      next_processed += round.processed_count;
    }
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
    switch (e.kind()) {
      case EventKind::visit_internal:
        line("      {:>5} internal  {:#012x}", index, address);
        children("pushed", e.pushed(), group_.nodes[e.node]);
        children("checkpointed", e.checkpoints, group_.nodes[e.node]);
        break;
      case EventKind::visit_instance:
        line("      {:>5} instance  {:#012x}{}{}", index, address, levels_.is_scene(e.node) ? " of the scene" : "",
             e.detail != 0 ? " transform only" : "");
        break;
      case EventKind::visit_leaf:
        line("      {:>5} leaf      {:#012x} {}", index, address, name_of(e.outcome()));
        if (e.shifts() != 0) line(", {} shifted", e.shifts());
        break;
      case EventKind::cull:
        line("      {:>5} cull      {:#012x}", index, address);
        break;
      case EventKind::replay_take:
        line("      {:>5} take      {:#012x}", index, address);
        break;
      case EventKind::replay_forward:
        line("      {:>5} forward   {:#012x}", index, address);
        break;
    }
    if (!internal && e.checkpoints != 0) line(", checkpointed");
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

}  // namespace

void dump(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group, std::optional<unsigned> lane) {
  if (group && *group >= reader.group_count()) {
    throw Error(reader.path(), "group " + std::to_string(*group),
                "must be below the number of groups, " + std::to_string(reader.group_count()));
  }
  if (lane && *lane >= reader.header().warp_size) {
    throw Error(reader.path(), "lane " + std::to_string(*lane),
                "must be below the warp size, " + std::to_string(reader.header().warp_size));
  }
  out << "header " << header_to_json(reader.header()) << "\ntotals " << totals_to_json(reader.totals()) << "\ncontent "
      << reader.content_hash() << "\n";
  const InstanceLevels levels(reader.header());
  RayGroup decoded;
  const std::uint64_t first = group.value_or(0);
  const std::uint64_t end = group ? first + 1 : reader.group_count();
  for (std::uint64_t index = first; index < end; ++index) {
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

}  // namespace grtx::traces
