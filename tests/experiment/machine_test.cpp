// SPDX-License-Identifier: Apache-2.0
// A machine by name or file becomes a configuration and tracer options; what is said beside it lies over it; a wrong
// name or key is an Error with its place.
#include "grtx/experiment/machine.h"

#include <gmock/gmock.h>

#include "error_of.h"
#include "paths.h"
#include "temporary_folder.h"

namespace grtx::experiment {
namespace {

using ::testing::HasSubstr;

std::string refused(const MachineChoice& choice) {
  return test::error_of([&] { choose_machine(choice); });
}

class Machine : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

TEST_F(Machine, GivesTheTracerItsOptionsUnlessTheUserNamesThem) {
  const std::string own =
      folder_.write("own.toml", "[tracer]\nchild_order = \"slot\"\nsort_key = \"peak\"\n[l1]\nbytes = 65536\n");
  TracerSettings settings;
  apply_machine_tracer(settings, own);
  EXPECT_EQ(settings.options.child_order, frontend::ChildOrder::slot);
  EXPECT_EQ(settings.options.sort_key, frontend::SortKey::peak);
  TracerSettings named;
  apply_machine_tracer(named, own, [](const std::string& key) { return key == "child_order"; });
  EXPECT_EQ(named.options.child_order, TracerSettings().options.child_order);
  EXPECT_NE(named.options.child_order, frontend::ChildOrder::slot);
  EXPECT_EQ(named.options.sort_key, frontend::SortKey::peak);
}

TEST_F(Machine, GivesTheHardwareItsKeysUnderFileAndSettings) {
  const std::string own = folder_.write("own.toml", "[l1]\nbytes = 65536\nlatency = 25\n[l2]\nlatency = 100\n");
  const std::string over = folder_.write("over.toml", "[l1]\nlatency = 30\n");
  const sim::GpuConfig config = choose_machine({.machine = own, .config = over, .settings = {"l2.latency=120"}}).config;
  EXPECT_EQ(config.l1.geometry.bytes, 65536U);
  EXPECT_EQ(config.l1.latency, 30U);
  EXPECT_EQ(config.l2.latency, 120U);
  const sim::KeyPlaces places = machine_places(own, over);
  EXPECT_THAT(places.at("l1.latency").file, HasSubstr("over.toml"));
  EXPECT_THAT(places.at("l1.bytes").file, HasSubstr("own.toml"));
  EXPECT_FALSE(places.contains("l1.banks"));
}

TEST_F(Machine, SaysWhetherItWasChanged) {
  EXPECT_EQ(choose_machine({.machine = "paper"}).name, "paper");
  EXPECT_EQ(choose_machine({.machine = "paper", .settings = {"l2.latency=165"}}).name, "paper");  // what it is already
  EXPECT_EQ(choose_machine({.machine = "paper", .settings = {"l2.latency=166"}}).name, "paper, changed");
  EXPECT_EQ(choose_machine({.machine = "paper", .design = "walk"}).name, "paper");  // a design's keys are no change
  EXPECT_EQ(choose_machine({.machine = "", .settings = {"l2.latency=166"}}).name, "");
  EXPECT_EQ(machine_name("/somewhere/mine.toml"), "mine");
}

TEST_F(Machine, PaperIsPaperChargedWithoutTheCharge) {
  const auto config = [](const MachineChoice& choice) { return sim::config_json(choose_machine(choice).config); };
  const nlohmann::ordered_json paper = config({.machine = "paper"}), charged = config({.machine = "paper-charged"});
  EXPECT_EQ(charged,
            config({.machine = paths::source_dir() + "/configs/table1.toml", .settings = {"rt.memory.queue=256"}}));
  for (const auto& [key, value] : charged.items()) {
    EXPECT_EQ(paper.at(key) != value, key == "rt.checkpoint.traffic") << key;
  }
}

TEST_F(Machine, NumbersOfTheTracerAreTakenAsTextIs) {
  const std::string number = folder_.write("own.toml", "[tracer]\nk = 16\nert = 0.02\n");
  const std::string text = folder_.write("text.toml", "[tracer]\nk = \"16\"\nert = \"0.02\"\n");
  EXPECT_EQ(machine_tracer(number), machine_tracer(text));
  TracerSettings settings;
  apply_machine_tracer(settings, number);
  EXPECT_EQ(settings.options.k, 16U);
  EXPECT_FLOAT_EQ(static_cast<float>(settings.options.ert), 0.02F);
}

TEST_F(Machine, AWrongNameKeyOrValueIsAnErrorWithItsPlace) {
  EXPECT_THAT(refused({.machine = "papper"}), HasSubstr("the nearest is paper"));
  EXPECT_THAT(refused({.machine = folder_.path("missing.toml")}), HasSubstr("missing.toml"));
  EXPECT_THAT(refused({.machine = folder_.write("a.toml", "[tracer]\nchild_ordr = \"slot\"\n")}),
              HasSubstr("a.toml: line 2: unknown key 'tracer.child_ordr', the nearest is 'tracer.child_order'"));
  EXPECT_THAT(refused({.machine = folder_.write("b.toml", "[tracer]\nchild_order = \"slott\"\n")}),
              HasSubstr("b.toml: line 2: tracer.child_order: "));
  EXPECT_THAT(refused({.config = folder_.write("zero.toml", "[tracer]\nk = 0\n")}),
              HasSubstr("zero.toml: line 2: tracer.k: must be 1 to 2048, not 0"));
}

TEST_F(Machine, TwoKeysForOneClockAreRefused) {
  const std::string both = folder_.write("both.toml", "[dram]\nmhz = 1000\nbandwidth_gb_s = 50\n");
  for (const MachineChoice& choice :
       {MachineChoice{.machine = both}, MachineChoice{.machine = "paper", .config = both},
        MachineChoice{.machine = "paper", .settings = {"dram.mhz=1000", "dram.bandwidth_gb_s=50"}}}) {
    EXPECT_THAT(refused(choice), HasSubstr("dram.bandwidth_gb_s and dram.mhz both set the memory clock"));
  }
  EXPECT_THAT(refused({.machine = "paper", .settings = {"dram.bandwidth_gb_s=1000"}}),
              HasSubstr("gives a memory clock outside 100 to 10000 MHz"));
}

}  // namespace
}  // namespace grtx::experiment
