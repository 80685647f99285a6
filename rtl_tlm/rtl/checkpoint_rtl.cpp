// SPDX-License-Identifier: Apache-2.0
// The checkpoint unit as RTL behind checkpoint_if: calls become transfers at the pins of checkpoint_unit.sv, and back.
// The bytes and t values of entries, which the trace does not contain, are generated here, and what the block returns
// is checked against them. Compiled only if Verilator was found. docs/model/rtl_bridge.md lists every pin.
#include <Vcheckpoint_faults.h>
#include <Vcheckpoint_faults___024root.h>
#include <Vcheckpoint_lanes32.h>
#include <Vcheckpoint_lanes32___024root.h>
#include <Vcheckpoint_lanes4.h>
#include <Vcheckpoint_lanes4___024root.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <ostream>
#include <span>
#include <string>
#include <unordered_map>

#include "grtx/base/error.h"
#include "grtx/base/split_mix.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_layout.h"
#include "grtx/rtl_tlm/rtl/clocked_model.h"
#include "grtx/rtl_tlm/rtl/rtl_fault.h"
#include "grtx/rtl_tlm/rtl/rtl_signals.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"

namespace grtx::sim {

using namespace modules;

namespace {

constexpr unsigned kEntryBytes = 28;                        ///< largest entry size
static_assert(std::endian::native == std::endian::little);  // wide pins are arrays of words, lowest first
constexpr std::uint32_t kInfinity = 0x7f800000;

/// t values as fp32 bits.
struct EntryTimes {
  std::uint32_t t = 0, t_min = 0, t_max = 0;
};
/// A submitted entry as bytes, and the t values it is validated with.
struct EntryBits {
  std::array<std::uint8_t, kEntryBytes> bytes{};
  EntryTimes times;
};

/// Entry `index` of generation `generation`: random, but with t_min <= t_max < t, often by one ulp.
EntryBits entry_bits(unsigned entry_bytes, std::uint64_t generation, std::uint32_t index) {
  EntryBits entry;
  const std::uint64_t seed = split_mix(generation * 0x100000001b3u + index);
  const std::uint64_t t = split_mix(seed), more = split_mix(t);
  // Non-negative floats are ordered like their bits.
  EntryTimes& times = entry.times;
  times.t_max = static_cast<std::uint32_t>(t % kInfinity);
  times.t_min = t >> 60 == 0 ? 0x80000000u : static_cast<std::uint32_t>((t >> 32) % (times.t_max + 1u));
  const std::uint32_t above = kInfinity - times.t_max;
  times.t = times.t_max + 1 + static_cast<std::uint32_t>(more >> 62 == 0 ? 0 : more % above);
  for (unsigned i = 0; i < kEntryBytes; i += 4) {
    const auto word = static_cast<std::uint32_t>(split_mix(seed + i + 1));
    std::memcpy(&entry.bytes[i], &word, sizeof word);
  }
  // t is the last or the first word of an entry (docs/model/checkpoint_unit.md, layouts).
  const unsigned place = entry_bytes == 20 || entry_bytes == 28 ? entry_bytes - 4 : 0;
  std::memcpy(&entry.bytes[place], &times.t, sizeof times.t);
  return entry;
}

std::string hexadecimal(std::uint64_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  do {
    text.insert(text.begin(), kDigits[value % 16]);
    value /= 16;
  } while (value != 0);
  return "0x" + text;
}

/// Model: the class that Verilator generated for checkpoint_unit.sv with kLanes lanes.
template <typename Model, unsigned kLanes>
class CheckpointRtl final : public CheckpointModule, public CheckpointState, public RtlSignals {
 public:
  CheckpointRtl(const sc_core::sc_module_name& name, const RtUnitContext& rt, const RtlBenchOptions& options)
      : CheckpointModule(name),
        config_(rt.config.checkpoint),
        map_(rt.map),
        header_(rt.header),
        sm_(rt.sm),
        rays_(std::size_t{rt.config.warp_buffer.entries} * kMaxLanes),
        model_("checkpoint_unit"),
        noise_(options.disturbance) {
    require_allowed("rt.checkpoint", config_);
    CheckpointLayout(config_, rt.header);  // throws Error for an impossible configuration
    if (rt.map.checkpoint_entry_bytes() != config_.entry_bytes) {
      throw Error("configuration", "rt.checkpoint.entry_bytes", "must be those of the memory map");
    }
    const std::uint64_t first = map_.ray_slot(sm_, 0, 0);
    base_ = first_byte(first);
    Model& pins = model_.pins();
    pins.cfg_lanes = static_cast<std::uint8_t>(config_.lanes);
    pins.cfg_write_queue = static_cast<std::uint8_t>(config_.write_queue);
    pins.cfg_write_combine = config_.write_combine;
    pins.cfg_read_buffer = config_.read_buffer;
    pins.cfg_base0 = base_;
    pins.cfg_entry_bytes = static_cast<std::uint8_t>(config_.entry_bytes);
    pins.cfg_base1 = map_.checkpoint_entry(first, 1, 0);
    pins.cfg_size = static_cast<std::uint16_t>(rt.header.checkpoint_capacity);
    if constexpr (requires { pins.fault; }) pins.fault = static_cast<std::uint8_t>(options.fault);
    model_.reset();
  }

