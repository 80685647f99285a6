// SPDX-License-Identifier: Apache-2.0
// GpuComponent: a GPU on somebody else's platform. Every launch gives the statistics of a run of its own, whatever ran
// before; with kept caches those of `simulate()` after the trace before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <iterator>
#include <memory>
#include <ostream>
#include <sstream>
#include <utility>

#include "error_of.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/tlm/link_to_tlm.h"
#include "grtx/modules/tlm/tlm_to_link.h"
#include "rtl_tlm/first_difference.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using test::LaunchedGpu;
using test::TestLaunch;
using traces::testing::random_trace;
using traces::testing::RandomOptions;
using traces::testing::TemporaryFile;

std::string alone(const std::string& trace, const GpuConfig& config, const std::string& warm = "") {
  ChildProcess child("simulation", [&] {
    SimulationOptions options;
    options.warm_trace = warm;
    const SimulationResult result = simulate(trace, config, options);
    return result.violations.empty() ? test::statistics_of(result) : result.violations.front();
  });
  return child.result();
}

/// The statistics of all launches of a component, one after the other.
std::vector<std::string> launched(const GpuComponent::Options& options, const std::vector<TestLaunch>& launches) {
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    LaunchedGpu launched_gpu("gpu0", options, launches);
    sc_core::sc_start();
    nlohmann::json all = nlohmann::json::array();
    for (const SimulationResult& result : launched_gpu.gpu.results()) {
      all.push_back(result.violations.empty() ? test::statistics_of(result) : result.violations.front());
    }
    if (sc_core::sc_get_status() != sc_core::SC_RUNNING && sc_core::sc_get_status() != sc_core::SC_PAUSED) {
      all.push_back("the kernel has stopped");
    }
    return all.dump();
  });
  return nlohmann::json::parse(child.result()).get<std::vector<std::string>>();
}

class GpuComponentLaunches : public ::testing::TestWithParam<unsigned> {};
constexpr unsigned kShares = 8;

// Two scenes of one structure; what the launch before left must not show.
TEST_P(GpuComponentLaunches, EqualRunsOfTheirOwnOnRandomMachines) {
  const char* const wanted = std::getenv("GRTX_PLATFORM_MACHINES");
  const unsigned machines = wanted != nullptr ? static_cast<unsigned>(std::stoul(wanted)) : 24;
  for (unsigned seed = GetParam(); seed < machines; seed += kShares) {
    const test::RandomPair traces(seed, 7000);
    const GpuConfig& config = traces.config;
    GpuComponent::Options component;
    component.machine = config;
    component.traces = {traces.first.path(), traces.second.path()};
    const auto results = launched(component, {{0}, {1, false, 3.5}, {1, true}, {0}, {1, true, 1e4}});
    const std::string text = config_json(config).dump();
    ASSERT_EQ(results.size(), 5u) << text;
    EXPECT_EQ(test::first_difference(results[0], alone(traces.first.path(), config)), "") << seed << text;
    EXPECT_EQ(test::first_difference(results[1], alone(traces.second.path(), config)), "") << seed << text;
    EXPECT_EQ(test::first_difference(results[3], results[0]), "") << seed << text;
    EXPECT_EQ(test::first_difference(results[4], alone(traces.second.path(), config, traces.first.path())), "")
        << seed << text;
  }
}
INSTANTIATE_TEST_SUITE_P(Shares, GpuComponentLaunches, ::testing::Range(0U, kShares));

struct TinyFile {
  explicit TinyFile(unsigned groups) : file("tiny") { test::write_tiny_trace(file.path(), {groups, 32}); }
  TemporaryFile file;
};

GpuConfig small_machine() {
  GpuConfig config;
  config.sms = 2;
  return config;
}

