// Fits the rates of the warp model to simulated samples, and says how well they are known.
#pragma once

#include <array>
#include <vector>

#include "grtx/rtl_tlm/estimate/sampled/warp_model.h"

namespace grtx::sim {

/// A simulated sample: what ran where, and when its warps ended.
struct Observed {
  std::vector<const GroupWork*> groups;  ///< in launch order
  ModelMachine machine;
  std::vector<double> group_end;  ///< cycles
  double cycles = 0.0;
};

inline constexpr std::size_t kFittedRates = 4;
/// Rates that are fitted, as natural logarithms: step_cycles, sm_sectors, sm_far, memory_sectors.
using LogRates = std::array<double, kFittedRates>;

ModelRates rates_of(const LogRates& log_rates);

/// Belief before any sample: a normal distribution of each logarithm.
struct RatePrior {
  LogRates mean{};
  LogRates deviation{};
};

struct FittedRates {
  LogRates log_rates{};
  std::array<LogRates, kFittedRates> covariance{};  ///< posterior
  std::array<LogRates, kFittedRates> prior_part{};  ///< of it, what comes from the prior
  double residual = 0.0;  ///< standard deviation of (modelled end - end) / cycles of the run, warps weighted by work
  double degrees_of_freedom = 1.0;  ///< of it
  struct Group {
    double weight = 0.0;    ///< all weights together: how many warps of equal work would tell as much
    double residual = 0.0;  ///< (modelled - simulated end) / cycles of the sample
    LogRates influence{};   ///< on the log rates: how far this group's residual moved them
  };
  std::vector<std::vector<Group>> groups;  ///< by sample and position
};

/// The most probable rates, by Levenberg and Marquardt's method. Deterministic. samples: at least one with work.
FittedRates fit_rates(const std::vector<Observed>& samples, const RatePrior& prior);

/// An estimate on the scale of logarithms.
struct LogEstimate {
  double value = 0.0;
  LogRates gradient{};  ///< with respect to the log rates
};
/// The model's cycles of a run, and how they depend on the rates.
LogEstimate predict(const std::vector<const GroupWork*>& groups, const std::vector<Launch>& known,
                    const ModelMachine& machine, const LogRates& log_rates);
/// Of a linear function of the log rates, from the prior alone: what the samples leave open.
double prior_variance(const LogRates& gradient, const FittedRates& fit);

}  // namespace grtx::sim
