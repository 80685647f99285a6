// SPDX-License-Identifier: Apache-2.0
// The timeline keeps the rules of the trace-event format, and its slices last as long as the statistics say.
#include "grtx/rtl_tlm/observe/timeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <map>
#include <set>

#include "grtx/base/atomic_file.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/rtl_tlm/observe/timeline_size.h"
#include "grtx/rtl_tlm/observe/trace_event_format.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using nlohmann::json;
using test::statistic;

/// What a viewer makes of the file. Throws std::runtime_error for what the format forbids.
struct TimelineFile {
  struct Slice {
    std::string track, name;
    double begin = 0, end = 0;
    std::size_t depth = 0;  ///< 0: outermost
    bool operator==(const Slice&) const = default;
  };
  std::vector<Slice> slices;
  std::map<std::string, std::vector<std::pair<double, double>>> counters;  ///< name -> (time, value)
  std::set<std::string> tracks;

  explicit TimelineFile(const std::string& text) {
    const json file = json::parse(text);
    std::map<std::pair<int, int>, std::string> names;
    std::map<int, std::string> processes;
    std::map<std::pair<int, int>, std::vector<Slice>> open;
    std::map<std::pair<int, int>, double> time;
    for (const json& event : file.at("traceEvents")) {
      const std::string phase = event.at("ph");
      const std::pair<int, int> at{event.at("pid"), event.at("tid")};
      const double ts = event.at("ts");
      if (ts < 0) throw std::runtime_error("negative time");
      if (phase == "M") {
        const std::string what = event.at("name");
        if (what == "process_name") processes[at.first] = event.at("args").at("name");
        if (what == "thread_name") {
          names[at] = processes.at(at.first) + "." + event.at("args").at("name").get<std::string>();
          if (!tracks.insert(names[at]).second) throw std::runtime_error("two tracks of one name: " + names[at]);
        }
      } else if (phase == "B") {
        if (ts < time[at]) throw std::runtime_error("time goes back on " + names.at(at));
        time[at] = ts;
        open[at].push_back({names.at(at), event.at("name"), ts, 0, open[at].size()});
      } else if (phase == "E") {
        if (ts < time[at] || open[at].empty()) throw std::runtime_error("an end without begin on " + names.at(at));
        time[at] = ts;
        open[at].back().end = ts;
        slices.push_back(open[at].back());
        open[at].pop_back();
      } else if (phase == "C") {
        const std::string name = processes.at(at.first) + "." + event.at("name").get<std::string>();
        for (const auto& [series, value] : event.at("args").items()) {
          auto& values = counters[name];
          if (!values.empty() && ts <= values.back().first) throw std::runtime_error("a counter goes back: " + name);
          values.emplace_back(ts, value.get<double>());
        }
      } else {
        throw std::runtime_error("unknown phase " + phase);
      }
    }
    for (const auto& [at, slice] : open) {
      if (!slice.empty()) throw std::runtime_error("a slice without end on " + names.at(at));
    }
  }
};

/// A message of protobuf: its fields in order.
struct Field {
  unsigned number = 0;
  std::uint64_t value = 0;  ///< of a varint, or the bits of a double
  std::string bytes;
};
std::vector<Field> fields_of(const std::string& message) {
  std::size_t at = 0;
  const auto byte = [&] { return static_cast<std::uint64_t>(static_cast<unsigned char>(message.at(at++))); };
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (unsigned shift = 0;; shift += 7) {
      const std::uint64_t next = byte();
      value |= (next & 0x7F) << shift;
      if (next < 0x80) return value;
    }
  };
  std::vector<Field> fields;
  while (at < message.size()) {
    const std::uint64_t key = varint();
    Field& field = fields.emplace_back();
    field.number = static_cast<unsigned>(key >> 3);
    switch (key & 7) {
      case 0:
        field.value = varint();
        break;
      case 1:
        for (unsigned i = 0; i < 8; ++i) field.value |= byte() << (8 * i);
        break;
      case 2: {
        const std::uint64_t size = varint();
        if (size > message.size() - at) throw std::runtime_error("a field beyond its message");
        field.bytes = message.substr(at, size);
        at += size;
        break;
      }
      default:
        throw std::runtime_error("unknown wire type");
    }
  }
  return fields;
}
std::uint64_t number_in(const std::vector<Field>& fields, unsigned number) {
  const auto found = std::ranges::find(fields, number, &Field::number);
  return found == fields.end() ? 0 : found->value;
}
std::string bytes_in(const std::vector<Field>& fields, unsigned number) {
  const auto found = std::ranges::find(fields, number, &Field::number);
  return found == fields.end() ? "" : found->bytes;
}

