#include "grtx/modules/rtl/bin_distances.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/decide/checkpoint_layout.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rtl/intersection_operands.h"

namespace grtx::modules {
namespace {

constexpr unsigned kDroppedBits = 20;  ///< of fp32: exponent and three bits of the mantissa name a stretch
constexpr std::uint32_t kInfinity = 0x7f800000;
constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

[[noreturn]] void inconsistent() {
  throw Error("trace", "checkpoint bins", "no distances lead to a ray's bins and to the order in which it reads them");
}

/// Lowest number from `from` on that is `rest` modulo a power of two.
std::uint32_t from_on(std::uint32_t from, std::uint32_t rest, unsigned modulus) {
  return from + ((rest - from) & (modulus - 1));
}

}  // namespace

std::uint32_t stretch_of(std::uint32_t t, std::uint32_t enter) {
  const float distance = std::max(std::bit_cast<float>(t) - std::bit_cast<float>(enter), 0.0f);
  return std::bit_cast<std::uint32_t>(distance) >> kDroppedBits;
}

int bin_of(const traces::CheckpointBins& places, std::uint32_t nearest, std::uint32_t number) {
  const std::uint32_t near = places.near(), behind = nearest + near;
  if (number >= behind && !places.full(places.far_bin())) return static_cast<int>(places.far_bin());
  for (std::uint32_t n = std::min(number, behind - 1); n + 1 > nearest; --n) {
    if (!places.full(n % near)) return static_cast<int>(n % near);
    if (n == 0) break;
  }
  return kNoBin;
}

void BinnedRay::begin_ray(const traces::Ray& ray, std::uint64_t seed) {
  ray_ = &ray;
  seed_ = seed;
  taken_ = 0;
  const std::uint64_t any = mixed(seed);
  if (any % 4 == 0) {  // inside the scene: all distances that fp32 has
    enter_ = 0;
    base_ = 200 + static_cast<std::uint32_t>(any >> 32) % 1600;
  } else {
    enter_ = std::bit_cast<std::uint32_t>(static_cast<float>((any >> 8) % 4096) / 1024.0f);
    base_ = 950 + static_cast<std::uint32_t>(any >> 32) % 100;
  }
  plan(any);
}

// The far bin is read when the near ones have come to its lowest stretch, and that is where t_max was when something
// was first written to it. So the order of a later round tells that stretch, up to multiples of the near bins. From one
// time when the bin is empty to the next it only falls, with a write.
void BinnedRay::plan(std::uint64_t seed) {
  struct Span {
    std::size_t first;                  ///< entry with which it begins
    std::optional<std::uint32_t> rest;  ///< of the stretch, modulo near
    bool anew;                          ///< the bin was empty
  };
  std::vector<Span> spans;
  std::vector<std::size_t> span_of(ray_->rounds.size(), kNowhere);
  traces::CheckpointBins places(near_, capacity_);
  std::size_t event = 0, entry = 0;
  std::size_t may_fall = kNowhere;  ///< entry at which it may have fallen since the last round that told it
  for (std::size_t r = 0; r < ray_->rounds.size(); ++r) {
    const traces::Round& round = ray_->rounds[r];
    places.begin_round(round.replay, round.bins);
    // Its turn is at or behind t_max + near, if it can fall.
    const bool falls = !round.replay || places.empty(places.far_bin()) || round.bins.before_far == near_;
    if (round.replay && !places.empty(places.far_bin())) {
      const unsigned ahead = round.bins.before_far;
      if (ahead > 0 && ahead < near_) {
        const std::uint32_t rest = (round.bins.first + ahead) % near_;
        if (spans.back().rest && *spans.back().rest != rest) {
          if (may_fall == kNowhere) inconsistent();
          spans.push_back({may_fall, rest, false});
        }
        spans.back().rest = rest;
        may_fall = kNowhere;
      }
      span_of[r] = spans.size() - 1;
    }
    for (std::uint32_t e = 0; e < round.event_count; ++e, ++event) {
      const EventEffect effect(ray_->events[event]);
      if (effect.replays()) {
        if (!places.more()) CheckpointLayout::refuse("reads");
        places.read();
      }
      for (unsigned i = 0; i < effect.checkpoints(); ++i, ++entry) {
        if (entry == ray_->bins.size() || places.full(ray_->bins[entry])) CheckpointLayout::refuse("writes");
        const unsigned bin = ray_->bins[entry];
        if (bin == places.far_bin()) {
          if (places.empty(bin)) {
            spans.push_back({entry, std::nullopt, true});
            may_fall = kNowhere;
          } else if (falls && may_fall == kNowhere) {
            may_fall = entry;
          }
        }
        places.write(bin);
      }
    }
  }
  // Numbers.
  std::vector<std::uint32_t> bounds;
  for (const Span& span : spans) {
    const std::uint32_t any = static_cast<std::uint32_t>(mixed(seed + span.first));
    std::uint32_t bound = span.anew ? base_ + any % near_ : bounds.back() - 1;
    if (span.rest) bound -= (bound - *span.rest) & (near_ - 1);
    if (bound < 3 * near_) inconsistent();
    bounds.push_back(bound);
  }
  far_bound_.assign(ray_->bins.size(), 0);
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const std::size_t end = s + 1 < spans.size() ? spans[s + 1].first : far_bound_.size();
    std::fill(far_bound_.begin() + static_cast<std::ptrdiff_t>(spans[s].first),
              far_bound_.begin() + static_cast<std::ptrdiff_t>(end), bounds[s]);
  }
  reached_.clear();
  for (std::size_t r = 0; r < ray_->rounds.size(); ++r) {
    const traces::BinOrder& order = ray_->rounds[r].bins;
    std::uint32_t number = from_on(base_, order.first, near_);
    if (span_of[r] < spans.size()) {
      const std::uint32_t bound = bounds[span_of[r]];
      if (order.before_far == 0) {
        number = from_on(bound, order.first, near_);
      } else if (order.before_far < near_) {
        number = bound - order.before_far;
      } else {
        number = from_on(bound - 3 * near_ + 1, order.first, near_);  // before the bin, also if it falls in the round
      }
    }
    reached_.push_back(number);
  }
}

