// SPDX-License-Identifier: Apache-2.0
// Feeds the ray groups of a trace file to the work distributor. Holds in memory only the groups of resident warps and
// those decoded ahead, which are limited in number and bytes. Memory of groups is reused.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Groups that are decoded before they are needed; the decoding thread never affects results.
inline constexpr unsigned kDecodeAhead = 32;
/// Limit of their bytes. A larger group is still decoded ahead, alone.
inline constexpr std::uint64_t kDecodeAheadBytes = std::uint64_t{64} << 20;

class TraceSource final : public modules::GroupSource {
 public:
  /// All groups of the trace, in file order. decode_ahead: groups that a thread of its own decodes before they are
  /// asked for; 0 decodes in acquire(). Results never depend on it.
  explicit TraceSource(const traces::Reader& reader, unsigned decode_ahead = 0);
  /// The groups `indices` of the trace, in that order (windows mode). Throws Error if one is not in the file.
  TraceSource(const traces::Reader& reader, std::vector<std::uint64_t> indices, unsigned decode_ahead = 0);
  ~TraceSource() override;
  TraceSource(const TraceSource&) = delete;
  TraceSource& operator=(const TraceSource&) = delete;

  std::uint64_t count() const override { return indices_.size(); }
  /// Throws Error if the group cannot be decoded or contradicts the header (see check_group).
  const traces::RayGroup* acquire(std::uint64_t position) override;
  void release(std::uint64_t position) override;

  std::size_t groups_held() const { return held_.size(); }  ///< acquired, not yet released
  std::size_t groups_allocated() const;                     ///< most that ever existed at a time

 private:
  using Group = std::unique_ptr<traces::RayGroup>;
  struct Held {
    std::uint64_t position = 0;
    Group group;
  };

  Group take_spare();
  Group decode(std::uint64_t position, Group group) const;
  void decode_ahead();

  const traces::Reader& reader_;
  std::vector<std::uint64_t> indices_;
  std::vector<Held> held_;
  std::uint64_t next_ = 0;  ///< position that acquire() must ask for

  // Shared with the decoding thread.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Group> spare_;
  std::deque<Group> ready_;  ///< decoded, from position next_ on
  std::uint64_t ready_bytes_ = 0;
  std::exception_ptr failure_;
  std::size_t allocated_ = 0;
  bool stopping_ = false;
  std::size_t depth_;
  std::thread thread_;
};

/// The numbers of all groups of a trace.
std::vector<std::uint64_t> all_groups(const traces::Reader& reader);

/// Throws Error unless the rounds of `group` fit the header and the group's own arrays, so that the hardware modules
/// can index safely. It does not prove consistency (traces::check does).
void check_group(const traces::RayGroup& group, const traces::Header& header, const std::string& file);

}  // namespace grtx::sim