/// What Perfetto makes of its own format; numbers of fields as in perfetto/protos/perfetto/trace.
TimelineFile read_perfetto(const std::string& bytes, std::string& metadata) {
  TimelineFile file("{\"traceEvents\": []}");
  std::map<std::uint64_t, std::string> tracks, names;
  std::map<std::uint64_t, std::vector<TimelineFile::Slice>> open;
  for (const Field& one : fields_of(bytes)) {
    const std::vector<Field> packet = fields_of(one.bytes);
    const double ts = static_cast<double>(number_in(packet, 8)) / 1000;
    const std::vector<Field> track = fields_of(bytes_in(packet, 60));
    if (!track.empty()) {
      const std::uint64_t parent = number_in(track, 5);
      tracks[number_in(track, 1)] = (parent == 0 ? "" : tracks.at(parent) + ".") + bytes_in(track, 2);
      if (!bytes_in(track, 4).empty()) file.tracks.insert(tracks.at(number_in(track, 1)));
    }
    for (const Field& interned : fields_of(bytes_in(packet, 12))) {
      const std::vector<Field> entry = fields_of(interned.bytes);
      if (interned.number == 2) names[number_in(entry, 1)] = bytes_in(entry, 2);
    }
    const std::vector<Field> event = fields_of(bytes_in(packet, 11));
    if (event.empty()) continue;
    const std::uint64_t on = number_in(event, 11), type = number_in(event, 9);
    if (type == 1) {
      open[on].push_back({tracks.at(on), names.at(number_in(event, 10)), ts, 0, open[on].size()});
    } else if (type == 2) {
      open[on].back().end = ts;
      file.slices.push_back(open[on].back());
      open[on].pop_back();
    } else if (type == 4) {
      file.counters[tracks.at(on)].emplace_back(ts, std::bit_cast<double>(number_in(event, 44)));
    } else {
      for (const Field& annotation : event) {
        if (annotation.number == 4) metadata += bytes_in(fields_of(annotation.bytes), 10) + " ";
      }
    }
  }
  return file;
}

class TimelineTest : public ::testing::Test {
 protected:
  TimelineFile record(const CycleWindow& window = {}) {
    SimulationOptions options;
    options.timeline.path = run_.path("t.json");
    options.timeline.window = window;
    stats_ = run_.run(options);
    return TimelineFile(read_file(options.timeline.path));
  }
  test::ObservedRun run_;
  nlohmann::ordered_json stats_;
};

TEST_F(TimelineTest, SlicesLastAsLongAsTheStatisticsSay) {
  const TimelineFile file = record();
  std::map<std::string, double> activity, scheduler;
  std::size_t warps = 0, rounds = 0;
  for (const TimelineFile::Slice& slice : file.slices) {
    const double cycles = slice.end - slice.begin;
    if (slice.track.find("warp slot") != std::string::npos) {
      if (slice.depth == 0) ++warps;
      if (slice.depth == 1) ++rounds;
      if (slice.depth == 2) activity[slice.name] += cycles;
      EXPECT_LE(slice.depth, 2U);
    }
    if (slice.track.ends_with(".rt_scheduler")) scheduler[slice.name] += cycles;
  }
  EXPECT_EQ(warps, 12U);
  EXPECT_GE(rounds, warps);
  for (const std::string& name : names_of<modules::WarpActivity>()) {
    const std::string key(name);
    EXPECT_EQ(activity[key], static_cast<double>(statistic(stats_, "gpu.simt.warp_cycles." + key))) << key;
  }
  EXPECT_EQ(scheduler["issue"], static_cast<double>(statistic(stats_, "gpu.rt.selections")));
  for (const char* reason : {"memory", "checkpoint", "unit", "any_hit"}) {
    EXPECT_EQ(scheduler[reason], static_cast<double>(statistic(stats_, std::string("gpu.rt.stall.") + reason)))
        << reason;
  }
}

