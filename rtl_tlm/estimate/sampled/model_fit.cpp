#include "grtx/rtl_tlm/estimate/sampled/model_fit.h"

#include <algorithm>
#include <cmath>

namespace grtx::sim {
namespace {

constexpr double kDifference = 0.02;  ///< of a log rate, for derivatives: the model is a sum of many small kinks
constexpr int kIterations = 12;

using Matrix = std::array<LogRates, kFittedRates>;

/// Inverse of a symmetric positive definite matrix (Gauss-Jordan; four rows need no pivots).
Matrix inverse(Matrix a) {
  Matrix inv{};
  for (std::size_t i = 0; i < kFittedRates; ++i) inv[i][i] = 1.0;
  for (std::size_t i = 0; i < kFittedRates; ++i) {
    const double pivot = a[i][i];
    for (std::size_t j = 0; j < kFittedRates; ++j) {
      a[i][j] /= pivot;
      inv[i][j] /= pivot;
    }
    for (std::size_t r = 0; r < kFittedRates; ++r) {
      if (r == i) continue;
      const double factor = a[r][i];
      for (std::size_t j = 0; j < kFittedRates; ++j) {
        a[r][j] -= factor * a[i][j];
        inv[r][j] -= factor * inv[i][j];
      }
    }
  }
  return inv;
}

LogRates product(const Matrix& m, const LogRates& v) {
  LogRates result{};
  for (std::size_t i = 0; i < kFittedRates; ++i) {
    for (std::size_t j = 0; j < kFittedRates; ++j) result[i] += m[i][j] * v[j];
  }
  return result;
}

/// All residuals of all samples one after the other.
std::vector<double> residuals_at(const std::vector<Observed>& samples, const LogRates& log_rates) {
  const ModelRates rates = rates_of(log_rates);
  std::vector<double> all;
  for (const Observed& sample : samples) {
    const ModelRun run = run_model(sample.groups, {}, sample.machine, rates);
    for (std::size_t i = 0; i < sample.groups.size(); ++i) {
      all.push_back((run.group_end[i] - sample.group_end[i]) / sample.cycles);
    }
  }
  return all;
}

double weighted_squares(const std::vector<double>& residuals, const std::vector<double>& weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) sum += weights[i] * residuals[i] * residuals[i];
  return sum;
}

}  // namespace

ModelRates rates_of(const LogRates& log_rates) {
  ModelRates rates;
  rates.step_cycles = std::exp(log_rates[0]);
  rates.sm_sectors = std::exp(log_rates[1]);
  rates.sm_far = std::exp(log_rates[2]);
  rates.memory_sectors = std::exp(log_rates[3]);
  return rates;
}

