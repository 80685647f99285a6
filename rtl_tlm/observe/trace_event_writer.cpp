// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/trace_event_writer.h"

#include <fmt/format.h>

#include <cassert>
#include <nlohmann/json.hpp>

#include "grtx/base/json.h"

namespace grtx::sim {
namespace {

constexpr std::size_t kFlushBytes = 1 << 20;

std::string json_text(std::string_view text) { return grtx::json_text(nlohmann::json(text)); }

}  // namespace

TraceEventWriter::TraceEventWriter(const std::string& path,
                                   const std::vector<std::pair<std::string, std::string>>& metadata)
    : file_(path) {
  buffer_ = "{\"displayTimeUnit\": \"ns\", \"otherData\": {\"time\": \"1 us is 1 core cycle\"";
  for (const auto& [name, value] : metadata) buffer_ += ", " + json_text(name) + ": " + json_text(value);
  buffer_ +=
      "},\n\"traceEvents\": [\n{\"ph\": \"M\", \"pid\": 0, \"tid\": 0, \"ts\": 0, \"name\": \"process_name\", "
      "\"args\": {\"name\": \"gpu\"}}";
}

void TraceEventWriter::line(const std::string& event) {
  buffer_ += ",\n";
  buffer_ += event;
  if (buffer_.size() > kFlushBytes) {
    file_.write(buffer_);
    buffer_.clear();
  }
}

unsigned TraceEventWriter::process(const std::string& name) {
  const unsigned pid = ++processes_;
  line(fmt::format(R"({{"ph": "M", "pid": {}, "tid": 0, "ts": 0, "name": "process_name", "args": {{"name": {}}}}})",
                   pid, json_text(name)));
  line(fmt::format(R"({{"ph": "M", "pid": {}, "tid": 0, "ts": 0, "name": "process_sort_index", "args": )"
                   R"({{"sort_index": {}}}}})",
                   pid, pid));
  return pid;
}

TraceEventWriter::Track TraceEventWriter::track(unsigned process, const std::string& name) {
  const auto tid = static_cast<unsigned>(tracks_.size() + 1);
  tracks_.push_back({process, tid, 0});
  line(fmt::format(R"({{"ph": "M", "pid": {}, "tid": {}, "ts": 0, "name": "thread_name", "args": {{"name": {}}}}})",
                   process, tid, json_text(name)));
  line(fmt::format(R"({{"ph": "M", "pid": {}, "tid": {}, "ts": 0, "name": "thread_sort_index", "args": )"
                   R"({{"sort_index": {}}}}})",
                   process, tid, tid));
  return tracks_.size() - 1;
}

void TraceEventWriter::begin(Track track, std::uint64_t cycle, std::string_view name, const Arguments& arguments) {
  TrackState& state = tracks_[track];
  ++state.depth;
  std::string event = fmt::format(R"({{"ph": "B", "pid": {}, "tid": {}, "ts": {}, "name": {})", state.process,
                                  state.number, cycle, json_text(name));
  if (!arguments.empty()) {
    event += R"(, "args": {)";
    for (const auto& [key, value] : arguments) {
      event += fmt::format("{}{}: {}", &key == &arguments.front().first ? "" : ", ", json_text(key), value);
    }
    event += '}';
  }
  line(event + '}');
}

void TraceEventWriter::end(Track track, std::uint64_t cycle) {
  TrackState& state = tracks_[track];
  assert(state.depth > 0);
  --state.depth;
  line(fmt::format(R"({{"ph": "E", "pid": {}, "tid": {}, "ts": {}}})", state.process, state.number, cycle));
}

void TraceEventWriter::counter(unsigned process, std::uint64_t cycle, std::string_view name,
                               const std::vector<std::pair<std::string_view, double>>& series) {
  std::string values;
  for (const auto& [key, value] : series)
    values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", json_text(key), value);
  line(fmt::format(R"({{"ph": "C", "pid": {}, "tid": 0, "ts": {}, "name": {}, "args": {{{}}}}})", process, cycle,
                   json_text(name), values));
}

void TraceEventWriter::finish(std::uint64_t cycle) {
  for (Track track = 0; track < tracks_.size(); ++track) {
    while (tracks_[track].depth > 0) end(track, cycle);
  }
  file_.write(buffer_ + "\n]}\n");
  file_.commit();
}

}  // namespace grtx::sim
