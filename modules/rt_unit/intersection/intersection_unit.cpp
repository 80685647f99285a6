// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"

#include <algorithm>
#include <bit>
#include <ostream>
#include <string>

#include "grtx/base/error.h"

namespace grtx::modules {

const CounterTable<IntersectionCounters>& IntersectionCounters::table() {
  using C = IntersectionCounters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::operations, "operations", "operations", "lane operations started")
          .sum(&C::tests, "tests", "tests", "tests: more than operations when each child box is a test of its own")
          .sum(&C::busy_cycles, "busy_cycles", "pipeline cycles", "tests times initiation interval")
          .sum(&C::queue_cycles, "queue_cycles", "lane cycles", "time lanes waited for a free pipeline")
          .largest(&C::queue_max, "queue_max", "lanes", "longest queue before the pipelines");
  return table;
}

IntersectionUnit::IntersectionUnit(const sc_core::sc_module_name& name, const Config& config, unsigned entries,
                                   DataPath path, const TestInput& input)
    : IntersectionModule(name),
      config_(config),
      path_(std::move(path)),
      input_(input),
      limited_(input.node_ports != 0 || input.ray_banks != 0),
      free_from_(config.count),
      lanes_(std::size_t{entries} * kMaxLanes) {
  if (config.count < 1) throw Error("configuration", basename() + std::string(".count"), "must be at least 1");
  if (config.latency < 1) throw Error("configuration", basename() + std::string(".latency"), "must be at least 1");
  if (config.interval < 1) throw Error("configuration", basename() + std::string(".interval"), "must be at least 1");
}

void IntersectionUnit::restart() {
  queue_.clear();
  flights_.clear();
  std::fill(free_from_.begin(), free_from_.end(), 0);
  next_free_ = 0;
  node_ = 0;
  due_ = kNever;
  counters_ = {};
}

// Delivers the results due in this cycle, then starts queued operations in order on the pipelines that are free.
void IntersectionUnit::tick(Cycle now) {
  while (!flights_.empty() && flights_.front().due <= now) {
    const LaneId id = flights_.front().lane;
    flights_.pop();
    client_->unit_result(now, id);
  }
  if (!queue_.empty() && now >= next_free_) start_queued(now);
  due_ = flights_.empty() ? kNever : flights_.front().due;
  if (!queue_.empty()) due_ = std::min(due_, std::max(now + 1, next_free_));
}

bool IntersectionUnit::read(const Request& request, Reads& reads) const {
  if (input_.node_ports != 0 && (reads.nodes == 0 || request.node != reads.node)) {
    if (reads.nodes == input_.node_ports) return false;
    ++reads.nodes;
    reads.node = request.node;
  }
  if (input_.ray_banks == 0) return true;
  const LaneMask bank = bit(lane_of(request.lane) % input_.ray_banks);
  if ((reads.banks & bank) != 0) return false;
  reads.banks |= bank;
  return true;
}

