// A ray's checkpoint entries as a log that is only appended to: what is forwarded stays where it is, and the list that
// the next round reads names it by runs. The ring behind the log has room for four buffers: an entry is named when it
// is at most one buffer old, the round may append a second one, and the next round a third before it reads the entry.
// Without time; docs/model/checkpoint_unit.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/ring_queue.h"

namespace grtx::modules {

class CheckpointLog {
 public:
  /// Entries that a ray has read one after the other, and forwarded: positions first, first + step, ...
  struct Run {
    std::uint64_t first = 0;
    std::uint32_t count = 0;
    std::int32_t step = 1;  ///< 1 or -1
    std::uint64_t position(std::uint32_t i) const {
      return first + static_cast<std::uint64_t>(static_cast<std::int64_t>(i) * step);
    }
  };
  struct Counters {
    std::uint64_t runs_written = 0, runs_read = 0, runs_left = 0;
    std::uint64_t entries_referenced = 0, references_read = 0, references_left = 0, copies_forced = 0;
    static const CounterTable<Counters>& table();
    void add(const Counters& other) { table().add(*this, other); }
  };
  struct Appended {
    std::uint64_t position = 0;
    bool run = false;
  };
  struct Read {
    std::uint64_t position = 0;
    bool run = false;   ///< a run entry
    bool down = false;  ///< the next one lies before it
  };

  /// A round begins; what was written last is its source, if it replays. first: of a ray.
  void begin(bool first, bool replays, std::uint64_t capacity, bool lifo);
  /// See CheckpointLayout::submit().
  unsigned submit(unsigned entries, bool forwarded, bool last);
  /// The next of the items that submit() announced takes its place.
  Appended append();
  bool has_more() const { return reading_.count > 0 || begin_ != end_; }
  /// The next place to read, if there is more; behind a run entry it is the first that this names.
  Read read();
  /// The rest of the source list.
  struct Unread {
    std::uint64_t place = 0;   ///< next
    std::uint64_t places = 0;  ///< from there on, or down
    std::uint64_t until_run = 0;
    bool begun = false;
  };
  Unread unread() const;
  std::uint64_t appended() const { return head_; }  ///< items since the ray began

  /// Adds what has become of the runs of this ray and of those before it.
  void count(Counters& all) const;

 private:
  struct Placed {
    std::uint64_t at = 0;  ///< position of the run entry
    Run run;
  };
  unsigned close_run();
  void leave(const std::vector<Placed>& runs, std::size_t first, std::size_t last);

  bool lifo_ = false;
  std::uint64_t capacity_ = 0;
  std::uint64_t head_ = 0;      ///< next position to append to
  std::uint64_t assigned_ = 0;  ///< the same, of items that are announced
  // The source list: positions begin_ to end_ are not read yet; of runs_, those from unread_ on, or before it when
  // lifo.
  std::uint64_t begin_ = 0, end_ = 0;
  std::vector<Placed> runs_;
  std::size_t unread_ = 0;
  bool begun_ = false;          ///< something of the list has been read
  Run reading_;                 ///< what is left of the run that is being read
  std::uint64_t position_ = 0;  ///< of the entry read last
  // The destination list.
  std::uint64_t written_from_ = 0;
  std::vector<Placed> written_;
  RingQueue<std::uint8_t> announced_{2};  ///< items: whether each is a run entry
  Run pending_;                           ///< forwarded, neither named nor copied yet
  Counters counters_;
};

}  // namespace grtx::modules