  void begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, bool replays, std::uint32_t,
                  const traces::Ray&) override {
    Ray& ray = rays_[id];
    const std::size_t number = std::size_t{slot} * kMaxLanes + lane_of(id);
    ray = {};
    ray.offset = first_byte(map_.ray_slot(sm_, slot, lane_of(id))) - base_;
    ray.parity = (round & 1) != 0;
    if (generations_.size() < (number + 1) * 2) generations_.resize((number + 1) * 2);
    generations_[number * 2 + (round & 1)] = ++last_generation_;
    ray.destination = last_generation_;
    ray.source = generations_[number * 2 + ((round & 1) ^ 1)];
    Model& pins = disturbed();
    pins.begin_valid = 1;
    pins.begin_ray = id;
    pins.begin_replay = replays;
    clock();
    pins.begin_valid = 0;
  }

  bool needs_source_entries() const override { return false; }  // the RTL reads buffers from the front

  bool submit(LaneId id, unsigned entries, bool last) override {
    Model& pins = disturbed();
    pins.submit_valid = 1;
    pins.submit_ray = id;
    pins.submit_entries = static_cast<std::uint8_t>(entries);
    pins.submit_last = last;
    Ray& ray = rays_[id];
    model_.settle();
    if (pins.submit_overflow) CheckpointLayout::refuse("writes");
    counters_.max_entries = std::max<std::uint64_t>(counters_.max_entries, pins.submit_end);
    const bool waits = pins.submit_wait;
    if (waits) {
      ray.pending = static_cast<std::uint8_t>(entries);
      ray.last = last;
      ray.submitted = true;
      clock();
    }
    pins.submit_valid = 0;
    return waits;
  }

  bool read(LaneId id) override {
    Model& pins = disturbed();
    pins.read_valid = 1;
    pins.read_ray = id;
    model_.settle();
    if (pins.read_refused) CheckpointLayout::refuse("reads");
    ++counters_.entries_read;
    if (pins.read_straddles) ++counters_.straddling_read;
    look();  // this read may be the next in the queue
    model_.settle();
    const bool done = pins.read_done;
    if (done) take_part();
    clock();
    pins.read_valid = 0;
    return done;
  }

  void respond(Cycle now) override {
    const MemoryResponse* answer = responses_.front(now);
    if (answer == nullptr) return;
    Model& pins = disturbed();
    pins.rsp_valid = 1;
    pins.rsp_write = answer->write;
    put_bits(pins.rsp_tag, 0, kTagBits, answer->tag);
    const Sector& sector = memory_[answer->address];
    std::memcpy(&pins.rsp_data[0], sector.bytes.data(), kSectorBytes);
    responses_.pop(now);
    model_.settle();
    const bool write = pins.rsp_write;
    const bool done = !write && part_done();
    const LaneId id = pins.part_ray;
    ++(write ? counters_.acknowledged : counters_.returned);
    if (!write) take_part();
    clock();
    pins.rsp_valid = 0;
    if (done) client_->entry_read(id);
  }