TEST(GpuComponent, TwoRunBesideEachOtherWithoutAWarning) {
  const TinyFile few(3), many(40);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path(), many.file.path()};
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_THROW);
    LaunchedGpu a("a", options, {{0}, {1}}), b("b", options, {{1, false, 0.3}, {0}});
    sc_core::sc_start();
    nlohmann::json cycles = {a.launcher.cycles, b.launcher.cycles};
    for (const char* name : {"a.gpu.sm0.rt", "b.gpu.sm0.rt", "a.memory_clock", "b.dram"}) {
      cycles.push_back(sc_core::sc_find_object(name) != nullptr);
    }
    return cycles.dump();
  });
  const auto cycles = nlohmann::json::parse(child.result());
  EXPECT_EQ(cycles[0][0], cycles[1][1]);
  EXPECT_EQ(cycles[0][1], cycles[1][0]);
  EXPECT_NE(cycles[0][0], cycles[0][1]);
  for (std::size_t i = 2; i < 6; ++i) EXPECT_EQ(cycles[i], true) << i;
}

/// Full names of all links below an object.
void add_links(const sc_core::sc_object& object, std::vector<const modules::LinkObject*>& links) {
  if (const auto* link = dynamic_cast<const modules::LinkObject*>(&object)) links.push_back(link);
  for (const sc_core::sc_object* child : object.get_child_objects()) add_links(*child, links);
}

TEST(GpuComponent, HasItsLinksInTheHierarchyByTheNamesOfTheWaveform) {
  const TinyFile few(3);
  const TemporaryFile waves("waves");
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path()};
  GpuComponent::Options watched = options;
  watched.waveform.path = waves.path();
  watched.waveform.level = WaveLevel::signals;
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_THROW);
    nlohmann::json found;
    LaunchedGpu a("a", watched, {{0}}), b("b", options, {{0}});
    sc_core::sc_start();
    for (const char* top : {"a", "b"}) {
      std::vector<const modules::LinkObject*> links;
      add_links(*sc_core::sc_find_object(top), links);
      for (const modules::LinkObject* link : links) {
        const std::string name = link->name();
        const bool found_again = sc_core::sc_find_object(name.c_str()) == link;
        if (found_again && link->kind() == std::string("grtx_link") && link->size() == 0) found[top].push_back(name);
        if (!found_again || link->capacity() == 0 || link->latency() == 0) found["wrong"].push_back(name);
      }
    }
    for (const char* name : {"a.gpu.sm1.trace_call", "b.gpu.sm0.rt_node_request", "b.gpu.slice_response0"}) {
      const auto* link = dynamic_cast<const modules::LinkObject*>(sc_core::sc_find_object(name));
      found["pushed"].push_back(link == nullptr ? 0 : link->pushed());
    }
    return found.dump();
  });
  const auto found = nlohmann::json::parse(child.result());
  EXPECT_EQ(found.count("wrong"), 0u) << found;
  ASSERT_EQ(found["a"].size(), found["b"].size());
  // An SM has four to and from the RT unit, and two per port of the L1; the GPU four per SM and two per slice.
  EXPECT_GE(found["a"].size(), 2u * (4 + 2 * 2 + 4) + 2 * options.machine.interleave.slices);
  for (const auto& pushed : found["pushed"]) EXPECT_GT(pushed, 0u) << found["pushed"];
  // A scope of the waveform is a part of such a name.
  std::ifstream file(waves.path());
  std::ostringstream text;
  text << file.rdbuf();
  for (const std::string link : found["a"]) {
    const std::string scope = link.substr(link.rfind('.') + 1);
    EXPECT_NE(text.str().find("$scope module " + scope + " $end"), std::string::npos) << link;
  }
}

TEST(GpuComponent, WritesOneWaveformOfAllLaunches) {
  const TinyFile few(3);
  const TemporaryFile waves("waves");
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path()};
  options.waveform.path = waves.path();
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    std::uint64_t end = 0;
    {
      LaunchedGpu launched_gpu("board", options, {{0}, {0, false, 1e5}});
      sc_core::sc_start();
      end = sc_core::sc_time_stamp().value();
    }
    return std::to_string(end);
  });
  const std::uint64_t end = std::stoull(child.result());
  std::ifstream file(waves.path());
  std::uint64_t last = 0;
  bool named = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) last = std::stoull(line.substr(1));
    named = named || line.find("$scope module board $end") != std::string::npos;
  }
  EXPECT_TRUE(named);
  EXPECT_GT(last, 100'000'000'000u) << "the second launch, 100 us after the first, is there";
  EXPECT_LE(last, end);
}

