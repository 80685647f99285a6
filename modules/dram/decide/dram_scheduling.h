// Which command a DRAM channel issues in a clock: a policy, free of SystemC, chosen by its name. fr_fcfs and
// fr_fcfs_cap are built into the channel (dram_channel.cpp), where the model spends its time; others stand in
// policies/, one file each. One of your own is registered before configurations are read.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::modules {

struct DramChannelConfig;

/// A bank that has requests, and what it could be given in this clock. Requests are known by the number of their
/// arrival in the channel: the less, the older.
struct DramBankQueue {
  unsigned bank = 0;
  std::uint64_t oldest = 0;  ///< request of the bank
  Cycle oldest_since = 0;    ///< clock of its arrival
  bool has_hit = false;      ///< a row is open, and a request wants it
  std::uint64_t hit = 0;     ///< the oldest such request
  Cycle hit_since = 0;
  bool hit_write = false;
  bool column_ready = false;  ///< timing allows the column command of `hit`
  bool row_ready = false;     ///< timing allows what `oldest` needs: precharge or activate; never when it is `hit`
};

/// What a channel issues in a clock: at most one column command and one row command, to different banks.
struct DramChoice {
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t column = kNone;  ///< place among the queues that the policy was shown
  std::size_t row = kNone;
};

class DramScheduling {
 public:
  virtual ~DramScheduling() = default;
  /// Called in every clock in which timing allows a command. queues: of the banks that have requests, by bank number.
  /// May name no command although one is ready, and is then asked again in the next clock.
  virtual DramChoice choose(Cycle now, const std::vector<DramBankQueue>& queues) = 0;
  /// State that hardware keeps for it, a bank.
  virtual unsigned bits_per_bank() const { return 0; }
};

using DramSchedulingFactory = std::function<std::unique_ptr<DramScheduling>(const DramChannelConfig& channel)>;

inline constexpr const char* kFrFcfs = "fr_fcfs";
inline constexpr const char* kFrFcfsCap = "fr_fcfs_cap";

/// Makes `name` a value of dram.scheduling. Throws std::logic_error when it is one already.
void register_dram_scheduling(const std::string& name, DramSchedulingFactory factory);
/// The values of dram.scheduling, those of the project first.
std::vector<std::string> dram_scheduling_names();
/// The one that channel.scheduling names; nullptr for those built in. Throws Error that lists the names for an unknown
/// one.
std::unique_ptr<DramScheduling> make_dram_scheduling(const DramChannelConfig& channel);

}  // namespace grtx::modules