  void issue(Cycle now) override {
    requested_ = false;
    if (!busy() || !requests_.can_push(now)) return;
    Model& pins = disturbed();
    look();
    model_.settle();
    if (!pins.req_valid) return;
    requested_ = true;
    MemoryRequest message;
    message.region = Region::checkpoint;
    message.address = pins.req_address;
    message.tag = pins.req_tag;
    message.write = pins.req_write;
    if (message.write) {
      Sector& sector = memory_[message.address];
      std::array<std::uint8_t, kSectorBytes> data;
      std::memcpy(data.data(), &pins.req_data[0], kSectorBytes);
      for (unsigned i = 0; i < kSectorBytes; ++i) {
        if ((pins.req_mask >> i & 1) != 0) sector.bytes[i] = data[i];
      }
    }
    requests_.push(now, message);
    ++(message.write ? counters_.sectors_written : counters_.sectors_read);
  }

  void accept(Cycle now) override {
    Model& pins = model_.pins();
    const bool submitted = pins.submitted_level != 0;
    if (!submitted && !requested_) return;
    if (stuck_ && !requested_) {  // nothing can move, as in the previous cycle, so no clock edge is needed
      ++counters_.blocked_cycles;
      return;
    }
    // Idle edges, if any, come first; the following edge transfers this cycle's request and items.
    disturbed();
    look();
    pins.req_ready = requested_;
    const unsigned items = offer();
    if (submitted) {  // otherwise no output is read
      model_.settle();
      check_validation();
    }
    std::array<LaneId, kLanes> done{};
    unsigned count = 0;
    for (unsigned i = 0; i < items; ++i) {
      if (get_bits(pins.item_ready, i, 1) == 0) break;
      const LaneId id = items_[i];
      Ray& ray = rays_[id];
      if (get_bits(pins.item_entry, i, 1) != 0) {
        --ray.pending;
        ++ray.written;
        ++counters_.entries_written;
      }
      if (get_bits(pins.item_straddles, i, 1) != 0) ++counters_.straddling_written;
      if (get_bits(pins.item_done, i, 1) != 0) {
        ray.submitted = false;
        done[count++] = id;
      }
    }
    stuck_ = submitted && get_bits(pins.item_ready, 0, 1) == 0;
    show(now);
    clock();
    pins.req_ready = 0;
    pins.item_valid = 0;
    requested_ = false;
    for (unsigned i = 0; i < count; ++i) client_->entries_taken(done[i]);
    if (submitted && pins.submitted_level != 0) ++counters_.blocked_cycles;
  }

  bool busy() const override { return model_->busy; }
  bool idle() const override { return model_->idle; }
  std::uint64_t progress() const override {
    return counters_.sectors_read + counters_.sectors_written + counters_.acknowledged + counters_.returned;
  }
  Inventory inventory() const override { return checkpoint_inventory(name(), config_, rays_.size(), header_); }
  void dump_state(std::ostream& out) const override {
    out << name() << " (RTL): " << lanes_submitting() << " lanes handing over, " << lanes_reading()
        << " lanes to read, " << writes_queued() << " sectors to write, " << outstanding() << " requests outstanding, "
        << model_.edges() << " clock edges\n";
  }

  std::size_t lanes() const override { return rays_.size(); }
  std::size_t lanes_submitting() const override { return model_->submitted_level; }
  std::size_t lanes_reading() const override { return model_->reads_level; }
  std::size_t writes_queued() const override { return model_->writes_level; }
  std::uint64_t outstanding() const override { return model_->outstanding; }
  std::uint32_t source_offset(LaneId id) const override {
    return model_->rootp->checkpoint_unit__DOT__source_offset[id];
  }
  std::uint32_t destination_offset(LaneId id) const override {
    return model_->rootp->checkpoint_unit__DOT__destination_offset[id] + std::uint32_t{rays_[id].pending};
  }
  CheckpointCounters counters() const override { return counters_; }