FittedRates fit_rates(const std::vector<Observed>& samples, const RatePrior& prior) {
  // A warp weighs as much as its work. Together the weights are the number of warps of equal work that would tell as
  // much (Kish's effective sample size).
  std::vector<double> weights;
  double sum = 0.0, squares = 0.0;
  for (const Observed& sample : samples) {
    for (const GroupWork* group : sample.groups) {
      weights.push_back(group->sectors);
      sum += group->sectors;
      squares += group->sectors * group->sectors;
    }
  }
  const double effective = squares > 0.0 ? sum * sum / squares : 1.0;
  for (double& weight : weights) weight *= sum > 0.0 ? effective / sum : 0.0;

  // The residuals' own deviation decides what the prior is worth against them; it is estimated along.
  FittedRates fit;
  LogRates at = prior.mean;
  std::vector<double> residuals = residuals_at(samples, at);
  double variance_of_one = 0.03 * 0.03;
  const auto cost = [&](const std::vector<double>& r, const LogRates& x) {
    double c = weighted_squares(r, weights) / variance_of_one;
    for (std::size_t p = 0; p < kFittedRates; ++p) {
      const double z = (x[p] - prior.mean[p]) / prior.deviation[p];
      c += z * z;
    }
    return c;
  };
  Matrix normal{};
  std::array<std::vector<double>, kFittedRates> jacobian;
  double damping = 1.0;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    for (std::size_t p = 0; p < kFittedRates; ++p) {
      LogRates up = at, down = at;
      up[p] += kDifference;
      down[p] -= kDifference;
      jacobian[p] = residuals_at(samples, up);
      const std::vector<double> below = residuals_at(samples, down);
      for (std::size_t i = 0; i < below.size(); ++i) jacobian[p][i] = (jacobian[p][i] - below[i]) / (2.0 * kDifference);
    }
    LogRates slope{};
    for (std::size_t p = 0; p < kFittedRates; ++p) {
      for (std::size_t q = 0; q < kFittedRates; ++q) {
        normal[p][q] = 0.0;
        for (std::size_t i = 0; i < residuals.size(); ++i) normal[p][q] += weights[i] * jacobian[p][i] * jacobian[q][i];
        normal[p][q] /= variance_of_one;
      }
      for (std::size_t i = 0; i < residuals.size(); ++i) slope[p] += weights[i] * jacobian[p][i] * residuals[i];
      const double precision = 1.0 / (prior.deviation[p] * prior.deviation[p]);
      slope[p] = slope[p] / variance_of_one + (at[p] - prior.mean[p]) * precision;
      normal[p][p] += precision;
    }
    if (iteration == kIterations) break;
    bool better = false;
    for (int attempt = 0; attempt < 6 && !better; ++attempt) {
      Matrix damped = normal;
      for (std::size_t p = 0; p < kFittedRates; ++p) damped[p][p] *= 1.0 + damping;
      const LogRates move = product(inverse(damped), slope);
      LogRates next = at;
      for (std::size_t p = 0; p < kFittedRates; ++p) next[p] -= std::clamp(move[p], -1.0, 1.0);
      std::vector<double> there = residuals_at(samples, next);
      if (cost(there, next) < cost(residuals, at)) {
        at = next;
        residuals = std::move(there);
        damping *= 0.2;
        better = true;
      } else {
        damping = std::max(damping, 0.01) * 5.0;
      }
    }
    const double mean_square = weighted_squares(residuals, weights) / std::max(1.0, effective - 2.0);
    const double updated = std::clamp(mean_square, 0.005 * 0.005, 0.2 * 0.2);
    const bool settled = std::abs(updated / variance_of_one - 1.0) < 0.02;
    variance_of_one = updated;
    if (!better && settled) break;
    if (!better) damping = 1.0;
  }
  fit.log_rates = at;
  fit.covariance = inverse(normal);
  fit.residual = std::sqrt(variance_of_one);
  fit.degrees_of_freedom = std::max(2.0, effective - 2.0);
  // The posterior's covariance C is C (data) C + C (prior) C; the first part is estimated from the residuals
  // themselves.
  for (std::size_t p = 0; p < kFittedRates; ++p) {
    for (std::size_t q = 0; q < kFittedRates; ++q) {
      for (std::size_t r = 0; r < kFittedRates; ++r) {
        fit.prior_part[p][q] += fit.covariance[p][r] * fit.covariance[r][q] / (prior.deviation[r] * prior.deviation[r]);
      }
    }
  }
  std::size_t next = 0;
  for (const Observed& sample : samples) {
    fit.groups.emplace_back();
    for (std::size_t i = 0; i < sample.groups.size(); ++i, ++next) {
      FittedRates::Group group{weights[next], residuals[next], {}};
      LogRates pull{};
      for (std::size_t p = 0; p < kFittedRates; ++p) {
        pull[p] = -weights[next] * jacobian[p][next] * residuals[next] / variance_of_one;
      }
      group.influence = product(fit.covariance, pull);
      fit.groups.back().push_back(group);
    }
  }
  return fit;
}

LogEstimate predict(const std::vector<const GroupWork*>& groups, const std::vector<Launch>& known,
                    const ModelMachine& machine, const LogRates& log_rates) {
  const auto value = [&](const LogRates& x) {
    return std::log(std::max(1.0, run_model(groups, known, machine, rates_of(x)).cycles));
  };
  LogEstimate estimate;
  estimate.value = value(log_rates);
  for (std::size_t p = 0; p < kFittedRates; ++p) {
    LogRates up = log_rates, down = log_rates;
    up[p] += kDifference;
    down[p] -= kDifference;
    estimate.gradient[p] = (value(up) - value(down)) / (2.0 * kDifference);
  }
  return estimate;
}

double prior_variance(const LogRates& gradient, const FittedRates& fit) {
  const LogRates half = product(fit.prior_part, gradient);
  double sum = 0.0;
  for (std::size_t p = 0; p < kFittedRates; ++p) sum += gradient[p] * half[p];
  return sum;
}

}  // namespace grtx::sim
