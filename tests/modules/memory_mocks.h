// SPDX-License-Identifier: Apache-2.0
// Producers and consumers that stand on the other side of the memory modules' links in tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/split_mix.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/messages/memory_request.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {

/// Tests are the same on every host.
class Random : public SplitMix64 {
 public:
  using SplitMix64::SplitMix64;
  std::uint64_t below(std::uint64_t bound) { return next() % bound; }
  bool chance(unsigned percent) { return below(100) < percent; }
};

/// A request port and its response port, with the links between them.
struct PortLinks {
  PortLinks(const std::string& name, std::size_t capacity = 8, unsigned latency = 1)
      : request(name + ".request", latency, capacity), response(name + ".response", latency, capacity) {}
  Link<MemoryRequest> request;
  Link<MemoryResponse> response;
};

/// Sends requests in order, each as early as its given cycle allows, and takes one response a cycle.
class MockClient {
 public:
  MockClient(const std::string& name, ClockDomain& clock, PortLinks& links)
      : clock_(clock), links_(links), process_(name.c_str(), clock, [this](Cycle now) { tick(now); }) {
    process_.watch(links.response);
  }

  /// The consumer sees the request at `visible` when nothing is in the way. Tags are given in order, from 0.
  std::uint32_t at(Cycle visible, MemoryRequest request) {
    request.tag = next_tag_++;
    const Cycle latency = links_.request.latency();
    script_.push_back({visible - latency, request});
    clock_.request(visible - latency);
    return request.tag;
  }
  std::uint32_t read(Cycle visible, std::uint64_t address, Region region = Region::tlas) {
    return at(visible, {.address = address, .region = region});
  }
  std::uint32_t write(Cycle visible, std::uint64_t address, Region region = Region::k_buffer) {
    return at(visible, {.address = address, .region = region, .write = true});
  }
  std::uint32_t prefetch(Cycle visible, std::uint64_t address) {
    return at(visible, {.address = address, .prefetch = true});
  }

  struct Answer {
    Cycle cycle = 0;  ///< at which the response was visible and taken
    MemoryResponse response;
  };
  const std::vector<Answer>& answers() const { return answers_; }
  /// Cycle of the response with a tag; kNever when it did not come.
  Cycle answered(std::uint32_t tag) const {
    const auto found =
        std::find_if(answers_.begin(), answers_.end(), [&](const Answer& a) { return a.response.tag == tag; });
    return found == answers_.end() ? kNever : found->cycle;
  }
  /// Every tag has been answered exactly once.
  bool complete() const {
    std::vector<int> seen(next_tag_, 0);
    for (const Answer& a : answers_) ++seen.at(a.response.tag);
    return std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; });
  }
  std::uint32_t sent() const { return next_tag_; }

  /// Whether responses are taken in a cycle; must depend on the cycle only.
  std::function<bool(Cycle)> takes = [](Cycle) { return true; };
  /// Called for every response, to send more.
  std::function<void(Cycle, const MemoryResponse&)> on_response;

 private:
  void tick(Cycle now) {
    if (const MemoryResponse* r = links_.response.front(now); r != nullptr) {
      if (takes(now)) {
        answers_.push_back({now, *r});
        links_.response.pop(now);
        if (on_response) on_response(now, answers_.back().response);
      }
      clock_.request(now + 1);
    }
    while (!script_.empty() && script_.front().first <= now && links_.request.can_push(now) && last_push_ != now + 1) {
      links_.request.push(now, script_.front().second);
      last_push_ = now + 1;
      clock_.request(now + links_.request.latency());
      script_.pop_front();
    }
    if (!script_.empty()) clock_.request(std::max(now + 1, script_.front().first));
  }

  ClockDomain& clock_;
  PortLinks& links_;
  std::deque<std::pair<Cycle, MemoryRequest>> script_;
  std::vector<Answer> answers_;
  std::uint32_t next_tag_ = 0;
  Cycle last_push_ = 0;  ///< cycle of the last push + 1
  TickProcess process_;
};

/// Answers every request `latency` cycles after it became visible (as seen by the requester), one per cycle.
class MockMemory {
 public:
  MockMemory(const std::string& name, ClockDomain& clock, Link<MemoryRequest>& in, Link<MemoryResponse>& out,
             Cycle latency)
      : clock_(clock),
        in_(in),
        out_(out),
        latency_(latency - out.latency()),
        process_(name.c_str(), clock, [this](Cycle now) { tick(now); }) {
    process_.watch(in);
  }

  struct Arrival {
    Cycle cycle = 0;
    MemoryRequest request;
  };
  const std::vector<Arrival>& arrivals() const { return arrivals_; }
  /// Whether requests are taken, and responses are sent, in a cycle; must depend on the cycle only.
  std::function<bool(Cycle)> takes = [](Cycle) { return true; };
  std::function<bool(Cycle)> answers = [](Cycle) { return true; };

 private:
  void tick(Cycle now) {
    if (const MemoryRequest* r = in_.front(now); r != nullptr) {
      if (takes(now)) {
        arrivals_.push_back({now, *r});
        pending_.push_back({now + latency_, response_to(*r)});
        in_.pop(now);
      }
      clock_.request(now + 1);
    }
    if (!pending_.empty() && pending_.front().first <= now && out_.can_push(now) && answers(now)) {
      out_.push(now, pending_.front().second);
      clock_.request(now + out_.latency());
      pending_.pop_front();
    }
    if (!pending_.empty()) clock_.request(std::max(now + 1, pending_.front().first));
  }

  ClockDomain& clock_;
  Link<MemoryRequest>& in_;
  Link<MemoryResponse>& out_;
  Cycle latency_;
  std::deque<std::pair<Cycle, MemoryResponse>> pending_;
  std::vector<Arrival> arrivals_;
  TickProcess process_;
};

}  // namespace grtx::modules
