// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/waveform.h"

#include <fmt/format.h>

#include <algorithm>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/observe/gtkwave_files.h"

namespace grtx::sim {

std::string save_file_of(const std::string& vcd_path) {
  const std::string stem = vcd_path.ends_with(".vcd") ? vcd_path.substr(0, vcd_path.size() - 4) : vcd_path;
  return stem + ".gtkw";
}

Waveform::Waveform(const WaveformOptions& options, Gpu& gpu, const MemorySystem& memory, const traces::Header& header,
                   const std::string& comment)
    : options_(options),
      gpu_(gpu),
      memory_(memory),
      comment_(comment),
      writer_(options.path),
      wires_(writer_, options.scope, options.level, gpu.name()),
      observation_("waveform", gpu.core(), options.window, *this) {
  const auto add_link = [this](const auto& link) {
    using Probe = LinkProbe<std::decay_t<decltype(*link.front(0))>>;
    Probe probe(wires_, link.name(), link);
    if (probe.selected()) std::get<std::vector<Probe>>(links_).push_back(probe);
  };
  const std::string root = std::string(gpu.name()) + ".";
  cycle_ = wires_.add(root + "cycle", 48);
  launched_ = wires_.add(root + "distributor.launched", 32);
  running_ = wires_.add(root + "distributor.running", 16);
  for (const auto& sm : gpu.sms()) {
    const std::string scope = sm->name();
    for (const auto& rt : sm->rt_units()) rt_units_.emplace_back(wires_, rt->name(), *rt, header);
    // User-supplied units have no signals besides those of their links.
    if (const auto* simt = dynamic_cast<const modules::SimtCore*>(&sm->simt())) {
      simt_cores_.emplace_back(wires_, scope + ".simt", *simt);
    }
    if (const auto* l1 = dynamic_cast<const modules::L1Cache*>(&sm->l1())) {
      l1_caches_.emplace_back(wires_, scope + ".l1d", *l1);
    }
    sm->for_each_link(add_link);
  }
  gpu.for_each_link(add_link);
  crossbar_requests_ = wires_.add(root + "crossbar.requests", 48, WaveLevel::signals);
  crossbar_replies_ = wires_.add(root + "crossbar.replies", 48, WaveLevel::signals);
  for (const auto& slice : gpu.slices()) {
    if (const auto* own = dynamic_cast<const modules::L2Slice*>(slice.get())) {
      l2_slices_.emplace_back(wires_, slice->name(), *own);
    }
  }
  for (unsigned i = 0; i < memory.channels(); ++i) {
    dram_outstanding_.push_back(wires_.add(fmt::format("{}dram.channel{}.outstanding", root, i), 16));
  }
  for (MemoryProbe& probe : memory.probes()) {
    const std::size_t before = wires_.selected();
    const Wire wire = wires_.add(root + "dram." + probe.name, probe.width);
    if (wires_.selected() != before) memory_probes_.emplace_back(std::move(probe), wire);
  }
  add_own_probes(gpu);
  if (wires_.selected() == 0) {
    throw Error("--vcd-scope", options.scope, "matches no signal; scopes begin with gpu, sm0, l2_slice0 or dram");
  }
}

void Waveform::add_own_probes(const sc_core::sc_object& object) {
  const auto* const probed = dynamic_cast<const modules::Probed*>(&object);
  const auto shown = [probed](const RtUnitProbe& rt) { return rt.shows(*probed); };
  if (probed != nullptr && std::none_of(rt_units_.begin(), rt_units_.end(), shown)) {
    for (modules::UnitProbe& probe : probed->probes()) {
      const std::size_t before = wires_.selected();
      const Wire wire = add_probe(wires_, object.name(), probe);
      if (wires_.selected() != before) own_probes_.emplace_back(std::move(probe), wire);
    }
  }
  for (const sc_core::sc_object* const child : object.get_child_objects()) add_own_probes(*child);
}

void Waveform::sample(Cycle now) {
  const std::uint64_t time = gpu_.core().time_fs(now);
  if (writer_.begun()) writer_.advance(time);
  cycle_.set(now);
  launched_.set(gpu_.distributor().launched());
  running_.set(gpu_.distributor().running());
  for (RtUnitProbe& rt : rt_units_) rt.sample(now);
  for (SimtProbe& simt : simt_cores_) simt.sample();
  for (L1Probe& l1 : l1_caches_) l1.sample();
  for (L2Probe& slice : l2_slices_) slice.sample();
  const modules::CrossbarCounters crossbar = gpu_.crossbar().counters();
  crossbar_requests_.set(crossbar.request.packets_in);
  crossbar_replies_.set(crossbar.reply.packets_in);
  for (unsigned i = 0; i < dram_outstanding_.size(); ++i) dram_outstanding_[i].set(memory_.outstanding(i));
  for (auto& [probe, wire] : memory_probes_) wire.set(probe.value());
  for (auto& [probe, wire] : own_probes_) wire.set(probe.at(now));
  const auto sample_all = [now](auto& probes) {
    for (auto& probe : probes) probe.sample(now);
  };
  std::apply([&](auto&... probes) { (sample_all(probes), ...); }, links_);
  if (!writer_.begun() && options_.window.contains(now)) {
    writer_.begin(comment_, time);
    first_fs_ = time;
  }
  last_fs_ = time;
}

void Waveform::finish() {
  if (!writer_.begun()) {
    first_fs_ = last_fs_ = gpu_.core().time_fs(gpu_.distributor().end_cycle());
    writer_.begin(comment_ + "\nthe run ended before the window", last_fs_);
  }
  writer_.finish(last_fs_);
  write_gtkwave_files(options_.path, save_file_of(options_.path), writer_.signals(),
                      {first_fs_, last_fs_, gpu_.core().period_fs()});
}

}  // namespace grtx::sim