void IntersectionUnit::start_queued(Cycle now) {
  Cycle earliest = kNever;
  Reads reads;
  for (Cycle& free_from : free_from_) {
    if (free_from <= now) {
      if (queue_.empty() || (limited_ && !read(queue_.front(), reads))) {
        earliest = now;
        break;
      }
      const Request request = queue_.front();
      queue_.pop();
      const Cycle occupied = Cycle{request.tests} * config_.interval;
      free_from = now + occupied;
      // Keeps flights_ ordered by due cycle; only operations with several tests can be overtaken.
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

std::vector<UnitProbe> IntersectionState::probes() const {
  const auto width = static_cast<unsigned>(std::bit_width(lanes()));
  return {{"state",
           2,
           {},
           [this](Cycle now) { return state_of(queued() != 0, !idle() || busy_pipelines(now) != 0); },
           false,
           true},
          {"busy", kLevelBits, {}, [this](Cycle now) { return busy_pipelines(now); }},
          {"queued", width, [this] { return queued(); }},
          {"in_flight", width, [this] { return in_flight(); }}};
}

Inventory IntersectionUnit::inventory() const { return intersection_inventory(name(), config_, path_, lanes_, input_); }

Inventory intersection_inventory(const char* name, const IntersectionUnit::Config& config, const DataPath& path,
                                 std::uint64_t lanes, const TestInput& input) {
  Inventory inventory{name, {}, {}};
  // A pipeline that starts a test every `interval` cycles can use each operator that many times per test.
  for (Operators o : path.operators) {
    o.count = (o.count + config.interval - 1) / config.interval * config.count;
    inventory.operators.push_back(std::move(o));
  }
  const std::uint64_t places = input.places != 0 ? input.places : lanes;
  inventory.storage.push_back(
      {"queue", StorageKind::ram, places * input.name_bits, 1, 1, false, input.name_bits});  // names of tests
  // Pipeline registers: one stage per cycle of latency, one test per `interval` stages.
  const std::uint64_t stages = (config.latency + config.interval - 1) / config.interval;
  inventory.storage.push_back({"pipeline_registers", StorageKind::flip_flop, config.count * stages * path.stage_bits});
  return inventory;
}

void IntersectionUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " queued, " << flights_.size() << " in flight";
  if (!flights_.empty()) out << ", next result in cycle " << flights_.front().due;
  out << '\n';
}

// Operators: slab test of a box: 6 add, 6 mul, 10 min/max/compare; six children are sorted by a network of 12 exchanges
// (four: 5). Register bits (Yosys, a register after each operator): box 1,089 in 6 stages, sort of six 216, triangle
// 2,496 in 6 stages, sphere 788 in 5, transform 1,248 in 3.
// Decoding a quantised bound, origin + q 2^e: a normalising shifter (four 8-bit multiplexer stages) and an 8-bit adder
// make a float of q and e, then one addition; 192 register bits per box and stage (six bounds).
DataPath ray_box_path(unsigned boxes, bool decoded) {
  // Optimal sorting networks for 1..8 inputs (Knuth, The Art of Computer Programming 3, 5.3.4).
  constexpr std::uint64_t kExchanges[9] = {0, 0, 1, 3, 5, 9, 12, 16, 19};
  const std::uint64_t n = boxes;
  DataPath path{{{"fp_add", 32, 6 * n},
                 {"fp_mul", 32, 6 * n},
                 {"fp_compare", 32, 10 * n},
                 {"exchange", 36, kExchanges[std::min(boxes, 8u)]}},
                182 * boxes};
  if (decoded) {
    path.operators.push_back({"mux", 8, 4 * 6 * n});
    path.operators.push_back({"int_add", 8, 6 * n});
    path.operators.push_back({"fp_add", 32, 6 * n});
  }
  return path;
}

// Moeller-Trumbore without a divider: edges and origin 9 add, two cross products 12 mul 6 add, four dot products 12 mul
// 8 add.
DataPath ray_triangle_path() { return {{{"fp_add", 32, 23}, {"fp_mul", 32, 24}, {"fp_compare", 32, 4}}, 416}; }

// a = d.d, b = o.d, c = o.o - 1, b^2 - a c; the entry distance needs one square root and one reciprocal.
DataPath ray_sphere_path() {
  return {{{"fp_add", 32, 8},
           {"fp_mul", 32, 11},
           {"fp_compare", 32, 3},
           {"fp_square_root", 32, 1},
           {"fp_reciprocal", 32, 1}},
          158};
}

// Peak of the response along the transformed ray: a = d.d, b = o.d, c = o.o, t = -b/a, d2 = c - b^2/a; alpha = opacity
// times a piecewise linear exp(-d2/2) of 32 pieces, whose slope and value are constants; compared with the threshold,
// with 0.99 and with the cutoff of d2. `entry`: t where the ray enters the unit sphere also needs a square root.
DataPath ray_gaussian_path(bool entry) {
  DataPath path{
      {{"fp_add", 32, 8}, {"fp_mul", 32, 13}, {"fp_compare", 32, 4}, {"mux", 64, 31}, {"fp_reciprocal", 32, 1}}, 190};
  if (entry) path.operators.push_back({"fp_square_root", 32, 1});
  return path;
}

// Decoding a map of layout quantised: nine entries of 15 bits and three means of 22 become floats, as a bound does in
// ray_box_path(); each mean is added to the grid's origin. The twelve floats of a wide leaf pass by the decoder.
DataPath ray_transform_path(bool coded) {
  DataPath path{{{"fp_add", 32, 15}, {"fp_mul", 32, 18}, {"fp_reciprocal", 32, 3}}, 416};
  if (coded) {
    path.operators.push_back({"mux", 16, 4 * 9});
    path.operators.push_back({"mux", 24, 5 * 3});
    path.operators.push_back({"int_add", 8, 12});
    path.operators.push_back({"fp_add", 32, 3});
    path.operators.push_back({"mux", 32, 12});
  }
  return path;
}

namespace {

/// name: of the module. kind: of the keys and the bound.
PartInfo unit_info(const IntersectionConfig& config, const std::string& name, const std::string& kind,
                   const std::string& unit, const std::string& tests, const std::vector<std::string>& critical_path) {
  PartInfo part;
  part.name = name;
  part.title = unit + " unit";
  part.statistics = {"gpu.rt." + name + "."};
  part.keys = {"rt." + kind + "."};
  EnergyTerm test;
  test.of = EnergyTerm::Of::test;
  test.module = name;
  test.pipelines = config.count;
  test.interval = config.interval;
  part.energy = {{.name = "rt." + name, .statistics = {"gpu.rt." + name + ".tests"}, .terms = {test}, .basis = tests}};
  // A test takes a pipeline for `interval` cycles, but nothing waits after the last.
  part.bounds = {{.name = "unit." + kind,
                  .statistics = {"gpu.rt." + name + ".busy_cycles"},
                  .rate = config.count,
                  .drain = config.interval - 1,
                  .description = "busiest " + unit + " units",
                  .words = "the " + unit + " units"}};
  part.pipelines = {"rt." + kind + ".count", config.latency, critical_path};
  return part;
}

}  // namespace

// Subtract, multiply, swap, two min/max, compare; without the sort of children and without reciprocals.
PartInfo ray_box_info(const IntersectionConfig& config) {
  PartInfo part = unit_info(config, "ray_box", "box", "ray-box", "node tests, sort included",
                            {"add", "mul", "min_max", "min_max", "min_max", "less"});
  part.bounds[0].description += ": tests x interval / count";
  part.stalls = {{"unit", "intersection units"}};
  return part;
}
// Moeller-Trumbore.
PartInfo ray_triangle_info(const IntersectionConfig& config) {
  return unit_info(config, "ray_triangle", "triangle", "ray-triangle", "triangle tests",
                   {"add", "mul", "add", "mul", "add", "add"});
}
PartInfo ray_sphere_info(const IntersectionConfig& config) {
  return unit_info(config, "ray_sphere", "sphere", "ray-sphere", "sphere tests", {"mul", "add", "add", "mul", "add"});
}
PartInfo ray_gaussian_info(const IntersectionConfig& config) {
  PartInfo part = unit_info(config, "ray_gaussian", "gaussian", "ray-Gaussian", "Gaussian tests",
                            {"mul", "add", "add", "mul", "mul", "add", "mul", "add", "mul", "less"});
  part.energy[0].off_by_default = true;
  return part;
}
PartInfo ray_transform_info(const IntersectionConfig& config) {
  PartInfo part = unit_info(config, "ray_transform", "transform", "ray-transform", "transforms", {"mul", "add", "add"});
  part.bounds[0].words = "the transform units";
  return part;
}

}  // namespace grtx::modules
