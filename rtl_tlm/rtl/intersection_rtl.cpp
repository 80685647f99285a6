// SPDX-License-Identifier: Apache-2.0
// The ray-box and the ray-transform unit as RTL behind intersection_if: calls become transfers at the pins of
// ray_box_unit.sv and ray_transform_unit.sv, and back. The operands, which the trace does not contain, are generated
// here, and the results are checked against the host's arithmetic (intersection_operands.h). Compiled only if Verilator
// was found. docs/model/rtl_bridge.md lists every pin.
#include <Vray_box_deep.h>
#include <Vray_box_faults.h>
#include <Vray_box_flat.h>
#include <Vray_box_staged.h>
#include <Vray_transform_deep.h>
#include <Vray_transform_faults.h>
#include <Vray_transform_flat.h>
#include <Vray_transform_staged.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/split_mix.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/rtl_tlm/rtl/clocked_model.h"
#include "grtx/rtl_tlm/rtl/intersection_operands.h"
#include "grtx/rtl_tlm/rtl/rtl_fault.h"
#include "grtx/rtl_tlm/rtl/rtl_signals.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"

namespace grtx::sim {

using namespace modules;

namespace {

std::string hexadecimal(std::uint32_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text(8, '0');
  for (unsigned i = 0; i < 8; ++i) text[7 - i] = kDigits[value >> (4 * i) & 15];
  return "0x" + text;
}
std::string hexadecimal(float value) { return hexadecimal(std::bit_cast<std::uint32_t>(value)); }

template <typename Pin>
void put_float(Pin& pin, unsigned index, float value) {
  put_bits(pin, index * 32, 32, std::bit_cast<std::uint32_t>(value));
}
template <typename Pin>
void put_floats(Pin& pin, unsigned index, const Float3& values) {
  for (unsigned i = 0; i < 3; ++i) put_float(pin, 3 * index + i, values[i]);
}
template <typename Pin>
float get_float(const Pin& pin, unsigned index) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(get_bits(pin, index * 32, 32)));
}

/// Operands, pins and results of a ray-box test. kBoxes: parameter BOXES of the block.
template <typename Verilated, unsigned kBoxes>
struct BoxBlock {
  using Model = Verilated;
  using Outcome = BoxOutcome;
  static constexpr const char* kTest = "test";

  /// children: most children per test.
  static Outcome begin(Model& pins, unsigned pipeline, std::uint64_t seed, unsigned children) {
    const BoxOperands operands = made_box_operands(seed, std::min(children, kBoxes));
    put_bits(pins.test_used, pipeline * kBoxes, kBoxes, operands.used);
    for (unsigned slot = 0; slot < kBoxes; ++slot) {
      if ((operands.used >> slot & 1) == 0) continue;
      put_floats(pins.test_lower, pipeline * kBoxes + slot, operands.lower[slot]);
      put_floats(pins.test_upper, pipeline * kBoxes + slot, operands.upper[slot]);
    }
    put_floats(pins.test_origin, pipeline, operands.origin);
    put_floats(pins.test_inverse, pipeline, operands.inverse);
    put_float(pins.test_t_offset, pipeline, operands.t_offset);
    put_float(pins.test_t_min, pipeline, operands.t_min);
    put_float(pins.test_t_max, pipeline, operands.t_max);
    return box_outcome(operands);
  }
  static void disturb(Model& pins, unsigned pipeline, std::uint64_t noise) {
    put_bits(pins.test_used, pipeline * kBoxes, kBoxes, noise);
    for (unsigned i = 0; i < 3; ++i) {
      put_bits(pins.test_origin, pipeline * 96 + i * 32, 32, split_mix(noise + i));
      put_bits(pins.test_inverse, pipeline * 96 + i * 32, 32, split_mix(noise + 3 + i));
      put_bits(pins.test_lower, pipeline * kBoxes * 96 + i * 32, 32, split_mix(noise + 6 + i));
    }
    put_bits(pins.test_t_min, pipeline * 32, 32, split_mix(noise + 9));
    put_bits(pins.test_t_max, pipeline * 32, 32, split_mix(noise + 10));
  }
  /// Describes what is wrong with a result; empty if it is correct.
  static std::string fault_of(const Model& pins, unsigned pipeline, const Outcome& expected) {
    for (unsigned place = 0; place < kBoxes; ++place) {
      const unsigned at = (pipeline * kBoxes + place) * 36;
      const bool miss = get_bits(pins.result_children, at + 35, 1) != 0;
      const BoxChild child{static_cast<std::uint32_t>(get_bits(pins.result_children, at + 4, 31)),
                           static_cast<unsigned>(get_bits(pins.result_children, at + 1, 3)),
                           get_bits(pins.result_children, at, 1) != 0};
      if (miss && place >= expected.hits) continue;
      const std::string where = "child " + std::to_string(place) + " in order must be ";
      const auto named = [](const BoxChild& c) {
        return "slot " + std::to_string(c.slot) + " from t = " + hexadecimal(c.t) + (c.beyond ? ", beyond t_max" : "");
      };
      if (place >= expected.hits) return where + "none, and is " + named(child);
      if (miss) return where + named(expected.order[place]) + ", and is none";
      if (child != expected.order[place]) return where + named(expected.order[place]) + ", and is " + named(child);
    }
    return "";
  }
  static std::vector<RtlSignal> signals() {
    return {{"result0_miss"}, {"result0_t", 32}, {"result0_slot", 3}, {"result0_beyond"}};
  }
  static std::vector<std::uint64_t> values(const Model& pins) {
    return {get_bits(pins.result_children, 35, 1), get_bits(pins.result_children, 4, 31),
            get_bits(pins.result_children, 1, 3), get_bits(pins.result_children, 0, 1)};
  }
};

