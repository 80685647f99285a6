#include "rtl_tlm/waveform.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <bit>
#include <charconv>

#include "base/error.h"
#include "modules/intersection_unit.h"
#include "modules/warp_buffer.h"

namespace grtx::tlm {
namespace {

using modules::Warp;
using modules::WarpBuffer;

/// What a warp of the warp buffer waits for: the most advanced thing that any of its lanes can do.
enum class WarpState : std::uint8_t { free, ready, memory, unit, checkpoint, any_hit, finished };
const std::vector<std::string> kWarpStateNames = {"free",       "ready",   "memory",  "unit",
                                                  "checkpoint", "any_hit", "finished"};

WarpState state_of(const Warp& warp) {
  using modules::LaneState;
  if (warp.in_state(LaneState::ready) != 0) return WarpState::ready;
  if (warp.in_state(LaneState::waiting_memory) != 0) return WarpState::memory;
  if (warp.in_state(LaneState::in_unit) != 0) return WarpState::unit;
  if ((warp.in_state(LaneState::waiting_checkpoint_read) | warp.in_state(LaneState::waiting_checkpoint_write)) != 0) {
    return WarpState::checkpoint;
  }
  if ((warp.in_state(LaneState::waiting_any_hit) | warp.in_state(LaneState::in_any_hit)) != 0)
    return WarpState::any_hit;
  return WarpState::finished;
}

unsigned width_for(std::uint64_t largest) {
  return static_cast<unsigned>(std::max(1, static_cast<int>(std::bit_width(largest))));
}

/// The signal itself or a scope around it matches.
bool selected(const std::string& pattern, const std::string& name) {
  for (std::size_t end = name.size(); end != std::string::npos; end = name.rfind('.', end - 1)) {
    if (::fnmatch(pattern.c_str(), name.substr(0, end).c_str(), 0) == 0) return true;
    if (end == 0) break;
  }
  return false;
}

/// A part of the RT unit by its name, or nullptr when this configuration does not elaborate it.
template <typename T>
const T* part(const Sm& sm, const char* name) {
  return dynamic_cast<const T*>(sc_core::sc_find_object(fmt::format("{}.{}", sm.rt().name(), name).c_str()));
}

bool parse_cycle(const std::string& text, Cycle& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

void parse_window(const std::string& text, WaveformOptions& options) {
  const std::size_t colon = text.find(':');
  const std::string first = text.substr(0, colon);
  const std::string last = colon == std::string::npos ? "" : text.substr(colon + 1);
  const bool ok = colon != std::string::npos && (first.empty() || parse_cycle(first, options.first)) &&
                  (last.empty() || parse_cycle(last, options.last)) && options.first <= options.last;
  if (!ok) throw Error("--vcd-window", text, "must be A:B in core cycles with A <= B; either may be left out");
}

Waveform::Waveform(const sc_core::sc_module_name& name, const WaveformOptions& options, const Gpu& gpu,
                   const modules::Dram& dram, const std::string& comment)
    : sc_module(name), options_(options), gpu_(gpu), writer_(options.path), comment_(comment) {
  probe("gpu.cycle", 48, [&gpu] { return gpu.core().cycle(); });
  probe("gpu.distributor.running", 16, [&gpu] { return gpu.distributor().running(); });
  for (std::size_t i = 0; i < gpu.sms().size(); ++i) {
    const Sm& sm = *gpu.sms()[i];
    const std::string scope = fmt::format("gpu.sm{}", i);
    probe(scope + ".simt.resident", 7, [&sm] { return sm.simt().resident(); });
    probe(scope + ".simt.busy", 1, [&sm] { return !sm.simt().idle(); });
    probe_rt_unit(scope + ".rt", sm);
    probe(scope + ".l1d.busy", 1, [&sm] { return !sm.l1().idle(); });
    probe(scope + ".l1d.mshr", 16, [&sm] { return sm.l1().mshr_used(); });
  }
  probe("gpu.crossbar.busy", 1, [&gpu] { return !gpu.crossbar().idle(); });
  for (std::size_t i = 0; i < gpu.slices().size(); ++i) {
    const modules::L2Slice& slice = *gpu.slices()[i];
    const std::string scope = fmt::format("gpu.l2.slice{}", i);
    probe(scope + ".busy", 1, [&slice] { return !slice.idle(); });
    probe(scope + ".dram_outstanding", 16, [&slice] { return slice.dram.outstanding(); });
  }
  probe("gpu.dram.busy", 1, [&dram] { return !dram.idle(); });
  if (probes_.empty()) throw Error("--vcd-scope", options.scope, "matches no signal; scopes begin with gpu");

  SC_METHOD(on_tick);
  sensitive << gpu.core().tick();
  dont_initialize();
  SC_METHOD(sample);
  sensitive << settled_;
  dont_initialize();
}

void Waveform::probe(const std::string& name, unsigned width, Sample sample,
                     const std::vector<std::string>& enumeration) {
  if (selected(options_.scope, name)) probes_.push_back({writer_.declare(name, width, enumeration), std::move(sample)});
}

void Waveform::probe_rt_unit(const std::string& scope, const Sm& sm) {
  const auto* buffer = part<WarpBuffer>(sm, "warp_buffer");
  if (buffer == nullptr) throw std::logic_error("the RT unit has no warp buffer");
  probe(scope + ".warps", width_for(buffer->entries()),
        [buffer] { return static_cast<std::uint64_t>(std::popcount(buffer->occupied())); });
  for (std::size_t s = 0; s < modules::kLaneStates; ++s) {
    const auto state = static_cast<modules::LaneState>(s);
    if (state == modules::LaneState::idle || state == modules::LaneState::finished) continue;
    probe(fmt::format("{}.lanes.{}", scope, modules::kLaneStateNames[s]),
          width_for(std::uint64_t{buffer->entries()} * modules::kMaxLanes), [buffer, state] {
            std::uint64_t lanes = 0;
            modules::for_each_bit(buffer->occupied(), [&](unsigned entry) {
              lanes += static_cast<std::uint64_t>(std::popcount(buffer->warp(entry).in_state(state)));
            });
            return lanes;
          });
  }
  for (unsigned entry = 0; entry < buffer->entries(); ++entry) {
    const std::string warp = fmt::format("{}.warp_buffer.w{}", scope, entry);
    const auto occupied = [buffer, entry] { return (buffer->occupied() >> entry & 1) != 0; };
    probe(
        warp + ".state", 3,
        [buffer, entry, occupied] {
          return static_cast<std::uint64_t>(occupied() ? state_of(buffer->warp(entry)) : WarpState::free);
        },
        kWarpStateNames);
    probe(warp + ".active", modules::kMaxLanes,
          [buffer, entry, occupied] { return occupied() ? buffer->warp(entry).active() : LaneMask{0}; });
    probe(warp + ".slot", 6, [buffer, entry, occupied] {
      return occupied() ? std::uint64_t{buffer->warp(entry).slot} : std::uint64_t{0};
    });
    probe(warp + ".round", 32, [buffer, entry, occupied] {
      return occupied() ? std::uint64_t{buffer->warp(entry).round} : std::uint64_t{0};
    });
  }
  for (const char* name : {"ray_box", "ray_triangle", "ray_sphere", "ray_transform"}) {
    const auto* unit = part<modules::IntersectionUnit>(sm, name);
    if (unit != nullptr) probe(fmt::format("{}.{}.busy", scope, name), 1, [unit] { return !unit->idle(); });
  }
}

void Waveform::on_tick() {
  const Cycle cycle = gpu_.core().cycle();
  if (cycle >= options_.first && cycle <= options_.last) settled_.notify(sc_core::SC_ZERO_TIME);
}

void Waveform::sample() {
  const Cycle cycle = gpu_.core().cycle();
  const std::uint64_t time = cycle * gpu_.core().period_fs();
  if (begun_) writer_.advance(time);
  for (const Probe& p : probes_) writer_.set(p.signal, p.sample());
  if (!begun_) {
    writer_.begin(comment_, time);
    begun_ = true;
  }
}

void Waveform::finish(Cycle end) {
  const std::uint64_t time = std::min(end, options_.last) * gpu_.core().period_fs();
  if (!begun_) writer_.begin(comment_ + "\nthe run ended before the window", time);
  writer_.finish(time);
}

}  // namespace grtx::tlm
