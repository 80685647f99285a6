// SPDX-License-Identifier: Apache-2.0
// A timeline's file: slices that nest on tracks, and counters, in the format that the file's name asks for. Written as
// it comes, never held in memory. Knows nothing of the model.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/rtl_tlm/observe/trace_event_format.h"

namespace grtx::sim {

/// One core cycle is shown as 1 us. Times never go back on one track.
class TraceEventWriter {
 public:
  using Track = std::size_t;
  using Arguments = TraceEventFormat::Arguments;

  /// path: *.pftrace is written as Perfetto's protobuf, *.svg as a picture, any other name as JSON. metadata: name and
  /// value pairs kept in the file.
  TraceEventWriter(const std::string& path, const TraceEventFormat::Metadata& metadata);

  /// A process groups tracks. Returns its number.
  unsigned process(const std::string& name);
  /// Adds a track to the process; tracks are shown in the order in which they were added.
  Track track(unsigned process, const std::string& name);

  /// A slice begins inside the slices that are open on the track.
  void begin(Track track, std::uint64_t cycle, std::string_view name, const Arguments& arguments = {});
  /// Ends the innermost open slice.
  void end(Track track, std::uint64_t cycle);
  unsigned depth(Track track) const { return tracks_[track].depth; }
  /// Values of a counter from this cycle on; several series of one counter are stacked.
  void counter(unsigned process, std::uint64_t cycle, std::string_view name, const TraceEventFormat::Series& series);
  /// Ends all open slices, and gives the file its final name.
  void finish(std::uint64_t cycle);

 private:
  struct TrackState {
    unsigned process = 0;
    unsigned number = 0;  ///< distinct over all processes
    unsigned depth = 0;
  };
  void flush_if_large();

  AtomicFile file_;
  std::unique_ptr<TraceEventFormat> format_;
  std::string buffer_;
  std::vector<TrackState> tracks_;
  unsigned processes_ = 0;
};

}  // namespace grtx::sim
