// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/trace_event_writer.h"

#include <cassert>
#include <filesystem>

#include "grtx/base/error.h"

namespace grtx::sim {

std::unique_ptr<TraceEventFormat> make_format_of(const std::string& path) {
  const std::string end = std::filesystem::path(path).extension().string();
  if (end == ".pftrace") return make_perfetto_format();
  if (end == ".svg") return make_timeline_picture();
  if (end == ".json" || end.empty()) return make_trace_event_json();
  throw Error(path, "", "a timeline's name must end in .pftrace, .json or .svg");
}

TraceEventWriter::TraceEventWriter(const std::string& path, const TraceEventFormat::Metadata& metadata)
    : file_(path), format_(make_format_of(path)) {
  format_->head(metadata, buffer_);
}

void TraceEventWriter::flush_if_large() {
  constexpr std::size_t kFlushBytes = 1 << 20;
  if (buffer_.size() <= kFlushBytes) return;
  file_.write(buffer_);
  buffer_.clear();
}

unsigned TraceEventWriter::process(const std::string& name) {
  const unsigned number = ++processes_;
  format_->process(number, name, buffer_);
  return number;
}

TraceEventWriter::Track TraceEventWriter::track(unsigned process, const std::string& name) {
  const auto number = static_cast<unsigned>(tracks_.size() + 1);
  tracks_.push_back({process, number, 0});
  format_->track(process, number, name, buffer_);
  return tracks_.size() - 1;
}

void TraceEventWriter::begin(Track track, std::uint64_t cycle, std::string_view name, const Arguments& arguments) {
  TrackState& state = tracks_[track];
  ++state.depth;
  format_->begin(state.process, state.number, cycle, name, arguments, buffer_);
  flush_if_large();
}

void TraceEventWriter::end(Track track, std::uint64_t cycle) {
  TrackState& state = tracks_[track];
  assert(state.depth > 0);
  --state.depth;
  format_->end(state.process, state.number, cycle, buffer_);
  flush_if_large();
}

void TraceEventWriter::counter(unsigned process, std::uint64_t cycle, std::string_view name,
                               const TraceEventFormat::Series& series) {
  format_->counter(process, cycle, name, series, buffer_);
  flush_if_large();
}

void TraceEventWriter::finish(std::uint64_t cycle) {
  for (Track track = 0; track < tracks_.size(); ++track) {
    while (tracks_[track].depth > 0) end(track, cycle);
  }
  format_->tail(buffer_);
  file_.write(buffer_);
  file_.commit();
}

}  // namespace grtx::sim
