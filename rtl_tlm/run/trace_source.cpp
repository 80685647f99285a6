// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/trace_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <numeric>

#include "grtx/base/error.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/traces/decoded_size.h"

namespace grtx::sim {

void check_group(const traces::RayGroup& group, const traces::Header& header, const std::string& file) {
  const auto refuse = [&](std::size_t lane, std::size_t round, const std::string& rule) {
    throw Error(file, fmt::format("group {} lane {} round {}", group.index, lane, round), rule);
  };
  if (group.rays.size() > header.warp_size) {
    throw Error(file, fmt::format("group {}", group.index), fmt::format("at most {} rays", header.warp_size));
  }
  const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
  for (std::size_t lane = 0; lane < group.rays.size(); ++lane) {
    const traces::Ray& ray = group.rays[lane];
    if (ray.pixel >= pixels) refuse(lane, 0, fmt::format("pixel {} is outside the image", ray.pixel));
    std::uint64_t events = 0;
    std::uint64_t processed = 0;
    for (std::size_t r = 0; r < ray.rounds.size(); ++r) {
      const traces::Round& round = ray.rounds[r];
      if (round.k_count > header.k) refuse(lane, r, fmt::format("k-buffer holds at most {} entries", header.k));
      // Entries leave where opacity hides them.
      const unsigned most = header.opacity_bound == traces::OpacityBound::on ? header.k : round.k_count;
      if (round.preloaded > most) refuse(lane, r, "more entries preloaded than the k-buffer has at the end");
      if (round.processed_count > round.k_count) refuse(lane, r, "more entries processed than the k-buffer has");
      events += round.event_count;
      processed += round.processed_count;
      if (events > ray.events.size()) refuse(lane, r, "its events must lie inside the ray");
      if (processed > ray.processed.size()) refuse(lane, r, "its processed entries must lie inside the ray");
    }
    for (const traces::Processed& p : ray.processed) {
      if (p.gaussian >= header.gaussians) refuse(lane, 0, fmt::format("Gaussian {} is not in the scene", +p.gaussian));
    }
  }
}

TraceSource::TraceSource(const traces::Reader& reader, unsigned decode_ahead)
    : TraceSource(reader, all_groups(reader), decode_ahead) {}

TraceSource::TraceSource(const traces::Reader& reader, std::vector<std::uint64_t> indices, unsigned decode_ahead)
    : reader_(reader), indices_(std::move(indices)), depth_(decode_ahead) {
  for (const std::uint64_t index : indices_) {
    if (index >= reader.group_count()) {
      throw Error(reader.path(), fmt::format("group {}", index), fmt::format("has {} groups", reader.group_count()));
    }
  }
  if (depth_ > 0) thread_ = std::thread([this] { this->decode_ahead(); });
}

TraceSource::~TraceSource() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

// Call with mutex_ held if there is a decoding thread.
TraceSource::Group TraceSource::take_spare() {
  if (spare_.empty()) {
    ++allocated_;
    return std::make_unique<traces::RayGroup>();
  }
  Group group = std::move(spare_.back());
  spare_.pop_back();
  return group;
}

TraceSource::Group TraceSource::decode(std::uint64_t position, Group group) const {
  reader_.read(indices_[position], *group);
  check_group(*group, reader_.header(), reader_.path());
  return group;
}

std::size_t TraceSource::groups_allocated() const {
  const std::lock_guard lock(mutex_);
  return allocated_;
}

void TraceSource::decode_ahead() {
  for (std::uint64_t position = 0; position < indices_.size(); ++position) {
    Group group;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || (ready_.size() < depth_ && ready_bytes_ < kDecodeAheadBytes); });
      if (stopping_) return;
      group = take_spare();
    }
    std::exception_ptr failure;
    try {
      group = decode(position, std::move(group));
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      if (failure) {
        failure_ = failure;
      } else {
        ready_bytes_ += traces::decoded_bytes(*group);
        ready_.push_back(std::move(group));
      }
    }
    changed_.notify_all();
    if (failure) return;
  }
}

const traces::RayGroup* TraceSource::acquire(std::uint64_t position) {
  assert(position == next_ && position < indices_.size());
  Group group;
  if (depth_ == 0) {
    group = decode(position, take_spare());
  } else {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !ready_.empty() || failure_; });
    if (ready_.empty()) std::rethrow_exception(failure_);
    group = std::move(ready_.front());
    ready_.pop_front();
    ready_bytes_ -= traces::decoded_bytes(*group);
    lock.unlock();
    changed_.notify_all();
  }
  ++next_;
  held_.push_back({position, std::move(group)});
  return held_.back().group.get();
}

void TraceSource::release(std::uint64_t position) {
  const auto held = std::find_if(held_.begin(), held_.end(), [&](const Held& h) { return h.position == position; });
  assert(held != held_.end());
  if (traces::decoded_bytes(*held->group) > kDecodeAheadBytes / kDecodeAhead)
    *held->group = {};  // memory of a large group is freed, not reused
  {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(held->group));
  }
  *held = std::move(held_.back());
  held_.pop_back();
}

std::vector<std::uint64_t> all_groups(const traces::Reader& reader) {
  std::vector<std::uint64_t> groups(reader.group_count());
  std::iota(groups.begin(), groups.end(), std::uint64_t{0});
  return groups;
}

}  // namespace grtx::sim
