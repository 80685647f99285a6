#include "modules/intersection_unit.h"

#include <algorithm>
#include <ostream>
#include <string>

#include "base/error.h"

namespace grtx::modules {

void IntersectionUnit::Counters::add(const Counters& other) {
  operations += other.operations;
  tests += other.tests;
  busy_cycles += other.busy_cycles;
  queue_cycles += other.queue_cycles;
  queue_max = std::max(queue_max, other.queue_max);
}

void IntersectionUnit::Counters::describe(StatisticList& list, const std::string& prefix) const {
  list.add(prefix + ".operations", operations, "operations", "lane operations started");
  list.add(prefix + ".tests", tests, "tests", "tests: more than operations when each child box is a test of its own");
  list.add(prefix + ".busy_cycles", busy_cycles, "pipeline cycles", "tests times initiation interval");
  list.add(prefix + ".queue_cycles", queue_cycles, "lane cycles", "time lanes waited for a free pipeline");
  list.add(prefix + ".queue_max", queue_max, "lanes", "longest queue before the pipelines");
}

IntersectionUnit::IntersectionUnit(const sc_core::sc_module_name& name, const Config& config, unsigned entries,
                                   std::vector<Operators> operators)
    : sc_module(name),
      config_(config),
      operators_(std::move(operators)),
      free_from_(config.count),
      lanes_(std::size_t{entries} * kMaxLanes) {
  if (config.count < 1) throw Error("configuration", basename() + std::string(".count"), "must be at least 1");
  if (config.latency < 1) throw Error("configuration", basename() + std::string(".latency"), "must be at least 1");
  if (config.interval < 1) throw Error("configuration", basename() + std::string(".interval"), "must be at least 1");
}

void IntersectionUnit::start_queued(Cycle now) {
  Cycle earliest = kNever;
  for (Cycle& free_from : free_from_) {
    if (free_from <= now) {
      if (queue_.empty()) {
        earliest = now;
        break;
      }
      const Request request = queue_.front();
      queue_.pop();
      const Cycle occupied = Cycle{request.tests} * config_.interval;
      free_from = now + occupied;
      // Results are ordered by due cycle; only operations of several tests can be overtaken.
      const Cycle due = now + config_.latency + occupied - config_.interval;
      flights_.push({due, request.lane});
      for (std::size_t i = flights_.size() - 1; i > 0 && flights_[i - 1].due > due; --i) {
        std::swap(flights_[i - 1], flights_[i]);
      }
      ++counters_.operations;
      counters_.tests += request.tests;
      counters_.busy_cycles += occupied;
      counters_.queue_cycles += now - request.queued - 1;
    }
    earliest = std::min(earliest, free_from);
  }
  next_free_ = earliest;
}

Inventory IntersectionUnit::inventory() const {
  Inventory inventory{name(), {}, {}};
  for (Operators o : operators_) {
    o.count *= config_.count;
    inventory.operators.push_back(std::move(o));
  }
  inventory.storage.push_back({"queue", StorageKind::ram, lanes_ * 8});  // lane numbers
  return inventory;
}

void IntersectionUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " queued, " << flights_.size() << " in flight";
  if (!flights_.empty()) out << ", next result in cycle " << flights_.front().due;
  out << '\n';
}

// Counts: slab box 6 add, 6 mul, 10 min/max/compare; six children are ordered by the 12-exchange network (5 for four).
std::vector<Operators> ray_box_operators(unsigned boxes) {
  // Optimal sorting networks for 1..8 inputs (Knuth, The Art of Computer Programming 3, 5.3.4).
  constexpr std::uint64_t kExchanges[9] = {0, 0, 1, 3, 5, 9, 12, 16, 19};
  const std::uint64_t n = boxes;
  return {{"add", 32, 6 * n},
          {"mul", 32, 6 * n},
          {"compare", 32, 10 * n},
          {"exchange", 36, kExchanges[std::min(boxes, 8u)]}};
}

// Moeller-Trumbore without a divider: edges and origin 9 add, two cross products 12 mul 6 add, four dot products 12 mul
// 8 add.
std::vector<Operators> ray_triangle_operators() { return {{"add", 32, 23}, {"mul", 32, 24}, {"compare", 32, 4}}; }

// a = d.d, b = o.d, c = o.o - 1, b^2 - a c; the entry distance needs one square root and one reciprocal.
std::vector<Operators> ray_sphere_operators() {
  return {{"add", 32, 8}, {"mul", 32, 11}, {"compare", 32, 3}, {"square_root", 32, 1}, {"reciprocal", 32, 1}};
}

std::vector<Operators> ray_transform_operators() { return {{"add", 32, 15}, {"mul", 32, 18}, {"reciprocal", 32, 3}}; }

}  // namespace grtx::modules
