// SPDX-License-Identifier: Apache-2.0
// The only file that includes pagmo: its headers are slow to compile.
#include "grtx/explore/search/nsga2.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/batch_evaluators/member_bfe.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <random>
#include <set>
#include <utility>

namespace grtx::explore {
namespace {

constexpr double kCrossover = 0.95;       // Deb et al. 2002 use 0.9; pagmo's default
constexpr double kCrossoverIndex = 10.0;  // of simulated binary crossover; pagmo's default
/// Index of polynomial mutation: steps of about a tenth of the range, one or two choices of ten. pagmo's default, 50,
/// hardly ever changes a choice.
constexpr double kMutationIndex = 5.0;
constexpr unsigned kDraws = 200;  ///< attempts to draw a design not yet evaluated

/// The problem as pagmo sees it: continuous variables first (the integer part is the choice), then integers.
class Problem {
 public:
  Problem() = default;  // required by pagmo
  Problem(const SearchSpace& space, std::size_t costs, Nsga2::Evaluate* evaluate)
      : space_(space), costs_(costs), evaluate_(evaluate) {
    for (const bool ordered : {true, false}) {
      for (std::size_t i = 0; i < space.dimensions.size(); ++i) {
        if (space.dimensions[i].ordered == ordered) order_.push_back(i);
      }
    }
  }

  pagmo::vector_double encode(const Choices& design) const {
    pagmo::vector_double x;
    for (const std::size_t i : order_) {
      x.push_back(static_cast<double>(design[i]) + (space_.dimensions[i].ordered ? 0.5 : 0.0));
    }
    return x;
  }
  Choices decode(const double* x) const {
    Choices design(order_.size());
    for (std::size_t at = 0; at < order_.size(); ++at) {
      const auto whole = static_cast<std::size_t>(std::max(0.0, std::floor(x[at])));
      design[order_[at]] = std::min(whole, space_.dimensions[order_[at]].choices - 1);
    }
    return design;
  }
  /// pagmo's NSGA-II needs at least two objectives: a single cost is duplicated.
  std::size_t copies() const { return costs_ == 1 ? 2 : 1; }
  std::vector<pagmo::vector_double> evaluate(const std::vector<Choices>& designs) const {
    std::vector<pagmo::vector_double> all = (*evaluate_)(designs);
    assert(all.size() == designs.size());
    for (pagmo::vector_double& costs : all) {
      assert(costs.size() == costs_);
      if (copies() == 2) costs.push_back(costs.front());
    }
    return all;
  }

  // Interface required by pagmo.
  pagmo::vector_double fitness(const pagmo::vector_double& x) const { return evaluate({decode(x.data())}).front(); }
  pagmo::vector_double batch_fitness(const pagmo::vector_double& xs) const {
    std::vector<Choices> designs;
    for (std::size_t at = 0; at < xs.size(); at += order_.size()) designs.push_back(decode(&xs[at]));
    pagmo::vector_double flat;
    for (const pagmo::vector_double& costs : evaluate(designs)) flat.insert(flat.end(), costs.begin(), costs.end());
    return flat;
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    pagmo::vector_double low(order_.size(), 0.0), high;
    for (const std::size_t i : order_) {
      const auto choices = static_cast<double>(space_.dimensions[i].choices);
      high.push_back(space_.dimensions[i].ordered ? choices : choices - 1.0);
    }
    return {low, high};
  }
  pagmo::vector_double::size_type get_nobj() const { return costs_ * copies(); }
  pagmo::vector_double::size_type get_nix() const {
    return static_cast<std::size_t>(std::count_if(space_.dimensions.begin(), space_.dimensions.end(),
                                                  [](const SearchSpace::Dimension& d) { return !d.ordered; }));
  }

