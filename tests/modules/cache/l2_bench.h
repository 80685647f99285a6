// SPDX-License-Identifier: Apache-2.0
// An L2 slice between a mock client (in place of the crossbar) and the built-in DRAM, protocol checker in between.
#pragma once

#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/tlm/at_payload_pool.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {

struct L2Bench {
  static L2Slice::Config one_slice() {
    L2Slice::Config config;
    config.interleave.slices = 1;
    return config;
  }
  static Dram::Config dram_of(const L2Slice::Config& config) {
    Dram::Config dram;
    dram.interleave = config.interleave;
    return dram;
  }

  explicit L2Bench(L2Slice::Config config = one_slice(), bool idle_skip = true)
      : L2Bench(config, dram_of(config), idle_skip) {}
  L2Bench(L2Slice::Config config, Dram::Config dram_config, bool idle_skip = true)
      : core("core", 1365.0, idle_skip),
        memory("memory", 3500.0, idle_skip),
        links("client", 64),
        client("client", core, links),
        l2("l2", config, core),
        checker("checker", {.period_fs = core.period_fs()}),
        dram("dram", dram_config, memory) {
    l2.request.bind(links.request);
    l2.response.bind(links.response);
    l2.dram.socket.bind(checker.target);
    checker.initiator.bind(dram.sockets[config.slice]);
  }
  /// Every request was answered once, nothing is in flight, no protocol violation.
  bool conserved() const {
    const L2Counters& c = l2.counters();
    return client.complete() && l2.idle() && dram.idle() && checker.violations() == 0 && checker.outstanding() == 0 &&
           c.requests_in == client.sent() && c.replies_out == client.sent() && c.accesses() == client.sent() &&
           c.dram_reads == c.all().misses && dram.counters().channel.reads == c.dram_reads &&
           dram.counters().channel.writes == c.dram_writes && l2.dram.pool().live() == 0;
  }
  /// Cycle that sees the reply to a read that missed in cycle `visible`, after `clocks` in the DRAM.
  Cycle miss_seen(Cycle visible, Cycle clocks) const {
    const Cycle sent = visible + l2.config().latency;
    const Cycle arrival = sent * core.period_fs() / memory.period_fs() + 1;
    const Cycle filled = (arrival + clocks) * memory.period_fs() / core.period_fs() + 1;
    return filled + links.response.latency();
  }

  ClockDomain core;
  ClockDomain memory;
  PortLinks links;
  MockClient client;
  L2Slice l2;
  AtProtocolChecker checker;
  Dram dram;
};

}  // namespace grtx::modules