/// The same for a transform.
template <typename Verilated>
struct TransformBlock {
  using Model = Verilated;
  using Outcome = TransformOutcome;
  static constexpr const char* kTest = "transform";

  static Outcome begin(Model& pins, unsigned pipeline, std::uint64_t seed, unsigned) {
    const TransformOperands operands = made_transform_operands(seed);
    for (unsigned row = 0; row < 3; ++row) put_floats(pins.test_matrix, pipeline * 3 + row, operands.rows[row]);
    put_floats(pins.test_translation, pipeline, operands.translation);
    put_floats(pins.test_origin, pipeline, operands.origin);
    put_floats(pins.test_direction, pipeline, operands.direction);
    return transform_outcome(operands);
  }
  static void disturb(Model& pins, unsigned pipeline, std::uint64_t noise) {
    for (unsigned i = 0; i < 3; ++i) {
      put_bits(pins.test_origin, pipeline * 96 + i * 32, 32, split_mix(noise + i));
      put_bits(pins.test_direction, pipeline * 96 + i * 32, 32, split_mix(noise + 3 + i));
      put_bits(pins.test_translation, pipeline * 96 + i * 32, 32, split_mix(noise + 6 + i));
    }
    for (unsigned i = 0; i < 9; ++i) put_bits(pins.test_matrix, pipeline * 288 + i * 32, 32, split_mix(noise + 9 + i));
  }
  static std::string fault_of(const Model& pins, unsigned pipeline, const Outcome& expected) {
    constexpr const char* kAxes = "xyz";
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto differs = [&](const char* what, float came, float right) {
        if (same_number(came, right)) return std::string();
        return std::string(what) + " " + kAxes[axis] + " is " + hexadecimal(came) + " in place of " +
               hexadecimal(right);
      };
      const unsigned at = pipeline * 3 + axis;
      std::string fault = differs("origin", get_float(pins.result_origin, at), expected.origin[axis]);
      if (fault.empty()) fault = differs("direction", get_float(pins.result_direction, at), expected.direction[axis]);
      if (!fault.empty()) return fault;
      // The sign of a NaN depends on the processor, and the reciprocal inherits it.
      const float inverse = get_float(pins.result_inverse, at);
      if (std::isnan(expected.direction[axis]) && same_number(-inverse, expected.inverse[axis])) continue;
      fault = differs("reciprocal", inverse, expected.inverse[axis]);
      if (!fault.empty()) return fault;
    }
    return "";
  }
  static std::vector<RtlSignal> signals() {
    return {{"result0_origin_x", 32}, {"result0_direction_x", 32}, {"result0_inverse_x", 32}};
  }
  static std::vector<std::uint64_t> values(const Model& pins) {
    return {get_bits(pins.result_origin, 0, 32), get_bits(pins.result_direction, 0, 32),
            get_bits(pins.result_inverse, 0, 32)};
  }
};

