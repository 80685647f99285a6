// SPDX-License-Identifier: Apache-2.0
// The whole memory hierarchy between mock clients: L1s, crossbar, L2 slices, DRAM, a protocol checker on every socket.
// The modules are constructed in an order of choice, which must not matter.
#pragma once

#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/noc/crossbar.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {

struct HierarchyBench {
  struct Config {
    unsigned sms = 8;
    AddressInterleave interleave{};
    L1Cache::Config l1{};
    Crossbar::Config crossbar{};
    L2Slice::Config l2{};
    Dram::Config dram{};
    bool idle_skip = true;
    bool checkers = true;
    bool clients = true;      ///< false: the caller drives client_links
    std::uint64_t order = 0;  ///< seed of the construction order; 0: down the hierarchy
  };

  explicit HierarchyBench(const Config& config)
      : core("core", 1365.0, config.idle_skip), memory("memory", 3500.0, config.idle_skip), config_(config) {
    const unsigned sms = config.sms;
    const unsigned slices = config.interleave.slices;
    const unsigned clients = config.l1.clients;
    for (unsigned i = 0; i < sms * clients; ++i) client_links.push_back(std::make_unique<PortLinks>("client"));
    for (unsigned i = 0; i < sms; ++i) sm_links.push_back(std::make_unique<PortLinks>("sm"));
    for (unsigned i = 0; i < slices; ++i) slice_links.push_back(std::make_unique<PortLinks>("slice", 16));
    if (config.clients) client.resize(sms * clients);
    l1.resize(sms);
    l2.resize(slices);
    checker.resize(slices);

    // One step a module, shuffled.
    std::vector<std::function<void()>> steps;
    for (unsigned i = 0; i < client.size(); ++i) {
      steps.push_back([this, i] {
        client[i] = std::make_unique<MockClient>("client" + std::to_string(i), core, *client_links[i]);
      });
    }
    for (unsigned i = 0; i < sms; ++i) {
      steps.push_back([this, i] {
        L1Cache::Config c = config_.l1;
        c.sm = static_cast<std::uint8_t>(i);
        l1[i] = std::make_unique<L1Cache>(("l1_" + std::to_string(i)).c_str(), c, core);
      });
    }
    steps.push_back([this] {
      Crossbar::Config c = config_.crossbar;
      c.sms = config_.sms;
      c.interleave = config_.interleave;
      crossbar = std::make_unique<Crossbar>("crossbar", c, core);
    });
    for (unsigned i = 0; i < slices; ++i) {
      steps.push_back([this, i] {
        L2Slice::Config c = config_.l2;
        c.slice = i;
        c.interleave = config_.interleave;
        l2[i] = std::make_unique<L2Slice>(("l2_" + std::to_string(i)).c_str(), c, core);
      });
      steps.push_back([this, i] {
        checker[i] = std::make_unique<AtProtocolChecker>(("checker" + std::to_string(i)).c_str(),
                                                         AtProtocolChecker::Config{.period_fs = core.period_fs()});
      });
    }
    steps.push_back([this] {
      Dram::Config c = config_.dram;
      c.interleave = config_.interleave;
      dram = std::make_unique<Dram>("dram", c, memory);
    });
    if (config.order != 0) {
      Random random(config.order);
      for (std::size_t i = steps.size(); i > 1; --i) std::swap(steps[i - 1], steps[random.below(i)]);
    }
    for (const auto& step : steps) step();

    for (unsigned i = 0; i < sms; ++i) {
      for (unsigned c = 0; c < clients; ++c) {
        l1[i]->request[c].bind(client_links[i * clients + c]->request);
        l1[i]->response[c].bind(client_links[i * clients + c]->response);
      }
      l1[i]->to_memory.bind(sm_links[i]->request);
      l1[i]->from_memory.bind(sm_links[i]->response);
      crossbar->request_in[i].bind(sm_links[i]->request);
      crossbar->response_out[i].bind(sm_links[i]->response);
    }
    for (unsigned i = 0; i < slices; ++i) {
      crossbar->request_out[i].bind(slice_links[i]->request);
      crossbar->response_in[i].bind(slice_links[i]->response);
      l2[i]->request.bind(slice_links[i]->request);
      l2[i]->response.bind(slice_links[i]->response);
      if (config.checkers) {
        l2[i]->dram.socket.bind(checker[i]->target);
        checker[i]->initiator.bind(dram->sockets[i]);
      } else {
        l2[i]->dram.socket.bind(dram->sockets[i]);
      }
    }
    if (!config.checkers) checker.clear();
  }

  /// Every request answered once; each level passed on exactly what the level above sent; nothing is in flight.
  void expect_conserved() const {
    L1Counters l1s;
    L2Counters l2s;
    std::uint64_t sent = 0;
    for (const auto& c : client) {
      EXPECT_TRUE(c->complete());
      sent += c->sent();
    }
    for (const auto& c : l1) {
      EXPECT_TRUE(c->idle());
      l1s += c->counters();
    }
    for (const auto& c : l2) {
      EXPECT_TRUE(c->idle());
      l2s += c->counters();
    }
    EXPECT_EQ(l1s.accesses(), sent);
    EXPECT_EQ(l1s.responses, sent);
    EXPECT_EQ(crossbar->counters().request.packets_out, l1s.sent_reads + l1s.sent_writes);
    EXPECT_EQ(l2s.accesses(), crossbar->counters().request.packets_out);
    EXPECT_EQ(crossbar->counters().reply.packets_out, l2s.replies_out);
    EXPECT_EQ(l2s.requests_in, l2s.replies_out);
    EXPECT_EQ(dram->counters().channel.reads, l2s.dram_reads);
    EXPECT_EQ(dram->counters().channel.writes, l2s.dram_writes);
    EXPECT_EQ(dram->counters().channel.responses, l2s.dram_reads + l2s.dram_writes);
    EXPECT_TRUE(crossbar->idle());
    EXPECT_TRUE(dram->idle());
    for (const auto& c : checker) {
      EXPECT_EQ(c->violations(), 0u) << c->messages().front();
      EXPECT_EQ(c->outstanding(), 0u);
    }
  }

  StatisticList statistics() const {
    StatisticList list;
    for (std::size_t i = 0; i < l1.size(); ++i) l1[i]->statistics(list, "gpu.sm" + std::to_string(i) + ".l1");
    crossbar->statistics(list, "gpu.crossbar");
    for (std::size_t i = 0; i < l2.size(); ++i) l2[i]->statistics(list, "gpu.l2.slice" + std::to_string(i));
    dram->statistics(list, "gpu.dram");
    return list;
  }

  ClockDomain core;
  ClockDomain memory;
  std::vector<std::unique_ptr<PortLinks>> client_links, sm_links, slice_links;
  std::vector<std::unique_ptr<MockClient>> client;
  std::vector<std::unique_ptr<L1Cache>> l1;
  std::unique_ptr<Crossbar> crossbar;
  std::vector<std::unique_ptr<L2Slice>> l2;
  std::vector<std::unique_ptr<AtProtocolChecker>> checker;
  std::unique_ptr<Dram> dram;

 private:
  Config config_;
};

}  // namespace grtx::modules