  const std::vector<RtlSignal>& rtl_signals() const override {
    static const std::vector<RtlSignal> signals = {
        {"clk_edges", 32},      {"req_valid"},           {"req_write"},
        {"req_address", 48},    {"item_valid", kLanes},  {"item_ready", kLanes},
        {"item_done", kLanes},  {"item_beyond", kLanes}, {"item_straddles", kLanes},
        {"submitted_head", 10}, {"reads_head", 10},      {"write_head", 6},
        {"next_second"}};
    return signals;
  }
  std::uint64_t rtl_value(std::size_t index, Cycle now) const override {
    const auto& root = *model_->rootp;
    switch (index) {
      case 0:
        return model_.edges();
      case 9:
        return root.checkpoint_unit__DOT__submitted_head;
      case 10:
        return root.checkpoint_unit__DOT__reads_head;
      case 11:
        return root.checkpoint_unit__DOT__write_head;
      case 12:
        return root.checkpoint_unit__DOT__next_second;
      default:
        return shown_in_ == now ? shown_[index] : 0;
    }
  }

 private:
  static constexpr unsigned kRayBits = 10, kTagBits = kRayBits + 1;
  static_assert(1u << kRayBits == CheckpointRtlLimits::kWarps * kMaxLanes);

  struct Ray {
    std::uint64_t offset = 0;  ///< byte offset of its buffers from the base addresses
    bool parity = false;
    std::uint64_t source = 0, destination = 0;  ///< generations of the buffers' contents
    std::uint32_t written = 0;                  ///< entries accepted in this round
    std::uint8_t pending = 0;                   ///< entries submitted, not accepted yet
    bool last = false;
    bool submitted = false;     ///< has items that are not accepted yet
    std::uint32_t arrived = 0;  ///< source entries received
    std::uint32_t part_mask = 0;
    std::array<std::uint8_t, kEntryBytes> part{};
  };
  struct Sector {
    std::array<std::uint8_t, kSectorBytes> bytes{};
  };

  void end_of_elaboration() override {
    client_ = client.operator->();
    requests_ = writer_of(request);
    responses_ = reader_of(response);
  }

  [[noreturn]] void refuse(LaneId id, const std::string& rule) const {
    rtl_fault(name(), "warp " + std::to_string(entry_of(id)) + " lane " + std::to_string(lane_of(id)), rule);
  }

  void clock() { model_.edge(); }

  /// First byte of a resident ray's buffers.
  std::uint64_t first_byte(std::uint64_t ray_slot) const { return map_.checkpoint_entry(ray_slot, 0, 0); }

  /// Whether the transfer now at the pins completes the entry.
  bool part_done() const { return model_->part_valid && model_->part_done; }

  /// The pins; with disturbance, after random extra edges and with random values on pins that are not valid.
  Model& disturbed() {
    Model& pins = model_.pins();
    if (noise_ == 0) return pins;
    do {
      noise_ = split_mix(noise_);
      const auto ray = static_cast<LaneId>(noise_ % rays_.size());
      pins.begin_ray = pins.submit_ray = pins.read_ray = ray;
      pins.begin_replay = noise_ >> 20 & 1;
      pins.submit_entries = noise_ >> 21 & 255;
      pins.submit_last = noise_ >> 29 & 1;
      pins.rsp_tag = ray;
      pins.rsp_write = noise_ >> 30 & 1;
      for (unsigned i = 0; i < kSectorBytes * 8; i += 64) put_bits(pins.rsp_data, i, 64, split_mix(noise_ + i));
      for (unsigned i = 0; i < kLanes; ++i) {
        const std::uint64_t more = split_mix(noise_ ^ i);
        put_bits(pins.item_ray, i * kRayBits, kRayBits, more % rays_.size());
        put_bits(pins.item_entry, i, 1, more >> 20);
        put_bits(pins.item_end, i, 1, more >> 21);
        put_bits(pins.item_last, i, 1, more >> 22);
        put_bits(pins.item_parity, i, 1, more >> 23);
      }
      if ((noise_ >> 40 & 3) == 0) {
        model_.settle();
        clock();
      }
    } while ((noise_ >> 40 & 3) == 0);
    return pins;
  }

