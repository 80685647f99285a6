// SPDX-License-Identifier: Apache-2.0
// Chrome trace-event JSON (the format of chrome://tracing, read by ui.perfetto.dev): slices that nest on tracks, and
// counters. Written as it comes, never held in memory. Knows nothing of the model.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "grtx/base/atomic_file.h"

namespace grtx::sim {

/// Times are written in the format's microseconds: one core cycle is shown as 1 us. They never go back on one track.
class TraceEventWriter {
 public:
  using Track = std::size_t;
  using Arguments = std::vector<std::pair<std::string_view, std::uint64_t>>;

  /// metadata: name and value pairs kept in the file's "otherData".
  TraceEventWriter(const std::string& path, const std::vector<std::pair<std::string, std::string>>& metadata);

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
  void counter(unsigned process, std::uint64_t cycle, std::string_view name,
               const std::vector<std::pair<std::string_view, double>>& series);
  /// Ends all open slices, and gives the file its final name.
  void finish(std::uint64_t cycle);

 private:
  struct TrackState {
    unsigned process = 0;
    unsigned number = 0;  ///< tid, distinct over all processes
    unsigned depth = 0;
  };
  void line(const std::string& event);

  AtomicFile file_;
  std::string buffer_;
  std::vector<TrackState> tracks_;
  unsigned processes_ = 0;
};

}  // namespace grtx::sim
