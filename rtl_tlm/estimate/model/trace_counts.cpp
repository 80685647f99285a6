#include "grtx/rtl_tlm/estimate/model/trace_counts.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <unordered_map>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim {
namespace {

// The file: this text, the trace's hash (16 digits), then little-endian words of 32 bits; the last two are XXH3 of all
// before. The words: groups; of each its kind and rounds; of each round lanes, units, written, read, processed, the
// classes, and of each lane visits and any-hit calls.
constexpr std::string_view kMagic = "grtx.counts/1\n";
constexpr std::size_t kHashDigits = 16;

/// Stack distances of one warp: a Fenwick tree over its visits marks the last one of each unit.
class StackDistances {
 public:
  explicit StackDistances(std::size_t visits) : tree_(visits + 1) {}

  std::size_t visit(std::uint32_t unit) {
    const auto now = static_cast<std::uint32_t>(++visits_);
    std::size_t reuse_class = kReuseClasses - 1;
    const auto [last, first] = last_.try_emplace(unit, now);
    if (!first) {
      const std::uint32_t distance = below(now) - below(last->second + 1);
      reuse_class = std::min<std::size_t>(std::bit_width(distance), kReuseClasses - 2);
      add(last->second, -1);
      last->second = now;
    }
    add(now, 1);
    return reuse_class;
  }

 private:
  void add(std::size_t at, int value) {
    for (; at < tree_.size(); at += at & (~at + 1)) tree_[at] += value;
  }
  std::uint32_t below(std::size_t end) const {  ///< marks at 1 .. end - 1
    int sum = 0;
    for (std::size_t at = end - 1; at > 0; at &= at - 1) sum += tree_[at];
    return static_cast<std::uint32_t>(sum);
  }

  std::vector<int> tree_;
  std::unordered_map<std::uint32_t, std::uint32_t> last_;
  std::size_t visits_ = 0;
};

struct Lane {
  const traces::Event* event = nullptr;
  const traces::Event* end = nullptr;
  LaneCounts counts;
};

/// Goes on to the lane's next visit and counts it; events without a fetch on the way too. False: none is left.
bool step(Lane& lane, const traces::RayGroup& group, StackDistances& distances, RoundCounts& round) {
  while (lane.event != lane.end) {
    const traces::Event& event = *lane.event++;
    const traces::EventKind kind = event.kind();
    round.written += static_cast<std::uint32_t>(std::popcount(event.checkpoints));
    if (kind == traces::EventKind::replay_take || kind == traces::EventKind::replay_forward) ++round.read;
    if (kind > traces::EventKind::visit_leaf) continue;
    const bool internal = kind == traces::EventKind::visit_internal;
    ++round.reuse[distances.visit(internal ? group.nodes[event.node].address : event.node)];
    round.units += kind == traces::EventKind::visit_instance ? 4 : 2;
    ++lane.counts.visits;
    if (kind == traces::EventKind::visit_leaf && traces::calls_any_hit(event.outcome())) ++lane.counts.any_hits;
    return true;
  }
  return false;
}

class Words {
 public:
  void put(std::uint32_t word) {
    const std::uint32_t little = std::endian::native == std::endian::little ? word : __builtin_bswap32(word);
    text_.append(reinterpret_cast<const char*>(&little), sizeof little);
  }
  std::string& text() { return text_; }

 private:
  std::string text_;
};

std::string bytes_of(const TraceCounts& counts) {
  Words words;
  words.text() = std::string(kMagic) + counts.trace;
  words.put(static_cast<std::uint32_t>(counts.groups.size()));
  for (const GroupCounts& group : counts.groups) {
    words.put(static_cast<std::uint32_t>(group.kind));
    words.put(static_cast<std::uint32_t>(group.rounds.size()));
    for (const RoundCounts& round : group.rounds) {
      for (const std::size_t word : {round.lanes.size(), std::size_t{round.units}, std::size_t{round.written},
                                     std::size_t{round.read}, std::size_t{round.processed}}) {
        words.put(static_cast<std::uint32_t>(word));
      }
      for (const std::uint32_t visits : round.reuse) words.put(visits);
      for (const LaneCounts& lane : round.lanes) {
        words.put(lane.visits);
        words.put(lane.any_hits);
      }
    }
  }
  const std::uint64_t hash = xxh3(words.text());
  words.put(static_cast<std::uint32_t>(hash));
  words.put(static_cast<std::uint32_t>(hash >> 32));
  return std::move(words.text());
}

/// Words of a text whose hash is right; a count that is no longer covered by it is one of another program's file.
class WordReader {
 public:
  explicit WordReader(std::string_view text) : text_(text) {}
  std::uint32_t next() {
    if (text_.size() < 4) {
      good_ = false;
      return 0;
    }
    std::uint32_t word = 0;
    std::memcpy(&word, text_.data(), 4);
    text_.remove_prefix(4);
    return std::endian::native == std::endian::little ? word : __builtin_bswap32(word);
  }
  /// A number of records of so many words.
  std::uint32_t count(std::size_t words) {
    const std::uint32_t n = next();
    if (n > text_.size() / (4 * words)) good_ = false;
    return good_ ? n : 0;
  }
  bool complete() const { return good_ && text_.empty(); }

