// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/traces/check.h"
#include "grtx/traces/codec/node_places.h"
#include "grtx/traces/count_totals.h"
#include "grtx/traces/reader.h"

namespace grtx::traces {
namespace {

// Threads take groups in ascending order, so when one fails, all groups before it are done or in progress. Hence the
// failure with the lowest index is the same for any number of threads.
class GroupQueue {
 public:
  explicit GroupQueue(std::uint64_t count) : count_(count) {}

  bool take(std::uint64_t& index) {
    if (stopped_.load()) return false;
    index = next_.fetch_add(1);
    return index < count_;
  }
  void fail(std::uint64_t index, std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    stopped_.store(true);
    if (!failure_ || index < failed_) {
      failed_ = index;
      failure_ = std::move(failure);
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::uint64_t count_;
  std::atomic<std::uint64_t> next_{0};
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::uint64_t failed_ = 0;
  std::exception_ptr failure_;
};

/// Results of one thread.
struct Share {
  explicit Share(const Header& header) : places(header) {}
  Totals sum;
  NodePlaces places;
};

void check_groups(const Reader& reader, GroupQueue& queue, Progress& progress, Share& share) {
  RayGroup group;
  std::uint64_t index = 0;
  while (queue.take(index)) {
    try {
      reader.read(index, group);
      add_totals(share.sum, check_group(reader.path(), reader.header(), group));
      share.places.add(group);
    } catch (...) {
      queue.fail(index, std::current_exception());
      return;
    }
    progress.add(1);
  }
}

void compare_totals(const std::string& file, const Totals& stored, const Totals& counted) {
  for (const auto& [name, field, largest] : kTotalFields) {
    if (stored.*field == counted.*field) continue;
    throw Error(
        file, std::string("totals ") + name,
        "stored as " + std::to_string(stored.*field) + ", but the groups give " + std::to_string(counted.*field));
  }
}

}  // namespace

Totals check(const Reader& reader, bool quiet) {
  reader.verify_content();
  const std::uint64_t groups = reader.group_count();
  const std::uint64_t wanted = std::max(1U, std::thread::hardware_concurrency());
  const auto threads = static_cast<std::size_t>(std::min(wanted, std::max<std::uint64_t>(1, groups)));
  GroupQueue queue(groups);
  Progress progress("trace-check", groups, "groups", quiet);
  std::vector<Share> shares(threads, Share(reader.header()));
  {
    std::vector<std::jthread> pool;
    for (std::size_t i = 1; i < threads; ++i) {
      pool.emplace_back([&, i] { check_groups(reader, queue, progress, shares[i]); });
    }
    check_groups(reader, queue, progress, shares[0]);
  }
  progress.finish();
  queue.rethrow();
  Totals counted;
  for (const Share& share : shares) add_totals(counted, share.sum);
  for (std::size_t i = 1; i < threads; ++i) shares[0].places.add(shares[i].places);
  shares[0].places.check(reader.path());
  compare_totals(reader.path(), reader.totals(), counted);
  return counted;
}

}  // namespace grtx::traces
