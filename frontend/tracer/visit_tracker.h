// SPDX-License-Identifier: Apache-2.0
// Counts distinct nodes: per ray (unique visits) and over a view (footprint). Created only when these figures are asked
// for.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/frontend/accel/node_image.h"

namespace grtx::frontend {

/// One bit per unit of the node image, set when any ray of the view touched it. Shared by all threads.
class Footprint {
 public:
  explicit Footprint(const NodeImage& image)
      : unit_(image.sizes().unit()), touched_(image.size() / image.sizes().unit() / kBits + 1) {}
  void touch(std::uint64_t unit) {
    const std::uint64_t bit = std::uint64_t{1} << unit % kBits;
    const std::atomic_ref<std::uint64_t> bits(touched_[unit / kBits]);
    if ((bits.load(std::memory_order_relaxed) & bit) == 0) bits.fetch_or(bit, std::memory_order_relaxed);
  }
  std::uint64_t bytes() const {
    std::uint64_t units = 0;
    for (const std::uint64_t bits : touched_) units += static_cast<unsigned>(std::popcount(bits));
    return units * unit_;
  }

 private:
  static constexpr std::uint64_t kBits = 64;
  std::uint64_t unit_;
  std::vector<std::uint64_t> touched_;
};

/// The nodes that the current ray has visited: a hash table as large as the longest ray needs, which stays in the
/// cache, instead of one as large as the image. One per thread.
class VisitTracker {
 public:
  explicit VisitTracker(Footprint& footprint) : footprint_(&footprint) {}
  void begin_ray() {
    if (++ray_ == 0) {  // after 2^32 rays old entries would count as this ray's
      table_.assign(table_.size(), {});
      ray_ = 1;
    }
    used_ = 0;
  }
  void visit(std::uint32_t unit, unsigned size_units) {
    Place& place = place_of(unit);
    if (place.ray == ray_) return;
    place = {unit, ray_};
    ++unique_;
    for (unsigned i = 0; i < size_units; ++i) footprint_->touch(unit + i);
    if (2 * ++used_ > table_.size()) grow();
  }
  std::uint64_t unique() const { return unique_; }

 private:
  struct Place {
    std::uint32_t unit = 0;
    std::uint32_t ray = 0;  ///< that visited it; if not the current ray, the place is free
  };
  /// Place of the unit, or the free place for it.
  Place& place_of(std::uint32_t unit) {
    std::size_t at = unit * 0x9E3779B1u >> shift_;
    while (table_[at].ray == ray_ && table_[at].unit != unit) at = (at + 1) & (table_.size() - 1);
    return table_[at];
  }
  [[gnu::noinline]] void grow() {
    std::vector<Place> old(2 * table_.size());
    old.swap(table_);
    --shift_;
    for (const Place& place : old) {
      if (place.ray == ray_) place_of(place.unit) = place;
    }
  }

  unsigned shift_ = 20;
  std::vector<Place> table_ = std::vector<Place>(std::size_t{1} << (32 - shift_));
  std::size_t used_ = 0;
  Footprint* footprint_;
  std::uint32_t ray_ = 1;
  std::uint64_t unique_ = 0;
};

}  // namespace grtx::frontend
