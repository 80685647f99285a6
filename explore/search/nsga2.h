// SPDX-License-Identifier: Apache-2.0
// NSGA-II (pagmo's) over discrete choices, one generation at a time. The same seed and costs give the same designs in
// the same order, so a killed search can be repeated up to where it stopped.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace grtx::explore {

/// One design: the index of the choice in each dimension.
using Choices = std::vector<std::size_t>;

struct SearchSpace {
  struct Dimension {
    std::size_t choices = 2;  ///< at least 2
    bool ordered = true;      ///< neighbouring choices are alike: mutation takes small steps; else any step
  };
  std::vector<Dimension> dimensions;

  /// Number of designs; a double, as it may exceed 64 bits.
  double size() const;
};

class Nsga2 {
 public:
  /// Returns `costs` costs for each design, less is better; called once per batch. Designs that break a constraint must
  /// have higher costs than all others.
  using Evaluate = std::function<std::vector<std::vector<double>>(const std::vector<Choices>&)>;

  /// population: a multiple of 4, at least 8. costs: number per design. first: designs of the first population; the
  /// rest is drawn at random. Evaluates the first population.
  Nsga2(const SearchSpace& space, unsigned seed, unsigned population, std::size_t costs,
        const std::vector<Choices>& first, Evaluate evaluate);
  ~Nsga2();
  Nsga2(const Nsga2&) = delete;
  Nsga2& operator=(const Nsga2&) = delete;

  /// Runs one generation. First replaces duplicates in the population by designs not yet evaluated, if some are found:
  /// in a discrete space duplicates arise, and pagmo keeps them. Also replaces one design after a generation without a
  /// new design.
  void step();
  /// Number of different designs evaluated so far.
  std::size_t evaluated_count() const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

}  // namespace grtx::explore