/// stages: number of registers from a pipeline's input to its result in Block::Model.
template <typename Block, unsigned kCount>
class IntersectionRtl final : public IntersectionModule, public IntersectionState, public RtlSignals {
  using Model = typename Block::Model;

 public:
  IntersectionRtl(const sc_core::sc_module_name& name, const IntersectionConfig& config, DataPath path, unsigned stages,
                  unsigned entries, unsigned children, const RtlBenchOptions& options)
      : IntersectionModule(name),
        config_(config),
        path_(std::move(path)),
        children_(children),
        lanes_(std::size_t{entries} * kMaxLanes),
        model_(name),
        noise_(options.disturbance) {
    Model& pins = model_.pins();
    pins.step = 0;
    pins.push_valid = 0;
    pins.cfg_count = static_cast<std::uint8_t>(config.count);
    pins.cfg_interval = static_cast<std::uint8_t>(config.interval);
    pins.cfg_delay = static_cast<std::uint8_t>(config.latency - stages);
    if constexpr (requires { pins.fault; }) pins.fault = static_cast<std::uint8_t>(options.fault);
    model_.reset();
    for (const RtlSignal& signal : Block::signals()) signals_.push_back(signal);
  }

  void enqueue(Cycle now, LaneId id, unsigned tests) override {
    pass_until(now + 1);
    if (tests > kMostTests) rtl_fault(name(), place_of(id), "asks for more than 15 tests");
    Lane& lane = lanes_[id];
    lane.tests = static_cast<std::uint8_t>(tests);
    lane.queued = now;
    ++lane.visit;
    Model& pins = disturbed();
    if (!pins.push_ready) rtl_fault(name(), place_of(id), "finds no room in the queue");
    pins.push_valid = 1;
    pins.push_ray = id;
    model_.edge();
    pins.push_valid = 0;
    order_.push(id);
    if (order_.size() > counters_.queue_max) counters_.queue_max = order_.size();
    due_ = std::min(due_, now + 1);
  }

  void tick(Cycle now) override {
    pass_until(now);
    Model& pins = disturbed();
    pins.step = 1;
    model_.settle();
    if (pins.level != order_.size()) {
      rtl_fault(
          name(), place_of(order_.empty() ? LaneId{0} : order_.front()),
          "is lost: the queue holds " + std::to_string(pins.level) + " lanes of " + std::to_string(order_.size()));
    }
    results_.clear();
    for (unsigned p = 0; p < kCount; ++p) {
      if (get_bits(pins.result_valid, p, 1) != 0) take_result(p);
    }
    for (unsigned p = 0; p < kCount; ++p) {
      if (get_bits(pins.start_valid, p, 1) != 0) start(now, p);
      if (get_bits(pins.test_valid, p, 1) != 0) begin_test(p);
    }
    show(now);
    model_.edge();
    pins.step = 0;
    passed_ = now + 1;
    due_ = pins.idle ? kNever : now + 1;
    // Results of one cycle are delivered in the order of their starts.
    std::sort(results_.begin(), results_.end());
    // After the edge, because the client may start the next transfer.
    for (std::size_t i = 0; i < results_.size(); ++i) client_->unit_result(now, results_[i].second);
  }

  bool idle() const override { return model_->idle; }
  std::size_t queued() const override { return model_->level; }
  std::size_t in_flight() const override { return model_->in_flight; }
  unsigned busy_pipelines(Cycle now) const override {
    return static_cast<unsigned>(
        std::count_if(free_from_.begin(), free_from_.end(), [now](Cycle free_from) { return free_from > now; }));
  }
  std::uint64_t progress() const override { return counters_.operations; }
  IntersectionCounters counters() const override { return counters_; }
  std::size_t lanes() const override { return lanes_.size(); }
  Inventory inventory() const override { return intersection_inventory(name(), config_, path_, lanes_.size()); }
  void dump_state(std::ostream& out) const override {
    out << name() << " (RTL): " << queued() << " queued, " << in_flight() << " in flight, " << model_.edges()
        << " clock edges\n";
  }