void BinnedRay::begin_round(std::uint32_t round) {
  const traces::Round& now = ray_->rounds[round];
  lists_.begin_round(now.replay, now.bins);
  reads_from_ = reached_[round];
  last_t_max_ = t_in(reads_from_, mixed(seed_ + round));
}

std::uint32_t BinnedRay::t_in(std::uint32_t number, std::uint64_t seed) const {
  for (unsigned attempt = 0; attempt < 64; ++attempt) {
    seed = mixed(seed);
    const std::uint32_t low = seed >> 60 == 0 ? 0 : static_cast<std::uint32_t>(seed) % (1u << kDroppedBits);
    const float t = std::bit_cast<float>(enter_) + std::bit_cast<float>((number << kDroppedBits) | low);
    if (stretch_of(std::bit_cast<std::uint32_t>(t), enter_) == number) return std::bit_cast<std::uint32_t>(t);
  }
  inconsistent();
}

void BinnedRay::offer_from_here() {
  ahead_ = lists_.places();
  offered_ = taken_;
}

BinnedRay::Offer BinnedRay::offer() {
  if (offered_ == ray_->bins.size() || ahead_.full(ray_->bins[offered_])) CheckpointLayout::refuse("writes");
  Offer offer;
  offer.bin = ray_->bins[offered_];
  const std::uint64_t any = mixed(seed_ ^ (offered_ * 0x100000001b3u));
  std::uint32_t number;
  if (offer.bin == ahead_.far_bin()) {
    // The first one says from where on the bin holds.
    const bool bounds = ahead_.empty(offer.bin) || (offered_ > 0 && far_bound_[offered_] != far_bound_[offered_ - 1]);
    offer.nearest = far_bound_[offered_] - near_ + static_cast<std::uint32_t>(bounds ? 0 : any % 3);
    number = offer.nearest + near_ + static_cast<std::uint32_t>(any >> 8) % 3;
  } else {
    offer.nearest = base_ + static_cast<std::uint32_t>(any >> 16) % near_;
    std::vector<std::uint32_t> choices;  // its own stretch, or one whose bin is full
    for (std::uint32_t n = offer.nearest; n <= offer.nearest + near_; ++n) {
      if (bin_of(ahead_, offer.nearest, n) == static_cast<int>(offer.bin)) choices.push_back(n);
    }
    number = choices[(any >> 32) % choices.size()];
  }
  EntryTimes& times = offer.times;
  for (std::uint64_t seed = any; times.t <= times.t_max; seed = mixed(seed)) {
    times.t_max = t_in(offer.nearest, seed);
    times.t = t_in(number, ~seed);
    if (times.t < times.t_max) std::swap(times.t, times.t_max);
  }
  times.t_min = any >> 60 == 0 ? 0x80000000u : static_cast<std::uint32_t>((any >> 32) % (times.t_max + 1u));
  offer.entry = {times.t, static_cast<std::uint32_t>(mixed(any))};
  ahead_.write(offer.bin);
  ++offered_;
  return offer;
}

void BinnedRay::take(const Offer& offer) {
  const traces::CheckpointBins& places = lists_.places();
  if (offer.bin == places.far_bin()) {
    const std::uint32_t behind = offer.nearest + near_;
    far_from_ = places.empty(offer.bin) ? behind : std::min(far_from_, behind);
  }
  lists_.write(offer.bin, offer.entry);
  ++taken_;
}

BinnedRay::Probe BinnedRay::probe(std::uint64_t seed) const {
  Probe probe;
  const std::uint64_t any = mixed(seed);
  EntryTimes& times = probe.times;
  if (any % 2 == 0) {  // any two, also before the scene
    times.t_max = static_cast<std::uint32_t>(any >> 8) % kInfinity;
    times.t = times.t_max + static_cast<std::uint32_t>(mixed(any)) % (kInfinity - times.t_max);
  } else {  // near ones
    const std::uint32_t nearest = base_ + static_cast<std::uint32_t>(any >> 8) % near_;
    times.t_max = t_in(nearest, any);
    times.t = t_in(nearest + static_cast<std::uint32_t>(any >> 16) % (near_ + 2), ~any);
    if (times.t < times.t_max) std::swap(times.t, times.t_max);
  }
  probe.bin = bin_of(lists_.places(), stretch_of(times.t_max, enter_), stretch_of(times.t, enter_));
  return probe;
}

std::uint32_t BinnedRay::next_number() const {
  const traces::CheckpointBins& places = lists_.places();
  return places.next_is_far() ? far_from_ : reads_from_ + places.near_before();
}

std::uint32_t BinnedRay::reaching_t_max() const {
  const std::uint64_t any = mixed(seed_ + taken_ + places().size() * 0x10001);
  return t_in(next_number() + static_cast<std::uint32_t>(any >> 32) % 2, any);
}

std::uint32_t BinnedRay::falling_short() const {
  const std::uint32_t number = next_number();
  return number == 0 ? 0 : t_in(number - 1, mixed(seed_ + taken_));
}

}  // namespace grtx::modules