  /// Answers the block's lookup of the buffer addresses of the ray whose read is next; with bins, of the current read.
  void look() {
    Model& pins = model_.pins();
    const Ray& ray = rays_[pins.look_ray % rays_.size()];
    pins.look_parity = ray.parity;
    pins.look_offset = ray.offset;
  }

  /// Offers the items of the rays at the front of the queue; returns their number.
  unsigned offer() {
    Model& pins = model_.pins();
    unsigned item = 0;
    for (unsigned front = 0; front < kLanes && item < config_.lanes; ++front) {
      if (get_bits(pins.front_valid, front, 1) == 0) break;
      const auto id = static_cast<LaneId>(get_bits(pins.front_ray, front * kRayBits, kRayBits));
      if (id >= rays_.size() || !rays_[id].submitted) refuse(id, "is next in its queue, but has handed over nothing");
      const Ray& ray = rays_[id];
      // The open sector is offered with the last entry, or alone if that has been accepted.
      const unsigned count = std::max<unsigned>(ray.pending, 1);
      for (unsigned i = 0; i < count && item < config_.lanes; ++i, ++item) {
        items_[item] = id;
        put_bits(pins.item_valid, item, 1, 1);
        put_bits(pins.item_ray, item * kRayBits, kRayBits, id);
        put_bits(pins.item_parity, item, 1, ray.parity);
        put_bits(pins.item_offset, item * 48, 48, ray.offset);
        put_bits(pins.item_entry, item, 1, ray.pending != 0);
        put_bits(pins.item_end, item, 1, i + 1 == count);
        put_bits(pins.item_last, item, 1, ray.last);
        const EntryBits bits = entry_bits(config_.entry_bytes, ray.destination, ray.written + i);
        set_times(item, bits.times);
        std::memcpy(&pins.item_data[item * kEntryBytes / 4], bits.bytes.data(), kEntryBytes);
      }
    }
    // Unused comparators get random bits, equal values and zeros of both signs.
    for (unsigned other = item; other < kLanes; ++other) {
      const std::uint64_t any = split_mix(model_.edges() * 64 + other);
      const auto t = static_cast<std::uint32_t>(any);
      const auto t_max = static_cast<std::uint32_t>(any >> 32);
      switch (any % 5) {
        case 0:
          set_times(other, {t, t, t});
          break;
        case 1:
          set_times(other, {t & 0x80000000u, t_max & 0x80000000u, 0});
          break;
        case 2:
          set_times(other, {t, t + 1, t - 1});
          break;
        default:
          set_times(other, {t, t_max, ~t_max});
      }
    }
    return item;
  }

  void set_times(unsigned item, const EntryTimes& times) {
    Model& pins = model_.pins();
    put_bits(pins.item_t, item * 32, 32, times.t);
    put_bits(pins.item_t_min, item * 32, 32, times.t_min);
    put_bits(pins.item_t_max, item * 32, 32, times.t_max);
    times_[item] = times;
  }

  /// Checks the t-value validation of all lanes against the host's comparisons, which are those of the tracer.
  void check_validation() const {
    const Model& pins = model_.pins();
    for (unsigned i = 0; i < kLanes; ++i) {
      const auto [t, t_min, t_max] = times_[i];
      const bool before = std::bit_cast<float>(t) < std::bit_cast<float>(t_min);
      const bool beyond = std::bit_cast<float>(t_max) < std::bit_cast<float>(t);
      if ((get_bits(pins.item_before, i, 1) != 0) == before && (get_bits(pins.item_beyond, i, 1) != 0) == beyond) {
        continue;
      }
      rtl_fault(name(), "t-value validation " + std::to_string(i),
                "t = " + hexadecimal(t) + " with t_min = " + hexadecimal(t_min) + " and t_max = " + hexadecimal(t_max) +
                    " must be " +
                    (before   ? "before"
                     : beyond ? "beyond"
                              : "between"));
    }
  }

