// SPDX-License-Identifier: Apache-2.0
// The orders of children, each alone, against its description in words: for every set of children that a node can push,
// of every kind.
#include "grtx/traces/orders/child_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "grtx/traces/codec/pop_order.h"

namespace grtx::traces {
namespace {

struct Child {
  unsigned slot;
  bool internal;
  float t;
  friend bool operator==(const Child& a, const Child& b) { return a.slot == b.slot; }
};

std::vector<Child> sorted_by_t(std::vector<Child> children) {
  std::stable_sort(children.begin(), children.end(), [](const Child& a, const Child& b) { return a.t < b.t; });
  return children;
}

/// children: in slot order. As Vulkan-Sim has it: one is followed, the others are pushed and popped from the end.
std::vector<Child> as_vulkan_sim(const std::vector<Child>& children) {
  std::vector<Child> visits, stack;
  for (const Child& child : children) {
    if (child.internal && visits.empty()) {
      visits.push_back(child);
    } else {
      stack.push_back(child);
    }
  }
  for (; !stack.empty(); stack.pop_back()) visits.push_back(stack.back());
  return visits;
}

/// What the policy says of the children of a visit.
template <typename Policy>
std::vector<Child> visits_of(Policy, const std::vector<Child>& children) {
  unsigned pushed = 0, internal = 0;
  for (const Child& child : children) {
    pushed |= 1u << child.slot;
    if (child.internal) internal |= 1u << child.slot;
  }
  std::vector<Child> visits(children.size());
  for (const Child& child : children) {
    unsigned rank = 0;
    for (const Child& other : children) {
      rank += other.t < child.t || (other.t == child.t && other.slot < child.slot) ? 1 : 0;
    }
    visits[Policy::place(child.slot, pushed, rank)] = child;
  }
  const auto followed = std::find_if(visits.begin(), visits.end(), [&](const Child& child) {
    return Policy::followed(pushed, internal) == 1u << child.slot;
  });
  if (followed != visits.end()) std::rotate(visits.begin(), followed, followed + 1);
  return visits;
}

template <typename F>
void for_each_set_of_children(F&& f) {
  std::mt19937 random(3);
  for (unsigned hit = 0; hit < 256; ++hit) {
    for (unsigned internal = 0; internal < 256; ++internal) {
      std::vector<Child> children;
      for (unsigned slot = 0; slot < 8; ++slot) {
        if ((hit >> slot & 1) == 0) continue;
        children.push_back({slot, (internal >> slot & 1) != 0, static_cast<float>(random() % 4)});
      }
      f(children);
    }
  }
}

TEST(ChildOrder, NearFirstGoesByDistanceThenSlot) {
  for_each_set_of_children([](const std::vector<Child>& c) { ASSERT_EQ(visits_of(NearFirst{}, c), sorted_by_t(c)); });
}

TEST(ChildOrder, SlotGoesBySlot) {
  for_each_set_of_children([](const std::vector<Child>& c) { ASSERT_EQ(visits_of(SlotOrder{}, c), c); });
}

TEST(ChildOrder, VulkanSimFollowsOneAndPopsTheOthersFromTheEnd) {
  for_each_set_of_children(
      [](const std::vector<Child>& c) { ASSERT_EQ(visits_of(VulkanSimOrder{}, c), as_vulkan_sim(c)); });
  // Slots 1 (leaf), 2 (internal), 4 (internal), 5 (leaf): 2 is followed; then 5, 4, 1.
  const std::vector<Child> children = {{1, false, 0.f}, {2, true, 3.f}, {4, true, 1.f}, {5, false, 2.f}};
  std::vector<unsigned> slots;
  for (const Child& child : visits_of(VulkanSimOrder{}, children)) slots.push_back(child.slot);
  EXPECT_EQ(slots, (std::vector<unsigned>{2, 5, 4, 1}));
}

TEST(ChildOrder, EachNameHasItsPolicy) {
  std::set<ChildOrder> seen;
  for (const auto& entry : enum_names(ChildOrder{})) {
    seen.insert(with_child_order(entry.value, [&](auto policy) {
      EXPECT_EQ(policy.kName, entry.value) << entry.name;
      return policy.kName;
    }));
  }
  EXPECT_EQ(seen.size(), enum_names(ChildOrder{}).size());
}

// What the codec asks in place of the policy: the children of a frame, and of the frame that is split off it.
TEST(PopOrder, NamesTheNextChildByTheSlots) {
  EXPECT_FALSE(PopOrder(ChildOrder::near_first).by_slots());
  for (const ChildOrder name : {ChildOrder::slot, ChildOrder::vulkan_sim}) {
    const PopOrder order(name);
    EXPECT_TRUE(order.by_slots());
    for_each_set_of_children([&](const std::vector<Child>& children) {
      if (children.empty()) return;
      StackFrame frame{7, {3, 9}, 0}, rest;
      unsigned internal = 0;
      for (const Child& child : children) {
        frame.remaining |= 1u << child.slot;
        if (child.internal) internal |= 1u << child.slot;
      }
      std::vector<StackFrame> frames;
      const bool split = order.split(frame, internal, rest);
      if (split) frames.push_back(rest);
      frames.push_back(frame);
      std::vector<unsigned> popped, expected;
      for (; !frames.empty(); frames.pop_back()) {
        EXPECT_EQ(frames.back().parent, 7u);
        EXPECT_EQ(frames.back().path, (InstancePath{3, 9}));
        ASSERT_NE(frames.back().remaining, 0u);
        for (unsigned& left = frames.back().remaining; left != 0; left &= ~(1u << popped.back())) {
          popped.push_back(order.next(left));
        }
      }
      for (const Child& c : name == ChildOrder::slot ? children : as_vulkan_sim(children)) expected.push_back(c.slot);
      ASSERT_EQ(popped, expected);
    });
  }
}

}  // namespace
}  // namespace grtx::traces
