// SPDX-License-Identifier: Apache-2.0
// Link: items appear after the latency, freed space a cycle later, whatever runs first in a cycle.
#include "grtx/modules/kernel/link.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "grtx/modules/kernel/waiting_links.h"

namespace grtx::modules {
namespace {

TEST(LinkTest, ItemsBecomeVisibleAfterTheLatency) {
  for (const unsigned latency : {1u, 2u, 7u}) {
    Link<int> link("link", latency, 4);
    link.push(10, 42);
    EXPECT_EQ(link.front(10 + latency - 1), nullptr);
    ASSERT_NE(link.front(10 + latency), nullptr);
    EXPECT_EQ(*link.front(10 + latency), 42);
    EXPECT_EQ(link.next_visible(), 10 + latency);
    link.pop(10 + latency);
    EXPECT_TRUE(link.empty());
  }
}

TEST(LinkTest, SpaceFreedInACycleIsSeenInTheNext) {
  Link<int> link("link", 1, 2);
  link.push(0, 1);
  link.push(0, 2);
  EXPECT_FALSE(link.can_push(1));
  link.pop(1);
  EXPECT_FALSE(link.can_push(1)) << "the producer may have run before the consumer";
  EXPECT_TRUE(link.can_push(2));
  EXPECT_EQ(link.space(2), 1u);
  link.pop(2);
  EXPECT_EQ(link.space(2), 1u);
  EXPECT_EQ(link.space(3), 2u);
}

std::string report_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const sc_core::sc_report& report) {
    return report.get_msg();
  } catch (const std::runtime_error& error) {  // where reports are configured not to throw
    return std::string("not thrown: ") + error.what();
  }
  return "none";
}

// Asserts vanish where a user's release build includes the header: then items came out in another order.
TEST(LinkTest, APushIntoAFullLinkAndAPopOfNothingAreReported) {
  Link<int> link("two_places", 1, 2);
  link.push(0, 0);
  link.push(0, 1);
  EXPECT_EQ(report_of([&] { link.push(0, 2); }), "two_places: push() into a full link");
  EXPECT_EQ(report_of([&] { link.pop(0); }), "two_places: pop() of a link in which nothing is visible");
  EXPECT_EQ(*link.front(1), 0);
  link.pop(1);
  EXPECT_EQ(*link.front(1), 1);
  EXPECT_EQ(report_of([] { Link<int>("no_places", 1, 0); }),
            "no_places: a link has room for one item at least, and for "
            "2^32 at most");
  const auto before = sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DO_NOTHING);
  EXPECT_EQ(report_of([&] { link.pop(0); }), "not thrown: pop() of a link in which nothing is visible");
  sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, before);
}

TEST(LinkTest, ARestartedLinkIsEmptyAndCountsFromZero) {
  Link<int> link("link", 2, 2);
  std::uint64_t waiting = 0;
  link.announce(&waiting, 5);
  link.push(7, 1);
  link.push(7, 2);
  link.pop(9);
  link.restart();
  EXPECT_EQ(link.space(9), 2u) << "what was taken in a cycle of this number was in another launch";
  EXPECT_EQ(link.next_visible(), kNever);
  EXPECT_EQ(link.pushed(), 0u);
  EXPECT_EQ(waiting, 0u);
}

TEST(LinkTest, AnnouncesThatItIsNoLongerEmpty) {
  Link<int> link("link", 1, 4);
  std::uint64_t waiting = 0;
  link.announce(&waiting, 5);
  link.push(0, 1);
  EXPECT_EQ(waiting, 32u);
  waiting = 0;
  link.push(1, 2);
  EXPECT_EQ(waiting, 0u) << "it was not empty";
  link.pop(2);
  link.pop(2);
  link.push(3, 3);
  EXPECT_EQ(waiting, 32u);
}