// `trace = 1; start; trace = 0` without a wait ran trace 0; so did a start with an annotated delay, or behind a reset.
TEST(GpuComponent, AStartRunsTheTraceThatWasWrittenBeforeIt) {
  const TinyFile few(3), many(40);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path(), many.file.path()};
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_DO_NOTHING);
    LaunchedGpu launched_gpu("a", options,
                             {{.trace = 0},
                              {.trace = 1},
                              {.trace = 1, .then_trace = 0},
                              {.trace = 1, .after_ns = 20.0, .then_trace = 0},
                              {.trace = 1, .then_trace = 7},
                              {.trace = 7, .then_trace = 1},
                              {.trace = 0, .then_trace = 1, .one_transfer = true},
                              {.trace = 1, .one_transfer = true}});
    sc_core::sc_start();
    return nlohmann::json{launched_gpu.launcher.errors, launched_gpu.launcher.cycles}.dump();
  });
  const auto found = nlohmann::json::parse(child.result());
  const auto refused = static_cast<std::uint32_t>(LaunchError::no_such_trace);
  EXPECT_EQ(found[0], nlohmann::json({0u, 0u, 0u, 0u, 0u, refused, 0u, 0u}));
  const std::uint64_t short_run = found[1][0], long_run = found[1][1];
  ASSERT_NE(short_run, long_run);
  const std::vector<std::uint64_t> expected{short_run, long_run, long_run,  long_run,
                                            long_run,  long_run, short_run, long_run};  // a refused one has none
  EXPECT_EQ(found[1].get<std::vector<std::uint64_t>>(), expected);
}

TEST(GpuComponent, ANullDataPointerIsRefused) {
  const TinyFile few(3);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path()};
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    LaunchedGpu launched_gpu("a", options, {{0}});
    sc_core::sc_start();
    nlohmann::json found;
    for (const auto command : {::tlm::TLM_READ_COMMAND, ::tlm::TLM_WRITE_COMMAND}) {
      found.push_back(launched_gpu.launcher.access(command, 8, nullptr, 4));
    }
    ::tlm::tlm_generic_payload payload;
    payload.set_read();
    payload.set_data_length(4);
    payload.set_streaming_width(4);
    found.push_back(launched_gpu.launcher.socket->transport_dbg(payload));
    return found.dump();
  });
  const auto refused = static_cast<int>(::tlm::TLM_GENERIC_ERROR_RESPONSE);
  EXPECT_EQ(nlohmann::json::parse(child.result()), nlohmann::json({refused, refused, 0}));
}

TEST(GpuComponent, TellsWhatIsWrongWithALaunch) {
  const TinyFile few(3);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path()};
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_DO_NOTHING);
    LaunchedGpu launched_gpu("a", options, {{5}, {0}});
    sc_core::sc_start();
    const auto& launcher = launched_gpu.launcher;
    return nlohmann::json{launcher.errors, launcher.cycles, launched_gpu.gpu.results().size()}.dump();
  });
  const auto found = nlohmann::json::parse(child.result());
  EXPECT_EQ(found[0][0], static_cast<std::uint32_t>(LaunchError::no_such_trace));
  EXPECT_EQ(found[0][1], 0u);
  EXPECT_GT(found[1][1], 0u);
  EXPECT_EQ(found[2], 1u);
}

