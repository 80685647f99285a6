// SPDX-License-Identifier: Apache-2.0
// Reads a trace event by event and compares what it counts with the totals that the trace states; then has the trace
// proved consistent:
//   read_trace TRACE.grtx
#include <cstdio>
#include <exception>
#include <string>

#include "grtx/traces/check.h"
#include "grtx/traces/event.h"
#include "grtx/traces/reader.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "read_trace TRACE.grtx\n");
    return 2;
  }
  using namespace grtx::traces;
  try {
    const Reader reader(argv[1]);
    Totals counted;
    RayGroup group;
    for (std::uint64_t index = 0; index < reader.group_count(); ++index) {
      reader.read(index, group);
      for (const Ray& ray : group.rays) {
        counted.rounds += ray.rounds.size();
        for (const Event& event : ray.events) {
          if (event.kind() == EventKind::visit_internal) ++counted.visits_internal;
          if (event.kind() == EventKind::visit_instance) ++counted.visits_instance;
          if (event.kind() == EventKind::visit_leaf) {
            ++counted.visits_leaf;
            if (calls_any_hit(event.outcome())) ++counted.any_hit_calls;
          }
        }
      }
    }
    const Totals& stated = reader.totals();
    std::printf("%s, %u x %u: %llu rounds, %llu visits\n", std::string(grtx::name_of(reader.header().accel)).c_str(),
                reader.header().width, reader.header().height, static_cast<unsigned long long>(counted.rounds),
                static_cast<unsigned long long>(counted.visits()));
    const bool same = counted.rounds == stated.rounds && counted.visits_internal == stated.visits_internal &&
                      counted.visits_instance == stated.visits_instance && counted.visits_leaf == stated.visits_leaf &&
                      counted.any_hit_calls == stated.any_hit_calls && counted.visits() > 0;
    if (!same) std::fprintf(stderr, "read_trace: the totals of the trace are others\n");
    return same && check(reader, true) == stated ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "read_trace: %s\n", error.what());
    return 2;
  }
}
