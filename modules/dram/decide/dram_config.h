// SPDX-License-Identifier: Apache-2.0
// Keys (dram.*, dram.timing.*) and counters of the DRAM and of its channels.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/dram/decide/dram_scheduling.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/address_interleave.h"

namespace grtx::modules {

/// All in memory clocks (3500 MHz: 0.286 ns).
struct DramTiming {
  unsigned ccd = 4;
  unsigned rrd = 10;
  unsigned rcd = 20;
  unsigned ras = 50;
  unsigned rp = 20;
  unsigned rc = 62;
  unsigned cl = 20;   ///< to the first data
  unsigned wl = 8;    ///< to the first data
  unsigned cdlr = 9;  ///< from the last data
  unsigned wr = 20;   ///< from the last data
  unsigned rtp = 4;
  unsigned turn = 2;
  // Off by default.
  unsigned ccd_l = 0;
  unsigned rrd_l = 0;
  unsigned cdlr_l = 0;
  unsigned rcd_wr = 0;
  unsigned faw = 0;
  unsigned refi = 0;
  unsigned rfc = 0;

  void parameters(ParameterList& list) {
    const auto add = [&](const char* key, unsigned& clocks, const char* description, double min = 0) {
      list.add(key, clocks, {min, 10000}, "clocks", description, kVulkanSim);
    };
    add("ccd", ccd, "column command to column command, clocks of a burst", 1);
    add("rrd", rrd, "activate to activate, other banks of a channel");
    add("rcd", rcd, "activate to column command");
    add("ras", ras, "activate to precharge");
    add("rp", rp, "precharge to activate");
    add("rc", rc, "activate to activate, same bank");
    add("cl", cl, "read command to data");
    add("wl", wl, "write command to data");
    add("cdlr", cdlr, "write data to read command");
    add("wr", wr, "write data to precharge");
    add("rtp", rtp, "read command to precharge");
    add("turn", turn, "bubble between read and write data");
    const auto add_unused = [&](const char* key, unsigned& clocks, const char* description) {
      list.add(key, clocks, {0, 10000}, "clocks", description, kOurs);
    };
    add_unused("ccd_l", ccd_l, "as ccd, in the same bank group, where longer");
    add_unused("rrd_l", rrd_l, "as rrd, in the same bank group, where longer");
    add_unused("cdlr_l", cdlr_l, "as cdlr, in the same bank group, where longer");
    add_unused("rcd_wr", rcd_wr, "activate to write command; 0: rcd");
    add_unused("faw", faw, "window in which at most four activates of a channel begin; 0: no such limit");
    list.add("refi", refi, {0, 1e6}, "clocks", "from one refresh of all banks of a channel to the next; 0: no refresh",
             kOurs);
    add_unused("rfc", rfc, "refresh to activate");
    list.rule(
        "refi", [this] { return refi == 0 || refi >= rfc + rc + rp + rcd; },
        "must be 0 or leave time for a row cycle: at least rfc + rc + rp + rcd of dram.timing");
  }
  unsigned read_to_write() const { return cl + ccd + turn > wl ? cl + ccd + turn - wl : 1; }
  unsigned write_to_read() const { return wl + ccd + cdlr; }
  unsigned activate_to_write() const { return rcd_wr == 0 ? rcd : rcd_wr; }
  unsigned write_to_precharge() const { return wl + ccd + wr; }
  // Timing within a bank group.
  bool groups_differ() const { return ccd_l > ccd || rrd_l > rrd || cdlr_l > cdlr; }
  unsigned ccd_of_group() const { return std::max(ccd, ccd_l); }
  unsigned rrd_of_group() const { return std::max(rrd, rrd_l); }
  unsigned write_to_read_of_group() const { return wl + ccd + std::max(cdlr, cdlr_l); }
};

struct DramChannelConfig {
  DramTiming timing{};
  unsigned banks = 16;
  unsigned bank_groups = 1;
  unsigned group_bytes = 128;
  unsigned row_bytes = 2048;
  unsigned burst_bytes = 32;  ///< burst length 16 on a 16-bit bus
  unsigned queue = 64;
  std::string scheduling = kFrFcfs;
  unsigned hit_cap = 4;
  Cycle age_cap = 1024;
  bool bank_xor = false;  ///< needs 2^n banks
  /// All but the timing, which is a separate table.
  void parameters(ParameterList& list) {
    list.add("banks", banks, {1, 64}, "banks", "of a channel", kVulkanSim);
    list.add("bank_groups", bank_groups, {1, 64}, "groups", "of the banks of a channel, whose number they divide",
             kOurs);
    list.add("group_bytes", group_bytes, {32, 1e6}, "B",
             "consecutive bytes of one bank group of a channel, if there are several", kOurs);
    list.add("row_bytes", row_bytes, {32, 1e6}, "B", "row of a bank of a channel", kVulkanSim);
    list.add("burst_bytes", burst_bytes, {8, 4096}, "B", "moved by one column command of a channel", kVulkanSim);
    list.add("queue", queue, {4, kMaxEntries}, "bursts", "waiting in a channel", kVulkanSim);
    list.add("scheduling", scheduling, dram_scheduling_names(),
             "which command a channel issues; programs may register more policies (docs/model/dram.md)", kVulkanSim);
    list.add("hit_cap", hit_cap, {1, 1e6}, "commands",
             "fr_fcfs_cap: column commands of a bank that may overtake its oldest request",
             from_public("Mutlu and Moscibroda, MICRO 2007"));
    list.add("age_cap", age_cap, {0, 1e12}, "clocks", "after which nothing may overtake a request; not for fcfs",
             kOurs);
    list.add("bank_xor", bank_xor, "low row bits are folded into the bank number", kOurs);
    list.rule(
        "bank_xor", [this] { return !bank_xor || std::has_single_bit(banks); }, "needs a power of two of dram.banks");
    list.rule(
        "row_bytes", [this] { return row_bytes >= burst_bytes; }, "must not be smaller than dram.burst_bytes");
    list.rule(
        "bank_groups", [this] { return banks % bank_groups == 0; }, "must divide dram.banks");
    list.rule(
        "group_bytes",
        [this] { return bank_groups == 1 || (std::has_single_bit(group_bytes) && row_bytes % group_bytes == 0); },
        "must be a power of two that divides dram.row_bytes");
    list.rule(
        "group_bytes", [this] { return bank_groups == 1 || group_bytes >= burst_bytes; },
        "must not be smaller than dram.burst_bytes");
  }
  /// An aligned request of up to this many bytes lies within one row.
  unsigned bytes_in_row() const { return bank_groups == 1 ? row_bytes : group_bytes; }
};

struct DramConfig {
  AddressInterleave interleave{};  ///< maps addresses to sockets and channels; set by the assembly
  DramChannelConfig channel{};
  Cycle fixed_latency = 256;
  std::uint64_t bytes = 0;  ///< memory size, 0: unlimited; addresses beyond are refused; set by the assembly
  bool perfect = false;     ///< no banks and no data bus: every request takes fixed_latency
  void parameters(ParameterList& list) {
    channel.parameters(list);
    list.add("fixed_latency", fixed_latency, {0, 1e7}, "clocks", "added to every response (100 core cycles = 73 ns)",
             kVulkanSim);
    list.add("perfect", perfect, "every request takes fixed_latency only (limit study)", kOurs);
    list.part("timing", channel.timing);
  }
};

/// Counters of one channel, or their sum over channels.
struct DramChannelCounters {
  std::uint64_t reads = 0, writes = 0, bytes = 0, responses = 0;
  std::uint64_t refused = 0;  ///< malformed transactions, answered with an error status
  std::uint64_t row_hits = 0, row_misses = 0, row_conflicts = 0;
  std::uint64_t activates = 0, precharges = 0, refreshes = 0, bursts = 0, aged = 0;
  std::uint64_t queue_clocks = 0, full_clocks = 0;
  std::uint64_t latency_clocks = 0;  ///< from enqueue to last data, summed over requests

  static const CounterTable<DramChannelCounters>& table();
  DramChannelCounters& operator+=(const DramChannelCounters& other) {
    table().add(*this, other);
    return *this;
  }
};

struct DramCounters {
  DramChannelCounters channel;       ///< summed over channels
  std::uint64_t clocks = 0;          ///< memory clocks since the start
  double bandwidth_utilisation = 0;  ///< bytes / (channels x burst / CCD x clocks)
  Quotient of_peak;                  ///< the same as two whole numbers: bytes x CCD, channels x burst x clocks
};

/// Sums the counters of `channels` and computes the bandwidth utilisation after `clocks` memory clocks.
DramCounters dram_counters(const DramChannelConfig& config, const std::vector<DramChannelCounters>& channels,
                           std::uint64_t clocks);

/// Appends the counters as prefix + ".name"; `channels` holds those of the single channels.
void describe(const DramCounters& counters, const std::vector<DramChannelCounters>& channels, StatisticList& list,
              const std::string& prefix);

}  // namespace grtx::modules
