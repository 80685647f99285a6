// NSGA-II over a space of choices: pagmo's, one generation at a time. The same seed and the same answers give the same
// designs in the same order, so a search that was killed finds its way again.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace grtx::sim {

/// For each dimension, which of its choices.
using Choices = std::vector<std::size_t>;

struct SearchSpace {
  struct Dimension {
    std::size_t choices = 2;  ///< at least 2
    bool ordered = true;      ///< neighbours are alike: crossover and mutation move by little; else any for any
  };
  std::vector<Dimension> dimensions;

  /// How many designs there are; a double, since it may be beyond 64 bits.
  double size() const;
};

class Nsga2 {
 public:
  /// Costs of each design, less is better, as many for each as the setting says; called once a batch. Whatever breaks a
  /// constraint must have costs above all that do not.
  using Evaluate = std::function<std::vector<std::vector<double>>(const std::vector<Choices>&)>;

  /// population: a multiple of 4, at least 8. costs: how many a design has. first: designs to begin with; the others of
  /// the first population are drawn. Evaluates the first population.
  Nsga2(const SearchSpace& space, unsigned seed, unsigned population, std::size_t costs,
        const std::vector<Choices>& first, Evaluate evaluate);
  ~Nsga2();
  Nsga2(const Nsga2&) = delete;
  Nsga2& operator=(const Nsga2&) = delete;

  /// One generation. Designs that the population holds more than once are first replaced by ones that were never looked
  /// at, as far as some are found: a discrete space makes copies, which pagmo keeps. So is one design after a
  /// generation that looked at nothing new.
  void step();
  /// Different designs that were evaluated so far.
  std::size_t looked_at() const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

}  // namespace grtx::sim