// Equal addresses are other bytes there.
TEST(GpuComponent, KeptCachesOfAnotherSceneAreRefused) {
  const TemporaryFile first("first"), other("other");
  for (const auto& [file, scene] : {std::pair(&first, "a"), std::pair(&other, "b")}) {
    traces::Header header = test::tiny_header({2, 32});
    header.inputs["scene_hash"] = scene;
    traces::testing::write_trace(file->path(), header, {test::tiny_group({2, 32}, 0), test::tiny_group({2, 32}, 1)});
  }
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {first.path(), other.path()};
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_DO_NOTHING);
    LaunchedGpu launched_gpu("a", options, {{0}, {1, true}, {0, true}, {1}});
    sc_core::sc_start();
    return nlohmann::json(launched_gpu.launcher.errors).dump();
  });
  const auto refused = static_cast<std::uint32_t>(LaunchError::other_scene);
  EXPECT_EQ(nlohmann::json::parse(child.result()), nlohmann::json({0u, refused, 0u, 0u}));
}

TEST(GpuComponent, RefusesTracesOfOtherHardware) {
  const TinyFile few(3);
  const TemporaryFile other("other");
  traces::Header header = test::tiny_header({2, 32});
  header.k = 3;
  traces::testing::write_trace(other.path(), header, {test::tiny_group({2, 32}, 0), test::tiny_group({2, 32}, 1)});
  GpuComponent::Options options;
  options.traces = {few.file.path(), other.path()};
  ChildProcess child("platform", [&]() -> std::string {
    modules::set_time_resolution_to_fs();
    return grtx::test::error_of([&] { GpuComponent gpu("gpu", options); });
  });
  EXPECT_NE(child.result().find("is for other hardware"), std::string::npos);
}

std::string document_of(SimulationResult result) {
  if (!result.violations.empty()) return result.violations.front();
  for (auto stat = result.document.at("stats").begin(); stat != result.document.at("stats").end();) {
    stat = stat.key().starts_with("host.") ? result.document.at("stats").erase(stat) : std::next(stat);
  }
  return result.document.dump(1);
}

// The document was null, and over_time and inputs.mode were missing.
TEST(GpuComponent, ALaunchHasTheDocumentOfASimulation) {
  const TinyFile few(3), many(40);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path(), many.file.path()};
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    LaunchedGpu launched_gpu("gpu0", options, {{0}, {1, false, 3.5}, {1, true}, {1}});
    sc_core::sc_start();
    nlohmann::json all = nlohmann::json::array();
    for (const SimulationResult& result : launched_gpu.gpu.results()) all.push_back(document_of(result));
    return all.dump();
  });
  const auto documents = nlohmann::json::parse(child.result()).get<std::vector<std::string>>();
  const auto simulated = [&](const std::string& trace, const std::string& warm) {
    ChildProcess simulation("simulation", [&] {
      SimulationOptions alone;
      alone.warm_trace = warm;
      return document_of(simulate(trace, options.machine, alone));
    });
    return simulation.result();
  };
  ASSERT_EQ(documents.size(), 4u);
  EXPECT_EQ(documents[0], simulated(few.file.path(), ""));
  EXPECT_EQ(documents[1], simulated(many.file.path(), ""));
  EXPECT_EQ(documents[2], simulated(many.file.path(), many.file.path()));
  EXPECT_EQ(documents[3], documents[1]);
}

/// An L2 slice whose requests pass TLM-2.0 sockets on their way in, as on a platform that has a bus there.
class BridgedSlice final : public modules::L2SliceModule {
 public:
  BridgedSlice(const sc_core::sc_module_name& name, const modules::L2Slice::Config& config, modules::ClockDomain& clock)
      : L2SliceModule(name, clock),
        to_bus_("to_bus", {}, clock),
        from_bus_("from_bus", {}, clock),
        slice_("slice", config, clock),
        requests_("requests", 1, 4),
        responses_("responses", 1, 4) {
    to_bus_.request.bind(request);
    to_bus_.response.bind(response);
    to_bus_.memory.socket.bind(from_bus_.socket);
    from_bus_.request.bind(requests_);
    from_bus_.response.bind(responses_);
    slice_.request.bind(requests_);
    slice_.response.bind(responses_);
  }
  ::tlm::tlm_initiator_socket<32>& memory_socket() override { return slice_.memory_socket(); }
  modules::L2Counters counters() const override { return slice_.counters(); }
  bool idle() const override { return to_bus_.idle() && from_bus_.idle() && slice_.idle(); }
  std::uint64_t dirty_sectors() const override { return slice_.dirty_sectors(); }
  modules::Inventory inventory() const override { return slice_.inventory(); }
  void dump_state(std::ostream& out) const override {
    to_bus_.dump_state(out);
    from_bus_.dump_state(out);
    slice_.dump_state(out);
  }

