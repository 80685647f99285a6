// SPDX-License-Identifier: Apache-2.0
// Queue of traces to make, grouped by scene and acceleration structure, so that a process builds a structure once.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/explore/sweep/points.h"

namespace grtx::explore {

class TraceQueue {
 public:
  /// Minimum traces per process: building a structure takes about as long as tracing four small views.
  static constexpr std::size_t kMinTraces = 4;

  void add(const SweepTrace& trace);
  bool empty() const { return scenes_.empty(); }
  /// Removes and returns the traces for the next process, in order, at most `most`; empty if the queue is empty.
  /// places: number of free processes. Normally takes the traces of one structure. With at least as many scenes as
  /// places: all traces of a scene, structure by structure, so that the scene is read once. With at least twice as many
  /// places as structures: a share of a structure's traces, at least kMinTraces.
  std::vector<const SweepTrace*> take(std::size_t places, std::size_t most);

 private:
  struct Structure {
    std::string name;
    std::vector<const SweepTrace*> traces;
  };
  struct Scene {
    std::string file;
    std::vector<Structure> structures;
  };
  std::size_t structures() const;

  std::vector<Scene> scenes_;  ///< none is empty; scenes and structures are ordered by their first trace
};

}  // namespace grtx::explore
