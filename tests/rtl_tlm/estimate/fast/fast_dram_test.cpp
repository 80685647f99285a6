// The DRAM channel of fast mode against that of the cycle model: so many reads of lines under way at random rows, each
// followed by another when its data is there and now and then by a write.
#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <ostream>
#include <queue>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/modules/dram/decide/dram_mapping.h"
#include "grtx/rtl_tlm/estimate/fast/fast_dram.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "paths.h"

namespace grtx::sim {
namespace {

struct Load {
  const char* name;
  const char* file;
  unsigned reads;          ///< under way
  double writes;           ///< a read
  double next_line = 0.0;  ///< share of reads that go to the line behind the one before
  double tolerance;        ///< of the clocks a read takes
  friend void PrintTo(const Load& load, std::ostream* out) { *out << load.name; }
};

constexpr unsigned kReads = 8000, kSectors = 2;
constexpr Cycle kPause = 100;  ///< from the data of a read to the next

class Traffic {
 public:
  explicit Traffic(const Load& load) : load_(load) {}
  std::uint64_t read() { return last_ = share(random_) < load_.next_line ? last_ + 128 : random_() % (1 << 20) * 128; }
  std::uint64_t write() { return random_() % (1 << 20) * 128; }
  bool writes() { return share(random_) < load_.writes; }

