// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/warp_timeline.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"

namespace grtx::report {
namespace {

using nlohmann::json;

/// Tracks open slices; those of a track are nested: warp, round, activity (rtl_tlm/observe/timeline.h).
class Follower {
 public:
  explicit Follower(std::uint32_t group) : group_(group) {}

  void take(const json& event) {
    const std::string phase = event.value("ph", "");
    if (phase != "B" && phase != "E") return;
    std::vector<Open>& track = tracks_[event.at("tid").get<std::uint64_t>()];
    const auto cycle = event.at("ts").get<std::uint64_t>();
    if (phase == "E") {
      if (!track.empty()) {
        if (track.back().kept != kNone) slices_[track.back().kept].end = cycle;
        track.pop_back();
      }
      return;
    }
    Open open;
    const auto arguments = event.find("args");
    if (arguments != event.end() && arguments->contains("group")) {
      open.ours = arguments->at("group") == group_;
      open.round = arguments->value("round", 0u);
      if (open.ours && arguments->contains("round")) keep(open, "", cycle);
    } else if (!track.empty() && track.back().ours) {
      open.round = track.back().round;
      keep(open, event.value("name", ""), cycle);
    }
    track.push_back(open);
  }
  std::vector<WarpSlice> slices() && { return std::move(slices_); }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  struct Open {
    bool ours = false;  ///< slice of the wanted warp, or of one of its rounds
    std::uint32_t round = 0;
    std::size_t kept = kNone;
  };
  void keep(Open& open, const std::string& name, std::uint64_t cycle) {
    open.kept = slices_.size();
    slices_.push_back({name, open.round, cycle, cycle});
  }

  std::uint32_t group_;
  std::map<std::uint64_t, std::vector<Open>> tracks_;
  std::vector<WarpSlice> slices_;
};

/// Number behind `name` in a line, e.g. 12 of `"tid": 12,`; nullopt without one.
std::optional<std::uint64_t> number_in(std::string_view line, std::string_view name) {
  const std::size_t at = line.find(name);
  std::uint64_t value = 0;
  if (at == std::string_view::npos) return std::nullopt;
  const char* const begin = line.data() + at + name.size();
  return std::from_chars(begin, line.data() + line.size(), value).ec == std::errc() ? std::optional(value)
                                                                                    : std::nullopt;
}

/// The file without events of other warps, counters and names of tracks. `grtx sim` writes one event a line; a file of
/// another layout stays whole. Saves most of the time: a timeline has hundreds of megabytes, of which a warp needs few.
std::string events_of(std::istream& file, std::uint32_t group) {
  std::map<std::uint64_t, unsigned> open;  // track -> slices open on it, from the warp's own on
  std::string kept;
  bool first = true;
  for (std::string line; std::getline(file, line);) {
    const bool begins = line.starts_with(R"({"ph": "B")"), ends = line.starts_with(R"({"ph": "E")");
    if (!line.starts_with(R"({"ph": ")")) {
      kept += line + "\n";
      continue;
    }
    const std::uint64_t track = number_in(line, R"("tid": )").value_or(0);
    const auto ours = open.find(track);
    if (begins && (ours != open.end() || number_in(line, R"("group": )") == group)) {
      ++open[track];
    } else if (ends && ours != open.end()) {
      if (--ours->second == 0) open.erase(ours);
    } else {
      continue;
    }
    if (line.back() == ',') line.pop_back();
    kept += (first ? "" : ",\n") + line;
    first = false;
  }
  return kept;
}

}  // namespace

WarpTimeline read_warp_timeline(const std::string& path, const std::string& trace_hash, std::uint32_t group) {
  check_regular_file(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(path, "", "cannot be opened");
  constexpr char kPacket = 0x0A, kElement = '<';  // with which no JSON begins
  if (const int first = file.peek(); first == kPacket || first == kElement) {
    throw Error(path, "",
                fmt::format("is {}: 'grtx sim --timeline T.json' writes what can be read",
                            first == kPacket ? "Perfetto's protobuf" : "a picture"));
  }
  Follower follower(group);
  std::string of_trace, config_hash;
  // Events are dropped as soon as they are read: a timeline may be larger than memory.
  const auto drop_events = [&](int depth, json::parse_event_t what, json& value) {
    if (depth > kMostJsonLevels) throw Error(path, "", json_levels_rule());
    if (depth != 2 || what != json::parse_event_t::object_end) return true;
    follower.take(value);
    return false;
  };
  try {
    const std::string own = events_of(file, group);
    const bool sound = json::accept(own);
    if (!sound) file = std::ifstream(path, std::ios::binary);  // the whole file tells where it is wrong
    const json rest = sound ? json::parse(own, drop_events) : json::parse(file, drop_events);
    of_trace = rest.at("otherData").at("trace").get<std::string>();
    config_hash = rest.at("otherData").value("config", "");
  } catch (const json::parse_error& error) {
    throw Error(path, fmt::format("byte {}", error.byte), "is not valid JSON");
  } catch (const json::exception&) {
    throw Error(path, "", "is no timeline that 'grtx sim --timeline' wrote");
  }
  if (of_trace != trace_hash) {
    throw Error(path, "trace", fmt::format("is the timeline of another trace: {}, not {}", of_trace, trace_hash));
  }
  WarpTimeline timeline{std::move(follower).slices(), config_hash};
  if (timeline.slices.empty())
    throw Error(path, "", fmt::format("does not show warp {}: its window is elsewhere", group));
  return timeline;
}

}  // namespace grtx::report