  const std::vector<RtlSignal>& rtl_signals() const override { return signals_; }
  std::uint64_t rtl_value(std::size_t index, Cycle now) const override {
    switch (index) {
      case 0:
        return model_.edges();
      case 1:
        return model_->level;
      case 2:
        return model_->in_flight;
      case 3:
        return model_->busy;
      default:
        return shown_in_ == now ? shown_[index - 4] : 0;
    }
  }

 private:
  static constexpr unsigned kMostTests = 15, kRayBits = 10;
  static_assert(1u << kRayBits == IntersectionRtlLimits::kWarps * kMaxLanes);
  struct Lane {
    std::uint32_t visit = 0;  ///< number of requests so far
    Cycle queued = 0;
    std::uint64_t started = 0;  ///< number of its start, for ordering results
    std::uint8_t tests = 0;
  };
  struct Flight {
    LaneId lane = 0;
    unsigned number = 0;
    bool last = false;
    typename Block::Outcome expected{};
  };

  void end_of_elaboration() override { client_ = client.operator->(); }

  std::string place_of(LaneId id) const {
    return "warp " + std::to_string(entry_of(id)) + " lane " + std::to_string(lane_of(id));
  }
  [[noreturn]] void refuse(LaneId id, unsigned number, const std::string& rule) const {
    const std::uint32_t visit = id < lanes_.size() ? lanes_[id].visit : 0;
    rtl_fault(
        name(), place_of(id),
        std::string(Block::kTest) + " " + std::to_string(number) + " of visit " + std::to_string(visit) + ": " + rule);
  }

  /// Clocks the block through the cycles before `now` without requests, in which its pipelines become free.
  void pass_until(Cycle now) {
    for (; passed_ < now && model_->busy != 0; ++passed_) {
      Model& pins = disturbed();
      pins.step = 1;
      model_.edge();
      pins.step = 0;
    }
    passed_ = std::max(passed_, now);
  }

  void start(Cycle now, unsigned p) {
    Model& pins = model_.pins();
    const auto id = static_cast<LaneId>(get_bits(pins.start_ray, p * kRayBits, kRayBits));
    if (order_.empty() || order_.front() != id) {
      rtl_fault(name(), place_of(id),
                "starts, but " + (order_.empty() ? "nobody" : place_of(order_.front())) + " is first in the queue");
    }
    order_.pop();
    Lane& lane = lanes_[id];
    put_bits(pins.start_tests, p * 4, 4, lane.tests);
    lane.started = counters_.operations++;
    counters_.tests += lane.tests;
    const Cycle occupied = Cycle{lane.tests} * config_.interval;
    counters_.busy_cycles += occupied;
    counters_.queue_cycles += now - lane.queued - 1;
    free_from_[p] = now + occupied;
  }

  void begin_test(unsigned p) {
    Model& pins = model_.pins();
    const auto id = static_cast<LaneId>(get_bits(pins.test_ray, p * kRayBits, kRayBits));
    const auto number = static_cast<unsigned>(get_bits(pins.test_number, p * 4, 4));
    const std::uint64_t seed = (std::uint64_t{lanes_[id].visit} << 16 | id) << 4 | number;
    flights_[p].push({id, number, number + 1 == lanes_[id].tests, Block::begin(pins, p, seed, children_)});
  }

  void take_result(unsigned p) {
    const Model& pins = model_.pins();
    const auto id = static_cast<LaneId>(get_bits(pins.result_ray, p * kRayBits, kRayBits));
    const auto number = static_cast<unsigned>(get_bits(pins.result_number, p * 4, 4));
    const bool last = get_bits(pins.result_last, p, 1) != 0;
    if (flights_[p].empty()) refuse(id, number, "has a result, but has not begun");
    const Flight& flight = flights_[p].front();
    if (flight.lane != id || flight.number != number || flight.last != last) {
      refuse(id, number, "has a result before " + place_of(flight.lane));
    }
    const std::string fault = Block::fault_of(pins, p, flight.expected);
    if (!fault.empty()) refuse(id, number, fault);
    flights_[p].pop();
    if (last) results_.emplace_back(lanes_[id].started, id);
  }

  /// The pins; with disturbance, after random extra edges and with random values on pins that are not valid.
  Model& disturbed() {
    Model& pins = model_.pins();
    if (noise_ == 0) return pins;
    do {
      noise_ = split_mix(noise_);
      pins.push_ray = static_cast<LaneId>(noise_ % lanes_.size());
      for (unsigned p = 0; p < kCount; ++p) {
        put_bits(pins.start_tests, p * 4, 4, noise_ >> (4 * p));
        Block::disturb(pins, p, split_mix(noise_ ^ p));
      }
      if ((noise_ >> 40 & 3) == 0) model_.edge();
    } while ((noise_ >> 40 & 3) == 0);
    return pins;
  }