  /// Receives bytes of a source entry; once complete, they must equal those that were written.
  void take_part() {
    const Model& pins = model_.pins();
    if (!pins.part_valid) return;
    const LaneId id = pins.part_ray;
    Ray& ray = rays_[id];
    const std::uint32_t mask = pins.part_mask;
    std::array<std::uint8_t, kEntryBytes> came;
    std::memcpy(came.data(), &pins.part_data[0], kEntryBytes);
    for (unsigned b = 0; b < kEntryBytes; ++b) {
      if ((mask >> b & 1) != 0) ray.part[b] = came[b];
    }
    ray.part_mask |= mask;
    if (!pins.part_done) return;
    const std::uint32_t whole = (std::uint32_t{1} << config_.entry_bytes) - 1;
    const EntryBits expected = entry_bits(config_.entry_bytes, ray.source, ray.arrived);
    if (ray.part_mask != whole) {
      refuse(id, "source entry " + std::to_string(ray.arrived) + " has come with bytes " + hexadecimal(ray.part_mask) +
                     " in place of " + hexadecimal(whole));
    }
    for (unsigned b = 0; b < config_.entry_bytes; ++b) {
      if (ray.part[b] == expected.bytes[b]) continue;
      refuse(id, "source entry " + std::to_string(ray.arrived) + " is not what the round before wrote: byte " +
                     std::to_string(b) + " is " + hexadecimal(ray.part[b]) + " in place of " +
                     hexadecimal(expected.bytes[b]));
    }
    ++ray.arrived;
    ray.part_mask = 0;
  }

  void show(Cycle now) {
    const Model& pins = model_.pins();
    shown_in_ = now;
    shown_ = {0,
              std::uint64_t{pins.req_valid} & std::uint64_t{pins.req_ready},
              pins.req_write,
              pins.req_address,
              get_bits(pins.item_valid, 0, kLanes),
              get_bits(pins.item_ready, 0, kLanes),
              get_bits(pins.item_done, 0, kLanes),
              get_bits(pins.item_beyond, 0, kLanes),
              get_bits(pins.item_straddles, 0, kLanes)};
  }

  CheckpointConfig config_;
  const MemoryMap& map_;
  const traces::Header& header_;
  unsigned sm_;
  std::uint64_t base_ = 0;  ///< first byte of the first ray's buffer 0
  checkpoint_client_if* client_ = nullptr;
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  std::vector<Ray> rays_;
  ClockedModel<Model> model_;
  std::uint64_t noise_;
  std::vector<std::uint64_t> generations_;  ///< [warp slot, lane, buffer] generation last written
  std::uint64_t last_generation_ = 0;
  std::unordered_map<std::uint64_t, Sector> memory_;  ///< address -> contents written by the block
  std::array<LaneId, kLanes> items_{};                ///< [item] lane of the offered item
  std::array<EntryTimes, kLanes> times_{};
  bool requested_ = false;  ///< a request is sent in this cycle
  bool stuck_ = false;      ///< the write queue is full for the first item, and nothing has left it since
  Cycle shown_in_ = kNever;
  std::array<std::uint64_t, 9> shown_{};
  CheckpointCounters counters_;
};

}  // namespace

std::unique_ptr<CheckpointModule> make_verilated_checkpoint_unit(const char* name, const RtUnitContext& rt,
                                                                 const RtlBenchOptions& options) {
  if (options.faulty_block) return std::make_unique<CheckpointRtl<Vcheckpoint_faults, 4>>(name, rt, options);
  if (rt.config.checkpoint.lanes <= 4) return std::make_unique<CheckpointRtl<Vcheckpoint_lanes4, 4>>(name, rt, options);
  return std::make_unique<CheckpointRtl<Vcheckpoint_lanes32, 32>>(name, rt, options);
}

}  // namespace grtx::sim