TEST(LinkTest, IsFoundByItsName) {
  Link<int> link("link_of_a_test", 3, 4);
  auto* const found = dynamic_cast<LinkObject*>(sc_core::sc_find_object("link_of_a_test"));
  ASSERT_EQ(found, &link);
  EXPECT_EQ(dynamic_cast<link_in_if<int>*>(found), &link) << "what a port is bound to";
  link.push(0, 1);
  link.push(0, 2);
  link.pop(3);
  EXPECT_STREQ(found->kind(), "grtx_link");
  EXPECT_EQ(found->size(), 1u);
  EXPECT_EQ(found->capacity(), 4u);
  EXPECT_EQ(found->latency(), 3u);
  EXPECT_EQ(found->pushed(), 2u);
}

TEST(LinkTest, ANameWithDotsOrUsedTwiceRaisesNoWarning) {
  const auto warnings = sc_core::sc_report_handler::get_count(sc_core::SC_WARNING);
  Link<int> first("client.request", 1, 1), second("client.request", 1, 1);
  EXPECT_STREQ(first.name(), "client_request");
  EXPECT_STRNE(first.name(), second.name());
  EXPECT_EQ(sc_core::sc_report_handler::get_count(sc_core::SC_WARNING), warnings);
}

TEST(WaitingLinksTest, NamesThoseThatHoldSomethingFromAnyOneOnOnceAround) {
  constexpr unsigned kLinks = 130;
  WaitingLinks waiting(kLinks);
  std::vector<std::unique_ptr<Link<int>>> links;
  for (unsigned i = 0; i < kLinks; ++i) {
    links.push_back(std::make_unique<Link<int>>("link" + std::to_string(i), 1, 4));
    waiting.watch(i, LinkReader<int>(*links[i]));
  }
  for (const unsigned i : {129u, 0u, 63u, 64u, 70u}) links[i]->push(0, 1);
  links[70]->push(1, 2);
  const auto from = [&](unsigned first) {
    std::vector<unsigned> all;
    waiting.for_each_from(first, [&](unsigned i) { all.push_back(i); });
    return all;
  };
  EXPECT_EQ(from(0), (std::vector<unsigned>{0, 63, 64, 70, 129}));
  EXPECT_EQ(from(64), (std::vector<unsigned>{64, 70, 129, 0, 63}));
  EXPECT_EQ(from(71), (std::vector<unsigned>{129, 0, 63, 64, 70}));
  for (const unsigned i : {64u, 70u}) {
    links[i]->pop(2);
    waiting.popped(i, LinkReader<int>(*links[i]));
  }
  EXPECT_EQ(from(1), (std::vector<unsigned>{63, 70, 129, 0})) << "link 70 held two";
  std::vector<unsigned> ascending;
  waiting.for_each([&](unsigned i) { ascending.push_back(i); });
  EXPECT_EQ(ascending, (std::vector<unsigned>{0, 63, 70, 129}));
}

TEST(WaitingLinksTest, OneWordGoesOnceAroundFromAnyNumber) {
  IndexSet set(64);
  for (const unsigned i : {0u, 5u, 6u, 63u}) set.insert(i);
  const auto from = [&](unsigned first) {
    std::vector<unsigned> all;
    set.for_each_from(first, [&](unsigned i) { all.push_back(i); });
    return all;
  };
  EXPECT_EQ(from(0), (std::vector<unsigned>{0, 5, 6, 63}));
  EXPECT_EQ(from(6), (std::vector<unsigned>{6, 63, 0, 5}));
  EXPECT_EQ(from(63), (std::vector<unsigned>{63, 0, 5, 6}));
}

TEST(LinkTest, OneItemACycleFlowsThroughTwoPlaces) {
  // Capacity for full rate: latency + 1, because credits return a cycle late.
  Link<int> link("link", 1, 2);
  int sent = 0;
  int received = 0;
  for (Cycle now = 0; now < 100; ++now) {
    const auto consume = [&] {
      if (link.front(now) == nullptr) return;
      EXPECT_EQ(*link.front(now), received++);
      link.pop(now);
    };
    const auto produce = [&] {
      if (link.can_push(now)) link.push(now, sent++);
    };
    if (now % 2 == 0) {
      produce();
      consume();
    } else {
      consume();
      produce();
    }
  }
  EXPECT_EQ(sent, 100);
  EXPECT_EQ(received, 99);
}

}  // namespace
}  // namespace grtx::modules
