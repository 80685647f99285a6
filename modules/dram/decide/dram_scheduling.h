// SPDX-License-Identifier: Apache-2.0
// DRAM scheduling policies: which command a channel issues in a clock. Selected by name, free of SystemC. The project's
// policies are in policies/, one file each. Register a policy of your own before configurations are read.
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

/// A request waiting in a channel.
struct QueuedRequest {
  std::uint64_t order = 0;  ///< arrival number in the channel; lower is older
  Cycle since = 0;          ///< clock of arrival
  RequestOrigin origin;
  bool write = false;
};

/// The state that a policy chooses from. Sets of banks are masks: bit b is bank b.
struct DramQueues {
  static constexpr unsigned kNone = 64;  ///< no bank

  std::uint64_t busy = 0;        ///< banks with requests
  std::uint64_t hits = 0;        ///< busy banks with a request for their open row (a row hit)
  std::uint64_t overtaking = 0;  ///< banks of `hits` whose hit is younger than their oldest request
  std::uint64_t columns = 0;     ///< banks of `hits` for which timing allows the column command of the hit
  /// Banks for which timing allows the precharge or activate of their oldest request. Not if that is the hit.
  std::uint64_t rows = 0;
  std::vector<QueuedRequest> oldest;  ///< [bank] oldest request, valid for `busy`
  std::vector<QueuedRequest> hit;     ///< [bank] oldest request for the open row, valid for `hits`

  /// The bank among `banks` with the oldest entry in `requests` (`oldest` or `hit`); kNone if `banks` is empty.
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

/// Commands to issue in this clock: at most one column command and one row command, to different banks.
struct DramChoice {
  unsigned column = DramQueues::kNone;  ///< bank
  unsigned row = DramQueues::kNone;     ///< bank
  /// Banks whose command the policy will not choose before clock `again`, unless they get another command or a request
  /// arrives. The channel then skips calls of choose(); only an optimisation.
  std::uint64_t declined_columns = 0;
  std::uint64_t declined_rows = 0;
  Cycle again = std::numeric_limits<Cycle>::max();
};

class DramScheduling {
 public:
  virtual ~DramScheduling() = default;
  /// Called in every clock in which timing allows a command that is not declined, and possibly in others. May choose no
  /// command even if one is ready; one that is not ends the run.
  virtual DramChoice choose(Cycle now, const DramQueues& queues) = 0;
  /// Hardware state of the policy, in bits per bank.
  virtual unsigned bits_per_bank() const { return 0; }
};

using DramSchedulingFactory = std::function<std::unique_ptr<DramScheduling>(const DramChannelConfig& channel)>;

inline constexpr const char* kFrFcfs = "fr_fcfs";
inline constexpr const char* kFrFcfsCap = "fr_fcfs_cap";

/// Makes `name` a value of dram.scheduling. Throws std::logic_error if the name is taken.
void register_dram_scheduling(const std::string& name, DramSchedulingFactory factory);
/// The registered values of dram.scheduling, the project's first.
std::vector<std::string> dram_scheduling_names();
/// Constructs the policy named by channel.scheduling. Throws Error for an unknown name, with the known ones, and for a
/// factory that makes nothing.
std::unique_ptr<DramScheduling> make_dram_scheduling(const DramChannelConfig& channel);

}  // namespace grtx::modules
