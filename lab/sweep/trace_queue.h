// Traces that wait, by what they share: one process makes those of one scene and structure, so that the structure is
// built once.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/lab/sweep/points.h"

namespace grtx::sim {

class TraceQueue {
 public:
  /// Fewer traces are not worth another structure: that takes as long as some four small views.
  static constexpr std::size_t kFewest = 4;

  void add(const SweepTrace& trace);
  bool empty() const { return scenes_.empty(); }
  /// What the next process makes, in this order: the traces of one structure. Where as many scenes wait as there are
  /// places for processes, or more, those of a whole scene, structure after structure, so that it is read once. Where
  /// there are more places than structures, several processes share the traces of one, kFewest each at least. At most
  /// `most`. Nothing when it is empty.
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

  std::vector<Scene> scenes_;  ///< none is empty; this order and that in each is that of the first of its traces
};

}  // namespace grtx::sim