 private:
  static double share(std::mt19937_64& random) { return std::uniform_real_distribution<>(0.0, 1.0)(random); }
  const Load& load_;
  std::mt19937_64 random_{1};
  std::uint64_t last_ = 0;
};

struct Arrival {
  Cycle clock = 0;
  std::uint64_t number = 0, address = 0;
  bool write = false;
  bool operator>(const Arrival& other) const { return std::tie(clock, number) > std::tie(other.clock, other.number); }
};
using Arrivals = std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>>;

double clocks_of_a_read(const modules::DramChannelConfig& config, const Load& load) {
  modules::DramChannel channel(config);
  Traffic traffic(load);
  Arrivals coming;
  std::uint64_t number = 0;
  for (unsigned i = 0; i < load.reads; ++i) coming.push({i, number++, traffic.read(), false});
  std::deque<std::pair<Arrival, unsigned>> waiting;  // with the sectors that are in the channel
  std::map<std::uint64_t, unsigned> answered;        // sectors, of reads
  Cycle now = 0;
  for (unsigned done = 0; done < kReads; ++now) {
    for (; !coming.empty() && coming.top().clock <= now; coming.pop()) waiting.push_back({coming.top(), 0});
    for (; !waiting.empty() && channel.can_accept(32);
         waiting.front().second == kSectors ? waiting.pop_front() : void()) {
      auto& [next, sent] = waiting.front();
      channel.enqueue(now, next.number, next.address + 32 * sent++, 32, next.write);
      if (next.write && sent == kSectors) answered[next.number] = kSectors;  // nobody waits for it
    }
    channel.run_until(now);
    for (auto& all = channel.completions(); !all.empty() && all.front().done <= now; all.pop()) {
      if (++answered[all.front().id] != kSectors) continue;
      ++done;
      coming.push({now + kPause, number++, traffic.read(), false});
      if (traffic.writes()) coming.push({now + 1, number++, traffic.write(), true});
    }
  }
  return static_cast<double>(now) / kReads;
}

double fast_clocks_of_a_read(const modules::DramChannelConfig& config, const Load& load) {
  FastDramChannel channel(config);
  Traffic traffic(load);
  Arrivals coming, data;
  std::uint64_t number = 0;
  for (unsigned i = 0; i < load.reads; ++i) coming.push({i, number++, traffic.read(), false});
  Cycle now = 0;
  for (unsigned done = 0; done < kReads;) {
    const bool answers = !data.empty() && data.top().clock <= coming.top().clock;
    const Arrival next = answers ? data.top() : coming.top();
    (answers ? data : coming).pop();
    now = next.clock;
    channel.advance(now);
    if (answers) {
      ++done;
      coming.push({now + kPause, number++, traffic.read(), false});
      if (traffic.writes()) coming.push({now + 1, number++, traffic.write(), true});
      continue;
    }
    const Cycle at = channel.request(next.write ? now : channel.room(now), next.address, kSectors, 32, next.write);
    if (!next.write) data.push({std::max(at, now + 1), next.number, 0, false});
    if (coming.empty()) coming.push({modules::kNever, number++, 0, false});
  }
  return static_cast<double>(now) / kReads;
}

// Each alone in the channel: a closed row, its hit, conflicts at once and after a pause, with writes before.
TEST(FastDramUnloaded, AnswersInTheClockInWhichTheCycleModelDoes) {
  for (const char* file : {"table1.toml", "dram/gddr6.toml"}) {
    const modules::DramChannelConfig config =
        load_config(grtx::paths::source_dir() + "/configs/" + file, {}).dram.channel;
    const modules::DramMapping mapping(config);
    std::uint64_t other_row = 0;
    for (bool found = false; !found; found = mapping.place(other_row).bank == mapping.place(0).bank &&
                                             mapping.place(other_row).row != mapping.place(0).row) {
      other_row += 128;
    }
    modules::DramChannel cycle(config);
    FastDramChannel fast(config);
    Cycle now = 1;
    unsigned number = 0;
    for (const auto& [address, write, pause] : {std::tuple{0U, false, 0U},
                                                {32U, false, 0U},
                                                {0U, false, 500U},
                                                {1U, false, 0U},
                                                {0U, false, 300U},
                                                {1U, true, 200U},
                                                {0U, false, 0U},
                                                {32U, true, 100U},
                                                {64U, false, 50U},
                                                {1U, false, 700U}}) {
      const std::uint64_t at = address == 1 ? other_row : address;
      now += pause;
      cycle.run_until(now - 1);
      cycle.enqueue(now, number, at, 32, write);
      cycle.run_until(now + 400);
      ASSERT_FALSE(cycle.completions().empty());
      const Cycle done = cycle.completions().front().done;
      cycle.completions().pop();
      fast.advance(now);
      EXPECT_EQ(fast.request(now, at, 1, 32, write), done) << file << ", request " << number;
      now = done;
      ++number;
    }
  }
}

class FastDram : public ::testing::TestWithParam<Load> {};

TEST_P(FastDram, MovesAsMuchAsTheCycleModels) {
  const Load& load = GetParam();
  const modules::DramChannelConfig config =
      load_config(grtx::paths::source_dir() + "/configs/" + load.file, {}).dram.channel;
  const double expected = clocks_of_a_read(config, load);
  EXPECT_NEAR(fast_clocks_of_a_read(config, load), expected, load.tolerance * expected);
}

constexpr const char* kGddr5 = "table1.toml";
constexpr const char* kGddr6 = "dram/gddr6.toml";
INSTANTIATE_TEST_SUITE_P(Loads, FastDram,
                         ::testing::Values(Load{"rows_closed_for_others", kGddr5, 8, 0.0, 0.0, 0.02},
                                           Load{"activates_within_faw", kGddr6, 24, 0.0, 0.0, 0.02},
                                           Load{"saturated", kGddr5, 64, 0.0, 0.0, 0.02},
                                           Load{"saturated_gddr6", kGddr6, 64, 0.0, 0.0, 0.03},
                                           Load{"row_hits", kGddr5, 64, 0.0, 0.3, 0.03},
                                           Load{"a_few_writes", kGddr5, 24, 0.1, 0.0, 0.03},
                                           Load{"a_few_writes_gddr6", kGddr6, 24, 0.1, 0.0, 0.04},
                                           Load{"writes", kGddr5, 64, 0.25, 0.3, 0.05},
                                           Load{"writes_gddr6", kGddr6, 64, 0.25, 0.0, 0.07},
                                           Load{"half_writes", kGddr5, 24, 0.5, 0.0, 0.07},
                                           Load{"half_writes_gddr6", kGddr6, 24, 0.5, 0.0, 0.05}),
                         [](const auto& load) { return std::string(load.param.name); });

}  // namespace
}  // namespace grtx::sim