 private:
  std::string_view text_;
  bool good_ = true;
};

/// False: not of this trace, or damaged.
bool parse(std::string_view text, TraceCounts& counts) {
  if (text.size() < kMagic.size() + kHashDigits + 8) return false;
  if (text.substr(kMagic.size(), kHashDigits) != counts.trace) return false;
  WordReader hash(text.substr(text.size() - 8));
  const std::uint64_t low = hash.next();
  if (xxh3(text.substr(0, text.size() - 8)) != (low | std::uint64_t{hash.next()} << 32)) return false;
  text.remove_suffix(8);
  text.remove_prefix(kMagic.size() + kHashDigits);
  WordReader words(text);
  counts.groups.resize(words.count(2));
  for (GroupCounts& group : counts.groups) {
    group.kind = static_cast<traces::RayKind>(words.next());
    group.rounds.resize(words.count(5 + kReuseClasses));
    for (RoundCounts& round : group.rounds) {
      round.lanes.resize(words.count(2));
      for (std::uint32_t* word : {&round.units, &round.written, &round.read, &round.processed}) *word = words.next();
      for (std::uint32_t& visits : round.reuse) visits = words.next();
      for (LaneCounts& lane : round.lanes) lane = {words.next(), words.next()};
    }
  }
  return words.complete();
}

}  // namespace

GroupCounts count_group(const traces::RayGroup& group) {
  GroupCounts counts;
  counts.kind = group.kind;
  std::size_t rounds = 0, events = 0;
  for (const traces::Ray& ray : group.rays) {
    rounds = std::max(rounds, ray.rounds.size());
    events += ray.events.size();
  }
  StackDistances distances(events);
  counts.rounds.resize(rounds);
  std::vector<const traces::Event*> next;
  for (const traces::Ray& ray : group.rays) next.push_back(ray.events.data());
  for (std::size_t r = 0; r < rounds; ++r) {
    RoundCounts& round = counts.rounds[r];
    std::vector<Lane> lanes;
    for (std::size_t i = 0; i < group.rays.size(); ++i) {
      if (r >= group.rays[i].rounds.size()) continue;
      const traces::Round& call = group.rays[i].rounds[r];
      round.processed += call.processed_count;
      lanes.push_back({next[i], next[i] + call.event_count, {}});
      next[i] += call.event_count;
    }
    for (bool stepped = true; stepped;) {
      stepped = false;
      for (Lane& lane : lanes) stepped |= step(lane, group, distances, round);
    }
    for (const Lane& lane : lanes) {
      if (lane.counts.visits > 0) round.lanes.push_back(lane.counts);
    }
    std::sort(round.lanes.begin(), round.lanes.end(),
              [](const LaneCounts& a, const LaneCounts& b) { return a.visits < b.visits; });
  }
  return counts;
}

std::string counts_path(const std::string& trace_path) { return trace_path + ".counts"; }

TraceCounts counts_of(const traces::Reader& reader) {
  TraceCounts counts;
  counts.trace = reader.content_hash();
  const std::string path = counts_path(reader.path());
  if (std::filesystem::exists(path)) {
    const std::string text = read_file(path);
    if (!text.starts_with(kMagic)) throw Error(path, "", "is no file of counts: the model would overwrite it");
    if (parse(text, counts) && counts.groups.size() == reader.group_count()) return counts;
  }
  reader.verify_content();
  counts.groups.clear();
  counts.groups.reserve(reader.group_count());
  traces::RayGroup group;
  for (std::uint64_t index = 0; index < reader.group_count(); ++index) {
    reader.read(index, group);
    check_group(group, reader.header(), reader.path());
    counts.groups.push_back(count_group(group));
  }
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK) == 0) write_file(path, bytes_of(counts));
  return counts;
}

}  // namespace grtx::sim
