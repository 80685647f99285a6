// Counts distinct nodes: per ray (unique visits) and over a view (footprint). Only built when those figures are asked
// for.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "grtx/frontend/accel/node_image.h"

namespace grtx::frontend {

/// One byte a unit of the node image, set when any ray of the view touched it. Shared by all threads.
class Footprint {
 public:
  explicit Footprint(const NodeImage& image)
      : unit_(image.sizes().unit()), touched_(image.size() / image.sizes().unit()) {}
  void touch(std::uint64_t unit) {
    std::atomic_ref<std::uint8_t> flag(touched_[unit]);
    if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
  }
  std::uint64_t bytes() const {
    std::uint64_t units = 0;
    for (const std::uint8_t t : touched_) units += t;
    return units * unit_;
  }

 private:
  std::uint64_t unit_;
  std::vector<std::uint8_t> touched_;
};

/// One a thread.
class VisitTracker {
 public:
  VisitTracker(const NodeImage& image, Footprint& footprint)
      : last_ray_(image.size() / image.sizes().unit()), footprint_(footprint) {}
  void begin_ray() { ++ray_; }
  void visit(std::uint32_t unit, unsigned size_units) {
    if (last_ray_[unit] == ray_) return;
    last_ray_[unit] = ray_;
    ++unique_;
    for (unsigned i = 0; i < size_units; ++i) footprint_.touch(unit + i);
  }
  std::uint64_t unique() const { return unique_; }

 private:
  std::vector<std::uint32_t> last_ray_;
  Footprint& footprint_;
  std::uint32_t ray_ = 0;
  std::uint64_t unique_ = 0;
};

}  // namespace grtx::frontend
