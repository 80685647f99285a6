// The private store of the SIMT core: an access of a warp to an entry of 8 B takes 8 / lane_bytes cycles at the banks,
// one after the other, and a read's data are there `latency` cycles after its last one. Formulas:
// docs/model/private_store.md.
#include "grtx/modules/simt/decide/private_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "grtx/base/error.h"
#include "modules/simt/simt_bench.h"

namespace grtx::modules {
namespace {

using traces::LeafOutcome;

PrivateStore::Config store_of(unsigned k_buffer_entries, unsigned eviction_entries = 0) {
  PrivateStore::Config config;
  config.k_buffer_entries = k_buffer_entries;
  config.eviction_entries = eviction_entries;
  return config;
}

TEST(PrivateStore, AccessesGoOneAfterTheOtherAndReadsAreBackAfterTheLatency) {
  struct Case {
    unsigned lane_bytes, latency;
    Cycle first, second;  // data of three entries read in cycle 100, of one read in cycle 101
  };
  for (const Case& c : {Case{4, 19, 100 + 6 - 1 + 19, 106 + 2 - 1 + 19}, Case{8, 19, 100 + 3 - 1 + 19, 103 + 19},
                        Case{8, 1, 100 + 3 - 1 + 1, 103 + 1}}) {
    PrivateStore::Config config = store_of(8);
    config.lane_bytes = c.lane_bytes;
    config.latency = c.latency;
    PrivateStore store(config);
    EXPECT_EQ(store.read(3, 100), c.first);
    EXPECT_EQ(store.read(1, 101), c.second);
    EXPECT_EQ(store.counters().wait_cycles, 3 * 8 / c.lane_bytes - 1);
  }
}

TEST(PrivateStore, WritesTakeTheBanksButNobodyWaits) {
  PrivateStore store(store_of(8));
  store.write(4, 10);
  EXPECT_EQ(store.free_from(), 18u);
  EXPECT_EQ(store.read(1, 12), 18 + 2 - 1 + 19u);
  store.write(1, 500);
  EXPECT_EQ(store.free_from(), 502u);
  EXPECT_EQ(store.counters().writes, 5u);
  EXPECT_EQ(store.counters().reads, 1u);
}

class SimtPrivateStore : public SystemCTest {
 protected:
  /// A bench needs a kernel of its own.
  static SimtBench::Options fresh(const PrivateStore::Config& store) {
    FreshContext();
    SimtBench::Options options;
    options.config.private_store = store;
    return options;
  }
  static std::size_t requests(const SimtBench& bench, Region region) {
    return static_cast<std::size_t>(std::count_if(bench.requests.begin(), bench.requests.end(),
                                                  [&](const auto& r) { return r.second.region == region; }));
  }
};

constexpr Cycle kL = 4;                                                      // default instruction latency
constexpr Cycle phase(Cycle instructions) { return 1 + instructions + kL; }  // no loads, no contention
constexpr Cycle kRead = 2 - 1 + 19;                                          // an entry: two cycles of 4 B a lane

TEST_F(SimtPrivateStore, AnyHitReadsAnEntryAStepWithoutMemory) {
  struct Case {
    unsigned before;  // insertions before the measured one
    LeafOutcome outcome;
    unsigned shifts;
    unsigned loads;  // entries read
  };
  for (const Case& c : {Case{0, LeafOutcome::inserted, 0, 0}, Case{2, LeafOutcome::inserted, 0, 1},
                        Case{2, LeafOutcome::inserted, 2, 2}, Case{4, LeafOutcome::displaced, 3, 4},
                        Case{4, LeafOutcome::rejected, 0, 1}}) {
    SimtBench bench(fresh(store_of(4)));
    RoundScript round;
    for (unsigned i = 0; i < c.before; ++i) round.any_hits.push_back({LeafOutcome::inserted, 0});
    round.any_hits.push_back({c.outcome, c.shifts});
    const traces::RayGroup group = uniform_group(32, {round});
    bench.start(0, group, 1);
    bench.run();
    ASSERT_EQ(bench.batches.size(), c.before + 1);
    // The write of the insertion before took its two cycles while the messages were on their way.
    Cycle back = bench.batches[c.before].first + (c.loads == 0 ? 0 : kRead);
    for (unsigned i = 1; i < c.loads; ++i) back += phase(3) + kRead;
    const unsigned looked_at = c.loads == 0 ? 0 : c.loads - 1;
    EXPECT_EQ(bench.any_hits_done[c.before].first, back + phase(12 + 3 * c.shifts - 3 * looked_at) + 1)
        << "outcome " << static_cast<int>(c.outcome) << " shifts " << c.shifts << " after " << c.before;
    EXPECT_EQ(requests(bench, Region::k_buffer), 0u);
    EXPECT_TRUE(bench.core->idle());
  }
}

TEST_F(SimtPrivateStore, BlendWaitsForTheLaterOfStoreAndMemory) {
  for (const unsigned latency : {19U, 200U}) {
    PrivateStore::Config store = store_of(4);
    store.latency = latency;
    SimtBench bench(fresh(store));
    const traces::RayGroup group = uniform_group(
        32, {{{{LeafOutcome::inserted}, {LeafOutcome::inserted}}, {seen(0, true), seen(0, false)}, 0, 0}});
    bench.start(0, group, 1);
    bench.run();
    ASSERT_EQ(bench.any_hits_done.size(), 2u);
    const Cycle sectors = 2 * 2 + 1;  // Gaussian records of two sectors, an SH record
    const Cycle instructions = 10 + 2 * 24 + 4;
    const Cycle done_seen = bench.any_hits_done[1].first + bench.options.trace_cycles + 1;
    const Cycle memory = sectors - 1 + bench.memory_latency();
    const Cycle on_chip = 2 * 2 - 1 + Cycle{latency};
    EXPECT_EQ(bench.ends[0].first, done_seen + std::max(memory, on_chip) + phase(instructions) + phase(10) + 15 +
                                       bench.memory_latency() + 1);
  }
}

TEST_F(SimtPrivateStore, EntriesBehindThoseThatItHoldsLieInMemory) {
  // Four insertions, each before all others: they write 1, 2, 3 and 4 entries and read 0, 1, 2 and 3.
  for (const unsigned held : {0U, 1U, 3U, 4U, 100U}) {
    SimtBench bench(fresh(store_of(held)));
    RoundScript round;
    for (unsigned i = 0; i < 4; ++i) round.any_hits.push_back({LeafOutcome::inserted, i});
    const traces::RayGroup group = uniform_group(32, {round});
    bench.start(0, group, 1);
    bench.run();
    unsigned reads = 0, writes = 0;  // of entries in memory, 8 sectors each
    for (unsigned i = 0; i < 4; ++i) {
      writes += i + 1 - std::min(i + 1, held);
      reads += i - std::min(i, held);
    }
    EXPECT_EQ(requests(bench, Region::k_buffer), 8 * (reads + writes)) << held;
    const SimtCounters counters = bench.core->counters();
    EXPECT_EQ(counters.private_store.reads, 6 - reads) << held;
    EXPECT_EQ(counters.private_store.writes, 10 - writes) << held;
    EXPECT_EQ(counters.shader.store_entries_read, 32 * (6 - reads)) << held;
    EXPECT_EQ(counters.shader.store_entries_written, 32 * (10 - writes)) << held;
  }
}

TEST_F(SimtPrivateStore, EvictionsLikewise) {
  // k = 4, then three hits behind all: evicted, of which two are moved to the k-buffer of the next round.
  for (const unsigned held : {0U, 2U, 8U}) {
    SimtBench::Options options = fresh(store_of(0, held));
    options.header = checkpointing(options.header);
    SimtBench bench(options);
    RoundScript first, second;
    first.any_hits.assign(4, {LeafOutcome::inserted, 0});
    first.any_hits.insert(first.any_hits.end(), 3, {LeafOutcome::rejected, 0});
    second.preloaded = 2;
    const traces::RayGroup group = uniform_group(32, {first, second});
    bench.start(0, group, 1);
    bench.run();
    const unsigned in_memory = 3 - std::min(3U, held);
    const unsigned stays = held == 0 ? 1 : 0;  // entry 0 is written back
    EXPECT_EQ(requests(bench, Region::eviction), 32 * (2 * in_memory + stays)) << held;
    const SimtCounters counters = bench.core->counters();
    EXPECT_EQ(counters.private_store.writes, 3 - in_memory + (held == 0 ? 0 : 1)) << held;
    EXPECT_EQ(counters.private_store.reads, 3 - in_memory) << held;
  }
}

TEST(PrivateStore, InsertionsTakeTheirLanesBankAlone) {
  PrivateStore::Config config = store_of(8);
  config.insertion = true;
  config.insertion_latency = 4;
  PrivateStore store(config);
  EXPECT_EQ(store.insert(3, 5, 100), 100 + 10 - 1 + 4u);
  EXPECT_EQ(store.insert(4, 1, 101), 101 + 2 - 1 + 4u);  // another bank
  EXPECT_EQ(store.insert(3, 1, 101), 110 + 2 - 1 + 4u);  // behind the first
  EXPECT_EQ(store.insert(5, 0, 101), 101 + 4u);          // nothing to access
  EXPECT_EQ(store.free_from(), 112u);
  EXPECT_EQ(store.read(1, 101), 112 + 2 - 1 + 19u);      // a warp's access needs all banks
  EXPECT_EQ(store.insert(9, 1, 102), 114 + 2 - 1 + 4u);  // and what comes later waits for it
  EXPECT_EQ(store.counters().insertions, 5u);
  EXPECT_EQ(store.counters().insertion_words, 16u);
  EXPECT_EQ(store.counters().insertion_wait, 9 + 12u);
  EXPECT_EQ(store.counters().wait_cycles, 11u);
}

TEST_F(SimtPrivateStore, InsertsWithoutAShader) {
  PrivateStore::Config store = store_of(4);
  store.insertion = true;
  store.insertion_latency = 3;
  // Into a buffer of two: one shift reads two entries and writes two; evicted entries go to memory as ever.
  struct Case {
    unsigned before;
    LeafOutcome outcome;
    unsigned shifts;
    Cycle accesses;
  };
  for (const Case& c : {Case{0, LeafOutcome::inserted, 0, 1}, Case{2, LeafOutcome::inserted, 1, 4},
                        Case{4, LeafOutcome::displaced, 3, 8}, Case{4, LeafOutcome::rejected, 0, 1}}) {
    SimtBench bench(fresh(store));
    RoundScript round;
    for (unsigned i = 0; i < c.before; ++i) round.any_hits.push_back({LeafOutcome::inserted, 0});
    round.any_hits.push_back({c.outcome, c.shifts});
    const traces::RayGroup group = uniform_group(32, {round});
    bench.start(0, group, 1);
    bench.run();
    ASSERT_EQ(bench.batches.size(), c.before + 1);
    EXPECT_EQ(bench.any_hits_done[c.before].first, bench.batches[c.before].first + 2 * c.accesses - 1 + 3 + 1)
        << "shifts " << c.shifts << " after " << c.before;
    EXPECT_EQ(requests(bench, Region::k_buffer), 0u);
    const SimtCounters counters = bench.core->counters();
    EXPECT_EQ(counters.private_store.insertions, 32 * (c.before + 1));
    EXPECT_EQ(counters.instructions[static_cast<std::size_t>(PhaseKind::any_hit)], 0u);
    EXPECT_EQ(counters.phases[static_cast<std::size_t>(PhaseKind::any_hit)], 0u);
    EXPECT_EQ(counters.shader.any_hit_calls, 32 * (c.before + 1));
    EXPECT_TRUE(bench.core->idle());
  }
}

TEST_F(SimtPrivateStore, InsertionNeedsWholeKBuffersOfMultiRoundTracing) {
  PrivateStore::Config store = store_of(3);  // the bench's k is 4
  store.insertion = true;
  EXPECT_THROW(SimtBench bench(fresh(store)), Error);
  store.k_buffer_entries = 4;
  SimtBench::Options options = fresh(store);
  options.header.tracing = traces::Tracing::single;
  EXPECT_THROW(SimtBench bench(options), Error);
}

TEST_F(SimtPrivateStore, IsPricedByItsBitsAndBanks) {
  PrivateStore::Config store = store_of(6, 2);
  store.lane_bytes = 8;
  SimtBench bench(fresh(store));
  const Inventory inventory = bench.core->inventory();
  const auto found = std::find_if(inventory.storage.begin(), inventory.storage.end(),
                                  [](const Storage& s) { return s.name == "private_store"; });
  ASSERT_NE(found, inventory.storage.end());
  EXPECT_EQ(found->bits, std::uint64_t{8} * 64 * 32 * bench.options.config.resident_warps);
  EXPECT_EQ(found->banks, 32u);
  EXPECT_EQ(found->word_bits, 64u);
}

TEST_F(SimtPrivateStore, InsertionByTheBanksIsPricedByItsRegistersFillsAndComparators) {
  // Storage: bits, read and write ports, bits of an access, banks; operators: how many.
  using Parts = std::map<std::string, std::vector<std::uint64_t>>;
  const auto parts = [](const PrivateStore::Config& store) {
    SimtBench::Options options = fresh(store);
    options.config.resident_warps = 8;
    options.config.schedulers = 4;
    options.config.register_file.registers = 65536;
    SimtBench bench(options);
    Parts all;
    const Inventory inventory = bench.core->inventory();
    for (const Storage& s : inventory.storage) {
      EXPECT_TRUE(all.insert({s.name, {s.bits, s.read_ports, s.write_ports, s.word_bits, s.banks}}).second) << s.name;
    }
    for (const Operators& o : inventory.operators) {
      std::vector<std::uint64_t>& count = all[o.name + std::to_string(o.width)];
      count.resize(1);
      count[0] += o.count;
    }
    return all;
  };
  Parts expected = {{"register_file", {65536 * 32, 3, 1, 32 * 32, 1}},
                    {"warp_control", {8 * (32 + 32 + 64), 1, 1, 32, 1}},  // program counter, lane mask, scoreboard
                    {"int_add32", {4 * 32}},
                    {"fp_fma32", {4 * 32}},
                    {"fp_compare32", {4 * 32}}};
  EXPECT_EQ(parts({}), expected);
  PrivateStore::Config store = store_of(4);
  expected["private_store"] = {4 * 8 * 32 * 64, 1, 0, store.lane_bytes * 8, 32};  // one port of a bank reads and writes
  expected["int_add16"] = {32};                                                   // a bank's place: slot and index
  EXPECT_EQ(parts(store), expected);
  store.insertion = true;
  expected["insertion_registers"] = {32 * 2 * 64, 1, 1, 32, 1};  // a bank's hit, and the entry that moves
  expected["insertion_fill"] = {32 * 8 * 3, 1, 1, 32, 1};        // 0 to 4 entries, a lane and slot
  expected["fp_compare32"][0] += 32;
  expected["int_compare32"] = {32};
  expected["int_add16"][0] += 32;
  EXPECT_EQ(parts(store), expected);
}

}  // namespace
}  // namespace grtx::modules
