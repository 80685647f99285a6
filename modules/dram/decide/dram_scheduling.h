// Which command a DRAM channel issues in a clock: a policy, free of SystemC, chosen by its name. Those of the project
// stand in policies/, one file each. One of your own is registered before configurations are read.
#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct DramChannelConfig;

/// A request that waits in a channel.
struct QueuedRequest {
  std::uint64_t order = 0;  ///< of arrival in the channel: the less, the older
  Cycle since = 0;          ///< clock of its arrival
  RequestOrigin origin;
  bool write = false;
};

/// What a channel has to choose from in a clock. A set of banks is a mask: bit b is bank b.
struct DramQueues {
  static constexpr unsigned kNone = 64;  ///< no bank

  std::uint64_t busy = 0;        ///< have requests
  std::uint64_t hits = 0;        ///< of these: a row is open, and a request wants it
  std::uint64_t overtaking = 0;  ///< of these: it is younger than the bank's oldest request
  std::uint64_t columns = 0;     ///< timing allows the column command of the hit
  /// Timing allows what the oldest request needs: precharge or activate. Never when it is the hit.
  std::uint64_t rows = 0;
  std::vector<QueuedRequest> oldest;  ///< by bank, of those that are busy
  std::vector<QueuedRequest> hit;     ///< by bank, of `hits`: the oldest request that wants the open row

  /// Of `banks` that with the oldest of `requests` (oldest or hit); kNone of no banks.
  static unsigned oldest_of(std::uint64_t banks, const std::vector<QueuedRequest>& requests) {
    unsigned found = kNone;
    for (std::uint64_t order = ~std::uint64_t{0}; banks != 0; banks &= banks - 1) {
      const auto bank = static_cast<unsigned>(std::countr_zero(banks));
      if (requests[bank].order >= order) continue;
      order = requests[bank].order;
      found = bank;
    }
    return found;
  }
};

/// What a channel issues in a clock: at most one column command and one row command, to different banks.
struct DramChoice {
  unsigned column = DramQueues::kNone;  ///< bank
  unsigned row = DramQueues::kNone;
  /// Banks whose command the policy does not want before clock `again`, as long as they get no other and no request
  /// arrives: the channel need not ask for their sake. For speed alone.
  std::uint64_t declined_columns = 0;
  std::uint64_t declined_rows = 0;
  Cycle again = std::numeric_limits<Cycle>::max();
};

class DramScheduling {
 public:
  virtual ~DramScheduling() = default;
  /// Called in every clock in which timing allows a command that is not declined, and sometimes besides. May name no
  /// command although one is ready.
  virtual DramChoice choose(Cycle now, const DramQueues& queues) = 0;
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
/// The one that channel.scheduling names. Throws Error that lists the names for an unknown one.
std::unique_ptr<DramScheduling> make_dram_scheduling(const DramChannelConfig& channel);

}  // namespace grtx::modules