// JSON of a frame of 48 x 48 had 56 MB.
TEST_F(TimelineTest, PerfettosProtobufHoldsTheSameInLessThanHalfTheBytes) {
  const TimelineFile json_file = record();
  SimulationOptions options;
  options.timeline.path = run_.path("t.pftrace");
  run_.run(options);
  const std::string bytes = read_file(options.timeline.path);
  std::string metadata;
  const TimelineFile file = read_perfetto(bytes, metadata);
  EXPECT_EQ(file.tracks, json_file.tracks);
  EXPECT_EQ(file.slices.size(), json_file.slices.size());
  EXPECT_EQ(file.slices, json_file.slices);
  EXPECT_EQ(file.counters.size(), json_file.counters.size());
  for (const auto& [name, values] : json_file.counters) {
    ASSERT_EQ(file.counters.at(name).size(), values.size()) << name;
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_DOUBLE_EQ(file.counters.at(name)[i].second, values[i].second);
  }
  EXPECT_EQ(metadata, "time program trace config core_period_fs ");
  EXPECT_LT(bytes.size(), std::filesystem::file_size(run_.path("t.json")) / 2);
}

// Both formats needed a viewer, which needs a network.
TEST_F(TimelineTest, APictureNeedsNoViewer) {
  SimulationOptions options;
  options.timeline.path = run_.path("t.svg");
  run_.run(options);
  const std::string svg = read_file(options.timeline.path);
  for (const char* text : {"<svg ", ">gpu.sm0 warp slot 0<", ">gpu.sm1 rt_scheduler<", ">gpu.memory dram.channel1<",
                           ">issue<", ">memory<", "</svg>\n"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }
}

TEST(TimelinePicture, AColumnHasTheColourOfWhatTookMostOfIt) {
  const auto drawn = [](std::uint64_t cycles) {
    std::string svg;
    const auto picture = make_timeline_picture();
    picture->head({}, svg);
    picture->process(1, "sm0", svg);
    picture->track(1, 1, "slot", svg);
    picture->begin(1, 1, 100, "warp 7", {{"group", 7}}, svg);
    picture->begin(1, 1, 100, "trace", {}, svg);
    picture->end(1, 1, 100 + cycles / 4, svg);
    picture->begin(1, 1, 100 + cycles / 2, "blend", {}, svg);
    for (unsigned open = 2; open > 0; --open) picture->end(1, 1, 100 + cycles, svg);
    picture->tail(svg);
    return svg;
  };
  // 960 pixels: a quarter is trace, a quarter nothing, a half blend.
  EXPECT_NE(drawn(96).find("d=\"M130.0 20h240.0v8h-240.0zM"), std::string::npos) << drawn(96);
  EXPECT_NE(drawn(96).find("d=\"M610.0 20h480.0v8h-480.0zM"), std::string::npos);
  EXPECT_NE(drawn(96).find("cycles 100 to 196; a column is 1 cycles"), std::string::npos);
  // A million cycles are no more: 977 columns of 1,024 cycles would not fit.
  EXPECT_NE(drawn(1'000'000).find("cycles 100 to 1000100; a column is 2048 cycles"), std::string::npos);
  EXPECT_LT(drawn(1'000'000).size(), drawn(96).size() + 50);
}

TEST_F(TimelineTest, SlicesNestAndCountersAreThere) {
  const TimelineFile file = record();
  for (const char* track : {"gpu.sm0.warp slot 0", "gpu.sm1.rt_scheduler", "gpu.sm0.ray_box", "gpu.sm1.l1d",
                            "gpu.memory.l2_slice0", "gpu.memory.dram.channel1"}) {
    EXPECT_TRUE(file.tracks.contains(track)) << track;
  }
  std::map<std::string, std::vector<TimelineFile::Slice>> inner;  // ended, waiting for what encloses them
  for (const TimelineFile::Slice& slice : file.slices) {
    EXPECT_LT(slice.begin, slice.end) << slice.track << " " << slice.name;
    auto& waiting = inner[slice.track];
    while (!waiting.empty() && waiting.back().depth > slice.depth) {
      EXPECT_GE(waiting.back().begin, slice.begin);
      EXPECT_LE(waiting.back().end, slice.end);
      waiting.pop_back();
    }
    waiting.push_back(slice);
  }
  for (const char* name :
       {"gpu.sm0.RT occupancy", "gpu.sm0.L1 node hit rate", "gpu.memory.L2 hit rate", "gpu.memory.DRAM bandwidth"}) {
    ASSERT_TRUE(file.counters.contains(name)) << name;
    EXPECT_GT(file.counters.at(name).size(), 10U) << name;
  }
  for (const auto& [time, value] : file.counters.at("gpu.sm0.L1 node hit rate")) EXPECT_TRUE(value >= 0 && value <= 1);
  // The mean of the counter, weighted by its intervals, is the statistic.
  const auto& bandwidth = file.counters.at("gpu.memory.DRAM bandwidth");
  double bytes = 0, end = 0;
  for (const TimelineFile::Slice& slice : file.slices) end = std::max(end, slice.end);
  for (std::size_t i = 0; i < bandwidth.size(); ++i) {
    bytes += bandwidth[i].second * ((i + 1 < bandwidth.size() ? bandwidth[i + 1].first : 0) - bandwidth[i].first) *
             (i + 1 < bandwidth.size() ? 1 : 0);
  }
  EXPECT_GT(bytes, 0.9 * static_cast<double>(statistic(stats_, "gpu.dram.bytes")) - 256.0 * 100);
  EXPECT_LE(bytes, static_cast<double>(statistic(stats_, "gpu.dram.bytes")) + 1);
}

TEST_F(TimelineTest, AWindowCutsSlices) {
  const TimelineFile file = record({2000, 2999});
  EXPECT_FALSE(file.slices.empty());
  for (const TimelineFile::Slice& slice : file.slices) {
    EXPECT_GE(slice.begin, 2000);
    EXPECT_LE(slice.end, 3000);
  }
  for (const auto& [name, values] : file.counters) EXPECT_GE(values.front().first, 2000) << name;
}

// 539 MB were written without a word. The file here is sparse: it has that size, and takes no room.
TEST(TimelineSize, ATimelineAboveHundredMegabytesIsNamedWithItsSizeAndTheRemedy) {
  const traces::testing::TemporaryFile file("large");
  const auto warning_at = [&](std::uintmax_t bytes) {
    std::filesystem::resize_file(file.path(), bytes);
    return large_timeline_warning(file.path());
  };
  write_file(file.path(), "{}");
  EXPECT_EQ(warning_at(100'000'000), "");
  EXPECT_EQ(warning_at(100'000'001),
            file.path() + " has 100 MB; --timeline-window A:B keeps the cycles that you look at");
  EXPECT_EQ(warning_at(539'000'000),
            file.path() + " has 539 MB; --timeline-window A:B keeps the cycles that you look at");
  EXPECT_EQ(large_timeline_warning(""), "");           // no timeline was asked for
  EXPECT_EQ(large_timeline_warning("/dev/null"), "");  // written, but no file
  EXPECT_EQ(large_timeline_warning(file.path() + ".no"), "");
}

TEST(TraceEventWriter, EndsWhatIsOpenAndQuotesNames) {
  const grtx::test::TemporaryFolder folder;
  TraceEventWriter writer(folder.path("t.json"), {{"trace", "\"a\\b\""}});
  const unsigned process = writer.process("p \"1\"");
  const auto track = writer.track(process, "t");
  writer.begin(track, 1, "outer", {{"group", 7}});
  writer.begin(track, 2, "inner");
  EXPECT_EQ(writer.depth(track), 2U);
  writer.finish(5);
  const std::string text = read_file(folder.path("t.json"));
  EXPECT_EQ(json::parse(text).at("otherData").at("trace"), "\"a\\b\"");
  const TimelineFile file(text);
  ASSERT_EQ(file.slices.size(), 2U);
  EXPECT_EQ(file.slices[0].name, "inner");
  EXPECT_EQ(file.slices[1].end, 5);
}

}  // namespace
}  // namespace grtx::sim