 private:
  Cycle tick(Cycle) override { return modules::kNever; }

  modules::LinkToTlm to_bus_;
  modules::TlmToLink from_bus_;
  modules::L2Slice slice_;
  modules::Link<modules::MemoryRequest> requests_;
  modules::Link<modules::MemoryResponse> responses_;
};

// The bridges kept the cycles of the launch before: it took twice as long, without a word.
TEST(GpuComponent, ALaterLaunchBehindBridgesIsAsTheFirst) {
  const TinyFile few(3), many(40);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {few.file.path(), many.file.path()};
  options.parts.l2_slice = [](const char* name, const modules::L2Slice::Config& config, modules::ClockDomain& clock) {
    return std::make_unique<BridgedSlice>(name, config, clock);
  };
  const auto results = launched(options, {{1}, {0, false, 3.5}, {1, false, 1e6}});
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(test::first_difference(results[2], results[0]), "");
  options.parts.l2_slice = nullptr;
  EXPECT_NE(launched(options, {{1}}).at(0), results[0]) << "bridges take time";
}

/// A ray-box unit that forgets what it is asked in the first launch.
class Forgetful final : public modules::IntersectionModule {
 public:
  explicit Forgetful(const sc_core::sc_module_name& name) : IntersectionModule(name) {}
  void enqueue(Cycle now, modules::LaneId id, unsigned) override {
    lanes_.push_back(id);
    if (launches_ > 1) due_ = now + 1;
  }
  void tick(Cycle now) override {
    const std::deque<modules::LaneId> lanes = std::exchange(lanes_, {});
    due_ = modules::kNever;
    for (const modules::LaneId id : lanes) client->unit_result(now, id);
    answered_ += lanes.size();
  }
  bool idle() const override { return lanes_.empty(); }
  std::uint64_t progress() const override { return answered_; }
  modules::IntersectionCounters counters() const override {
    return {.operations = answered_, .tests = answered_, .busy_cycles = answered_};
  }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << '\n'; }
  void restart() override {
    ++launches_;
    lanes_.clear();
    answered_ = 0;
    due_ = modules::kNever;
  }

 private:
  unsigned launches_ = 0;
  std::uint64_t answered_ = 0;
  std::deque<modules::LaneId> lanes_;
};

TEST(GpuComponent, ALaunchThatStandsStillCanBeAbandoned) {
  const TinyFile many(40);
  GpuComponent::Options options;
  options.machine = small_machine();
  options.traces = {many.file.path()};
  options.watchdog_cycles = 10'000;
  options.parts.sm.rt_parts.ray_box = [](const char* name, const modules::RtUnitContext&) {
    return std::make_unique<Forgetful>(name);
  };
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_DO_NOTHING);
    LaunchedGpu launched_gpu("a", options, {{0}, {0, false, 3.5, true}, {0}});
    sc_core::sc_start();
    nlohmann::json all = {launched_gpu.launcher.errors};
    for (const SimulationResult& result : launched_gpu.gpu.results()) {
      all.push_back(result.violations.empty() ? test::statistics_of(result) : result.violations.front());
    }
    return all.dump();
  });
  const auto found = nlohmann::json::parse(child.result());
  EXPECT_EQ(found[0], nlohmann::json({static_cast<std::uint32_t>(LaunchError::stands_still), 0u, 0u}));
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(test::first_difference(found[1], found[2]), "") << "nothing of the abandoned launch is left";
}

}  // namespace
}  // namespace grtx::sim
