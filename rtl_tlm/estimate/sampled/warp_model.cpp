#include "grtx/rtl_tlm/estimate/sampled/warp_model.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <queue>

namespace grtx::sim {
namespace {

constexpr double kPrologueCycles = 100.0;  ///< from launch to the first call, about
constexpr double kNoEvent = std::numeric_limits<double>::infinity();

/// A lane that steps, on its SM's own clock of steps.
struct Stepping {
  double end = 0.0;  ///< steps of the SM at which it is done
  std::uint32_t position = 0;
  float sector_rate = 0.0F;  ///< sectors a step
  float far_rate = 0.0F;
  bool operator>(const Stepping& other) const { return end != other.end ? end > other.end : position > other.position; }
};

/// A warp between two calls, on the SIMT core.
struct Waiting {
  double until = 0.0;
  std::uint32_t position = 0;
  bool operator>(const Waiting& other) const {
    return until != other.until ? until > other.until : position > other.position;
  }
};

template <typename T>
using MinQueue = std::priority_queue<T, std::vector<T>, std::greater<T>>;

struct SmState {
  int free_slots = 0;  ///< below 0 when known launches found slots that here are still taken
  unsigned free_calls = 0;
  double steps = 0.0;  ///< made so far by every stepping lane
  double pace = 0.0;   ///< steps a cycle
  double sector_rate = 0.0;
  double far_rate = 0.0;
  MinQueue<Stepping> lanes;
  std::deque<std::uint32_t> queue;  ///< warps whose call waits for a slot
};

struct WarpState {
  unsigned sm = 0;
  std::uint32_t round = 0;
  std::uint32_t lanes = 0;  ///< that still step
};

class Run {
 public:
  Run(const std::vector<const GroupWork*>& groups, const std::vector<Launch>& known, const ModelMachine& machine,
      const ModelRates& rates)
      : groups_(groups), known_(known), machine_(machine), rates_(rates), sms_(machine.sms), warps_(groups.size()) {
    for (SmState& sm : sms_) {
      sm.free_slots = static_cast<int>(machine.resident_warps);
      sm.free_calls = machine.call_slots;
    }
    result_.group_end.resize(groups.size());
    result_.group_sm.resize(groups.size());
  }

  ModelRun run() {
    launch();
    while (running_ > 0) {
      set_paces();
      double next = between_.empty() ? kNoEvent : between_.top().until;
      for (const SmState& sm : sms_) {
        if (!sm.lanes.empty()) next = std::min(next, now_ + (sm.lanes.top().end - sm.steps) / sm.pace);
      }
      const double passed = std::max(0.0, next - now_);
      now_ = std::max(now_, next);
      for (SmState& sm : sms_) {
        if (sm.lanes.empty()) continue;
        sm.steps += passed * sm.pace;
        // Lanes within a thousandth of a step end together; it also absorbs rounding.
        while (!sm.lanes.empty() && sm.lanes.top().end <= sm.steps + 1e-3) end_lane(sm);
        if (sm.lanes.empty()) sm.steps = sm.sector_rate = sm.far_rate = 0.0;
      }
      while (!between_.empty() && between_.top().until <= now_) {
        const std::uint32_t position = between_.top().position;
        between_.pop();
        next_round(position);
      }
      launch();
    }
    result_.cycles = now_;
    return std::move(result_);
  }

 private:
  void launch() {
    while (next_ < groups_.size()) {
      if (!secondary_ && groups_[next_]->kind != traces::RayKind::primary) {
        if (running_ > 0) return;
        secondary_ = true;
      }
      unsigned index = turn_;
      double start = now_;
      if (next_ < known_.size()) {
        index = known_[next_].sm;
        start = std::max(start, static_cast<double>(known_[next_].cycle));
      } else {
        for (unsigned i = 0; i < machine_.sms && sms_[index].free_slots <= 0; ++i) index = (index + 1) % machine_.sms;
        if (sms_[index].free_slots <= 0) return;
      }
      --sms_[index].free_slots;
      const auto position = static_cast<std::uint32_t>(next_++);
      warps_[position].sm = result_.group_sm[position] = index;
      ++running_;
      turn_ = (index + 1) % machine_.sms;
      between_.push({start + kPrologueCycles, position});
    }
  }