 private:
  SearchSpace space_;
  std::size_t costs_ = 1;
  Nsga2::Evaluate* evaluate_ = nullptr;
  std::vector<std::size_t> order_;  ///< dimension of each variable
};

}  // namespace

double SearchSpace::size() const {
  double size = 1.0;
  for (const Dimension& dimension : dimensions) size *= static_cast<double>(dimension.choices);
  return size;
}

class Nsga2::Engine {
 public:
  Engine(const SearchSpace& space, unsigned seed, unsigned population, std::size_t costs,
         const std::vector<Choices>& first, Evaluate evaluate)
      : space_(space),
        evaluate_([this, evaluate_designs = std::move(evaluate)](const std::vector<Choices>& designs) {
          seen_.insert(designs.begin(), designs.end());
          return evaluate_designs(designs);
        }),
        problem_(space_, costs, &evaluate_),
        random_(seed),
        population_(pagmo::problem(problem_), 0U, seed),
        algorithm_(1U, kCrossover, kCrossoverIndex, 1.0 / static_cast<double>(space.dimensions.size()), kMutationIndex,
                   seed) {
    algorithm_.set_bfe(pagmo::bfe(pagmo::member_bfe()));
    std::vector<Choices> designs;
    std::set<Choices> drawn;
    for (const Choices& design : first) {
      if (designs.size() < population && drawn.insert(design).second) designs.push_back(design);
    }
    while (designs.size() < population) {  // duplicates, if the space is smaller than the population
      Choices design = draw(drawn);
      drawn.insert(design);
      designs.push_back(std::move(design));
    }
    const auto costs_of = problem_.evaluate(designs);
    for (std::size_t i = 0; i < designs.size(); ++i) population_.push_back(problem_.encode(designs[i]), costs_of[i]);
  }

  void step() {
    const bool idle = seen_.size() == seen_before_;
    seen_before_ = seen_.size();
    const std::size_t replaced = idle ? random_() % population_.size() : population_.size();
    std::set<Choices> present, drawn = seen_;
    std::vector<std::size_t> places;
    std::vector<Choices> replacements;
    for (std::size_t i = 0; i < population_.size(); ++i) {
      const bool is_duplicate = !present.insert(problem_.decode(population_.get_x()[i].data())).second;
      if (!is_duplicate && i != replaced) continue;
      Choices design = draw(drawn);
      if (!drawn.insert(design).second) continue;
      places.push_back(i);
      replacements.push_back(std::move(design));
    }
    if (!replacements.empty()) {
      const auto costs = problem_.evaluate(replacements);
      for (std::size_t i = 0; i < replacements.size(); ++i) {
        population_.set_xf(places[i], problem_.encode(replacements[i]), costs[i]);
      }
    }
    population_ = algorithm_.evolve(population_);
  }

  std::size_t evaluated_count() const { return seen_.size(); }

 private:
  /// Draws a random design that is not in `known`, or any design if none is found.
  Choices draw(const std::set<Choices>& known) {
    Choices design;
    for (unsigned i = 0; i < kDraws; ++i) {
      design.clear();
      for (const SearchSpace::Dimension& dimension : space_.dimensions) {
        design.push_back(static_cast<std::size_t>(random_() % dimension.choices));
      }
      if (!known.contains(design)) break;
    }
    return design;
  }

  SearchSpace space_;
  std::set<Choices> seen_;
  std::size_t seen_before_ = 0;  ///< number of evaluated designs at the previous step
  Evaluate evaluate_;
  Problem problem_;
  std::mt19937_64 random_;
  pagmo::population population_;
  pagmo::nsga2 algorithm_;
};

Nsga2::Nsga2(const SearchSpace& space, unsigned seed, unsigned population, std::size_t costs,
             const std::vector<Choices>& first, Evaluate evaluate)
    : engine_(std::make_unique<Engine>(space, seed, population, costs, first, std::move(evaluate))) {}

Nsga2::~Nsga2() = default;

void Nsga2::step() { engine_->step(); }

std::size_t Nsga2::evaluated_count() const { return engine_->evaluated_count(); }

}  // namespace grtx::explore
