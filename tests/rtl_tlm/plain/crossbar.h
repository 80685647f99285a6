// SPDX-License-Identifier: Apache-2.0
// Plain crossbar network, used twice: docs/model/crossbar.md.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "rtl_tlm/plain/messages.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

class CrossbarNetwork {
 public:
  struct Config {
    unsigned latency;        ///< from an input to an output, link at the output included
    unsigned link_latency;   ///< of that link
    unsigned output_buffer;  ///< packets beyond those in transit
  };
  /// route: the output that a packet wants.
  CrossbarNetwork(const Config& config, std::vector<Channel<Access>*> inputs, std::vector<Channel<Access>*> outputs,
                  std::function<std::size_t(const Access&)> route)
      : config_(config),
        inputs_(std::move(inputs)),
        outputs_(std::move(outputs)),
        route_(std::move(route)),
        buffers_(outputs_.size()),
        last_winner_(outputs_.size(), inputs_.size() - 1) {}

  void tick(Cycle now) {
    std::vector<std::size_t> winners;
    for (std::size_t output = 0; output < outputs_.size(); ++output) arbitrate(now, output, winners);
    for (const std::size_t input : winners) {
      const Access packet = inputs_[input]->pop(now);
      buffers_[route_(packet)].emplace_back(now + config_.latency - config_.link_latency, packet);
    }
    for (std::size_t output = 0; output < outputs_.size(); ++output) {
      auto& buffer = buffers_[output];
      if (buffer.empty() || buffer.front().first > now || !outputs_[output]->has_room(now)) continue;
      outputs_[output]->push(now, buffer.front().second);
      buffer.pop_front();
      ++packets_;
    }
  }
  bool idle() const {
    for (const auto& buffer : buffers_) {
      if (!buffer.empty()) return false;
    }
    return true;
  }
  void report(Statistics& s, const std::string& prefix) const {
    s.add(prefix + ".packets", packets_);
    s.add(prefix + ".conflict_cycles", conflicts_);
    s.add(prefix + ".blocked_cycles", blocked_);
  }

 private:
  void arbitrate(Cycle now, std::size_t output, std::vector<std::size_t>& winners) {
    std::vector<std::size_t> wanting;  // beginning after the last winner
    for (std::size_t i = 1; i <= inputs_.size(); ++i) {
      const std::size_t input = (last_winner_[output] + i) % inputs_.size();
      const Access* head = inputs_[input]->front(now);
      if (head != nullptr && route_(*head) == output) wanting.push_back(input);
    }
    if (wanting.empty()) return;
    if (buffers_[output].size() >= config_.latency + config_.output_buffer) {
      blocked_ += wanting.size();
      return;
    }
    conflicts_ += wanting.size() - 1;
    last_winner_[output] = wanting.front();
    winners.push_back(wanting.front());
  }

  Config config_;
  std::vector<Channel<Access>*> inputs_, outputs_;
  std::function<std::size_t(const Access&)> route_;
  std::vector<std::deque<std::pair<Cycle, Access>>> buffers_;  ///< by output: when a packet may leave, oldest first
  std::vector<std::size_t> last_winner_;
  std::uint64_t packets_ = 0, conflicts_ = 0, blocked_ = 0;
};

}  // namespace grtx::sim::plain
