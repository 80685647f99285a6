// SPDX-License-Identifier: Apache-2.0
// An L1, a crossbar and L2 slices of somebody's own in the whole GPU: none of them keeps anything.
//   own_units TRACE.grtx
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/cache/l1_cache_if.h"
#include "grtx/modules/cache/l2_slice_if.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/noc/crossbar_if.h"
#include "grtx/modules/tlm/at_initiator.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

using namespace grtx::modules;
using grtx::Cycle;

class NoL1 final : public L1CacheModule {
 public:
  NoL1(const sc_core::sc_module_name& name, const L1CacheConfig& config, ClockDomain& clock)
      : L1CacheModule(name, clock, config.clients), sm_(config.sm), answers_(config.clients) {}
  L1Counters counters() const override { return counters_; }
  bool idle() const override { return inside_ == 0; }
  Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << inside_ << " inside\n"; }

 private:
  void end_of_elaboration() override {
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      requests_.push_back(reader_of(request[i]));
      requests_.back().wake(&alarm_);
      responses_.push_back(writer_of(response[i]));
    }
    down_ = writer_of(to_memory);
    up_ = reader_of(from_memory);
    up_.wake(&alarm_);
  }
  void restart(Caches) override {
    for (auto& answers : answers_) answers.clear();
    inside_ = 0;
    counters_ = {};
  }
  Cycle tick(Cycle now) override {
    if (const MemoryResponse* answer = up_.front(now)) {
      answers_[answer->client].push_back(*answer);
      up_.pop(now);
    }
    bool waiting = false;
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      if (!answers_[i].empty() && responses_[i].can_push(now)) {
        responses_[i].push(now, answers_[i].front());
        answers_[i].pop_front();
        --inside_;
        ++counters_.responses;
      }
      if (const MemoryRequest* head = requests_[i].front(now)) {
        if (down_.can_push(now)) take(now, i, *head);
        waiting = true;
      }
    }
    return inside_ > 0 || waiting ? now + 1 : kNever;
  }
  void take(Cycle now, std::size_t client, MemoryRequest request) {
    requests_[client].pop(now);
    request.client = static_cast<std::uint8_t>(client);
    request.sm = sm_;
    down_.push(now, request);
    ++inside_;
    RegionCounters& region = counters_.region[index(request.region)];
    if (request.write) {
      ++region.writes;
      ++counters_.sent_writes;
      return;
    }
    ++counters_.sent_reads;
    ++counters_.fills;
    if (request.prefetch) {
      ++counters_.prefetches;
      ++counters_.prefetches_fetched;
      return;
    }
    ++region.reads;
    ++region.misses;
  }

  std::uint8_t sm_;
  std::vector<LinkReader<MemoryRequest>> requests_;
  std::vector<LinkWriter<MemoryResponse>> responses_;
  LinkWriter<MemoryRequest> down_;
  LinkReader<MemoryResponse> up_;
  std::vector<std::deque<MemoryResponse>> answers_;
  std::uint64_t inside_ = 0;
  L1Counters counters_;
};

/// A packet of each input a cycle, as far as its output has room.
class Wires final : public CrossbarModule, public Clocked {
 public:
  Wires(const sc_core::sc_module_name& name, const CrossbarConfig& config, ClockDomain& clock)
      : CrossbarModule(name, config.sms, config.interleave.slices), config_(config), alarm_(clock, *this) {}
  CrossbarCounters counters() const override { return counters_; }
  bool idle() const override { return true; }
  Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": wires\n"; }

 private:
  template <typename Packet>
  struct Network {
    std::vector<LinkReader<Packet>> in;
    std::vector<LinkWriter<Packet>> out;
  };
  template <typename Packet, typename Ins, typename Outs>
  void bind(Network<Packet>& network, Ins& ins, Outs& outs) {
    for (auto& port : ins) {
      network.in.push_back(reader_of(port));
      network.in.back().wake(&alarm_);
    }
    for (auto& port : outs) network.out.push_back(writer_of(port));
  }
  void end_of_elaboration() override {
    bind(requests_, request_in, request_out);
    bind(replies_, response_in, response_out);
  }
  void restart(Caches) override { counters_ = {}; }
  template <typename Packet>
  bool pass(Cycle now, Network<Packet>& network, CrossbarCounters::Network& counters,
            const std::function<std::size_t(const Packet&)>& to) {
    bool any = false;
    for (auto& in : network.in) {
      const Packet* const head = in.front(now);
      if (head == nullptr) continue;
      any = true;
      auto& out = network.out[to(*head)];
      if (!out.can_push(now)) continue;
      out.push(now, *head);
      in.pop(now);
      ++counters.packets_in;
      ++counters.packets_out;
    }
    return any;
  }
  Cycle tick(Cycle now) override {
    bool any = pass<MemoryRequest>(now, requests_, counters_.request, [this](const MemoryRequest& request) {
      return std::size_t{config_.interleave.slice(request.address)};
    });
    any = pass<MemoryResponse>(now, replies_, counters_.reply,
                               [](const MemoryResponse& response) { return std::size_t{response.sm}; }) ||
          any;
    return any ? now + 1 : kNever;
  }

  CrossbarConfig config_;
  Network<MemoryRequest> requests_;
  Network<MemoryResponse> replies_;
  CrossbarCounters counters_;
  Alarm alarm_;
};