  /// The warp has come back from the SIMT core: it calls traceRay, or it ends.
  void next_round(std::uint32_t position) {
    WarpState& warp = warps_[position];
    SmState& sm = sms_[warp.sm];
    const GroupWork& work = *groups_[position];
    while (warp.round < work.rounds.size() && work.rounds[warp.round].lanes.empty()) ++warp.round;
    if (warp.round == work.rounds.size()) {
      result_.group_end[position] = now_;
      ++sm.free_slots;
      --running_;
      return;
    }
    sm.queue.push_back(position);
    start_calls(sm);
  }

  void start_calls(SmState& sm) {
    while (sm.free_calls > 0 && !sm.queue.empty()) {
      const std::uint32_t position = sm.queue.front();
      sm.queue.pop_front();
      --sm.free_calls;
      WarpState& warp = warps_[position];
      const RoundWork& round = groups_[position]->rounds[warp.round];
      warp.lanes = static_cast<std::uint32_t>(round.lanes.size());
      for (const LaneWork& lane : round.lanes) {
        const Stepping stepping{sm.steps + static_cast<double>(lane.steps), position, lane.sectors / lane.steps,
                                lane.far / lane.steps};
        sm.sector_rate += static_cast<double>(stepping.sector_rate);
        sm.far_rate += static_cast<double>(stepping.far_rate);
        sm.lanes.push(stepping);
      }
    }
  }

  void end_lane(SmState& sm) {
    const Stepping lane = sm.lanes.top();
    sm.lanes.pop();
    sm.sector_rate -= static_cast<double>(lane.sector_rate);
    sm.far_rate -= static_cast<double>(lane.far_rate);
    WarpState& warp = warps_[lane.position];
    if (--warp.lanes > 0) return;
    ++warp.round;
    ++sm.free_calls;
    between_.push({now_ + rates_.round_cycles, lane.position});
    start_calls(sm);
  }

  /// Every lane steps as fast as its SM allows, and no faster than a pace common to all at which the memory is busy.
  void set_paces() {
    double demand = 0.0;
    for (SmState& sm : sms_) {
      if (sm.lanes.empty()) continue;
      sm.pace = 1.0 / std::max({rates_.step_cycles, sm.sector_rate / rates_.sm_sectors, sm.far_rate / rates_.sm_far});
      demand += sm.far_rate * sm.pace;
    }
    const double supply = rates_.memory_sectors * machine_.memory_share;
    if (demand <= supply) return;
    double low = 0.0, high = 1.0 / rates_.step_cycles;  // the common pace: demand grows with it
    for (int i = 0; i < 40; ++i) {
      const double pace = 0.5 * (low + high);
      demand = 0.0;
      for (const SmState& sm : sms_) {
        if (!sm.lanes.empty()) demand += sm.far_rate * std::min(sm.pace, pace);
      }
      (demand > supply ? high : low) = pace;
    }
    for (SmState& sm : sms_) sm.pace = std::min(sm.pace, high);
  }

  const std::vector<const GroupWork*>& groups_;
  const std::vector<Launch>& known_;
  const ModelMachine& machine_;
  const ModelRates& rates_;
  std::vector<SmState> sms_;
  std::vector<WarpState> warps_;
  MinQueue<Waiting> between_;
  std::size_t next_ = 0;
  std::size_t running_ = 0;
  unsigned turn_ = 0;
  bool secondary_ = false;
  double now_ = 0.0;
  ModelRun result_;
};

}  // namespace

ModelRun run_model(const std::vector<const GroupWork*>& groups, const std::vector<Launch>& known,
                   const ModelMachine& machine, const ModelRates& rates) {
  return Run(groups, known, machine, rates).run();
}

}  // namespace grtx::sim
