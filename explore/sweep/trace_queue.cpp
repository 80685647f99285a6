// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/trace_queue.h"

#include <algorithm>

namespace grtx::explore {

void TraceQueue::add(const SweepTrace& trace) {
  auto scene = std::ranges::find(scenes_, trace.scene_file, &Scene::file);
  if (scene == scenes_.end()) scene = scenes_.insert(scene, {trace.scene_file, {}});
  std::vector<Structure>& structures = scene->structures;
  auto structure = std::ranges::find(structures, trace.structure, &Structure::name);
  if (structure == structures.end()) structure = structures.insert(structure, {trace.structure, {}});
  structure->traces.push_back(&trace);
}

std::size_t TraceQueue::structures() const {
  std::size_t count = 0;
  for (const Scene& scene : scenes_) count += scene.structures.size();
  return count;
}

std::vector<const SweepTrace*> TraceQueue::take(std::size_t places, std::size_t most) {
  std::vector<const SweepTrace*> taken;
  if (scenes_.empty()) return taken;
  std::vector<Structure>& of_scene = scenes_.front().structures;
  const bool whole_scene = scenes_.size() >= places;
  if (const std::size_t processes = places / structures(); processes > 1) {  // that share this structure
    most = std::min(most, std::max(kMinTraces, (of_scene.front().traces.size() + processes - 1) / processes));
  }
  do {
    std::vector<const SweepTrace*>& traces = of_scene.front().traces;
    const auto end = traces.begin() + static_cast<std::ptrdiff_t>(std::min(most - taken.size(), traces.size()));
    taken.insert(taken.end(), traces.begin(), end);
    traces.erase(traces.begin(), end);
    if (traces.empty()) of_scene.erase(of_scene.begin());
  } while (whole_scene && taken.size() < most && !of_scene.empty());
  if (of_scene.empty()) scenes_.erase(scenes_.begin());
  return taken;
}

}  // namespace grtx::explore