class NoL2 final : public L2SliceModule {
 public:
  NoL2(const sc_core::sc_module_name& name, const L2SliceConfig& config, ClockDomain& clock)
      : L2SliceModule(name, clock), dram_("dram", clock) {
    dram_.set_base(config.base);
  }
  ::tlm::tlm_initiator_socket<32>& memory_socket() override { return dram_.socket; }
  L2Counters counters() const override { return counters_; }
  bool idle() const override { return open_.empty() && replies_.empty() && dram_.idle() && in_.empty(); }
  std::uint64_t dirty_sectors() const override { return 0; }
  Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << open_.size() << " open\n"; }
  void hold_requests() override { dram_.hold(); }

 private:
  void end_of_elaboration() override {
    in_ = reader_of(request);
    out_ = writer_of(response);
    in_.wake(&alarm_);
    dram_.wake(&alarm_);
  }
  void restart(Caches) override {
    dram_.restart();
    open_.clear();
    replies_.clear();
    counters_ = {};
  }
  Cycle tick(Cycle now) override {
    dram_.update(now);
    while (const AtInitiator::Completion* done = dram_.front(now)) {
      if (!done->ok()) dram_.report_refusal(*done);
      const auto at =
          std::find_if(open_.begin(), open_.end(), [&](const Open& open) { return open.number == done->context; });
      replies_.push_back(response_to(at->request));
      open_.erase(at);
      dram_.pop();
    }
    const MemoryRequest* const head = in_.front(now);
    if (head != nullptr && dram_.can_send(now)) send(now, *head);
    if (!replies_.empty() && out_.can_push(now)) {
      out_.push(now, replies_.front());
      replies_.pop_front();
      ++counters_.replies_out;
    }
    const bool busy = in_.front(now) != nullptr || !replies_.empty() || dram_.front(now) != nullptr;
    return busy ? now + 1 : std::min(in_.next_visible(), dram_.next_visible());
  }
  void send(Cycle now, MemoryRequest request) {
    in_.pop(now);
    open_.push_back({next_, request});
    dram_.send(request.address, kSectorBytes, request.write, next_++, {request.sm, request.region});
    RegionCounters& region = counters_.region[index(request.region)];
    ++counters_.requests_in;
    ++(request.write ? region.writes : region.reads);
    if (!request.write) ++region.misses;
    ++(request.write ? counters_.dram_writes : counters_.dram_reads);
    ++(request.write ? counters_.dram_writes_of : counters_.dram_reads_of)[index(request.region)];
  }

  struct Open {
    std::uint32_t number;
    MemoryRequest request;
  };
  AtInitiator dram_;
  LinkReader<MemoryRequest> in_;
  LinkWriter<MemoryResponse> out_;
  std::deque<Open> open_;
  std::deque<MemoryResponse> replies_;
  std::uint32_t next_ = 0;
  L2Counters counters_;
};

int run(int argc, char** argv) {
  if (argc != 2) throw grtx::Error("own_units", "arguments", "TRACE.grtx");
  grtx::sim::SimulationOptions options;
  grtx::sim::GpuParts& parts = options.build.parts;
  parts.sm.l1_cache = [](const char* name, const L1CacheConfig& config, ClockDomain& clock) {
    return std::make_unique<NoL1>(name, config, clock);
  };
  parts.crossbar = [](const char* name, const CrossbarConfig& config, ClockDomain& clock) {
    return std::make_unique<Wires>(name, config, clock);
  };
  parts.l2_slice = [](const char* name, const L2SliceConfig& config, ClockDomain& clock) {
    return std::make_unique<NoL2>(name, config, clock);
  };
  const auto config = grtx::sim::load_config("", {"gpu.sms=2", "l2.slices=2"});
  const auto result = grtx::sim::simulate(argv[1], config, options);
  for (const std::string& violation : result.violations) std::printf("%s\n", violation.c_str());
  std::printf("%llu cycles\n", static_cast<unsigned long long>(result.cycles));
  return result.violations.empty() ? 0 : 1;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