  void show(Cycle now) {
    const Model& pins = model_.pins();
    shown_in_ = now;
    shown_ = {pins.start_valid, pins.test_valid, pins.result_valid, pins.result_last};
    for (const std::uint64_t value : Block::values(pins)) shown_.push_back(value);
  }

  IntersectionConfig config_;
  DataPath path_;
  unsigned children_;
  intersection_client_if* client_ = nullptr;
  std::vector<Lane> lanes_;
  ClockedModel<Model> model_;
  std::uint64_t noise_;
  Cycle passed_ = 0;  ///< cycles that the block has been clocked through
  RingQueue<LaneId> order_;
  std::array<RingQueue<Flight>, kCount> flights_;
  std::array<Cycle, kCount> free_from_{};
  std::vector<std::pair<std::uint64_t, LaneId>> results_;  ///< results of this cycle: (start number, lane)
  std::vector<RtlSignal> signals_ = {{"clk_edges", 32},        {"level", 11},           {"in_flight", 11},
                                     {"busy", kCount},         {"start_valid", kCount}, {"test_valid", kCount},
                                     {"result_valid", kCount}, {"result_last", kCount}};
  Cycle shown_in_ = kNever;
  std::vector<std::uint64_t> shown_;
  IntersectionCounters counters_;
};

}  // namespace

std::unique_ptr<IntersectionModule> make_verilated_ray_box(const char* name, const RtUnitContext& rt,
                                                           const RtlBenchOptions& options) {
  using Limits = IntersectionRtlLimits;
  const IntersectionConfig config = rt.config.ray_box;
  const unsigned entries = rt.config.warp_buffer.entries;
  const unsigned children = rt.config.box_op_per_child ? 1 : rt.header.bvh_width;
  const auto made = [&]<typename Block, unsigned kCount>(unsigned stages) {
    return std::make_unique<IntersectionRtl<Block, kCount>>(name, config, rt.config.box_path(rt.header), stages,
                                                            entries, children, options);
  };
  if (options.faulty_block) return made.template operator()<BoxBlock<Vray_box_faults, 2>, 1>(1);
  if (config.latency < Limits::kBoxSteps) {
    return made.template operator()<BoxBlock<Vray_box_flat, Limits::kBoxes>, Limits::kCount>(1);
  }
  if (config.latency >= Limits::kBoxDeep && config.count <= Limits::kDeepCount) {
    return made.template operator()<BoxBlock<Vray_box_deep, Limits::kBoxes>, Limits::kDeepCount>(Limits::kBoxDeep);
  }
  return made.template operator()<BoxBlock<Vray_box_staged, Limits::kBoxes>, Limits::kCount>(Limits::kBoxSteps);
}

std::unique_ptr<IntersectionModule> make_verilated_ray_transform(const char* name, const RtUnitContext& rt,
                                                                 const RtlBenchOptions& options) {
  using Limits = IntersectionRtlLimits;
  const IntersectionConfig config = rt.config.transform_unit(rt.header);
  const unsigned entries = rt.config.warp_buffer.entries;
  const auto made = [&]<typename Block, unsigned kCount>(unsigned stages) {
    return std::make_unique<IntersectionRtl<Block, kCount>>(name, config, rt.config.transform_path(rt.header), stages,
                                                            entries, 1, options);
  };
  if (options.faulty_block) return made.template operator()<TransformBlock<Vray_transform_faults>, 1>(1);
  if (config.latency < Limits::kTransformSteps) {
    return made.template operator()<TransformBlock<Vray_transform_flat>, Limits::kCount>(1);
  }
  if (config.latency >= Limits::kTransformDeep && config.count <= Limits::kDeepCount) {
    return made.template operator()<TransformBlock<Vray_transform_deep>, Limits::kDeepCount>(Limits::kTransformDeep);
  }
  return made.template operator()<TransformBlock<Vray_transform_staged>, Limits::kCount>(Limits::kTransformSteps);
}

}  // namespace grtx::sim
