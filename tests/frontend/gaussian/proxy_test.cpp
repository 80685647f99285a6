// SPDX-License-Identifier: Apache-2.0
// Proxies circumscribe the unit sphere; numbers of faces, extents and face pairs as published.
#include "grtx/frontend/gaussian/proxy.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace grtx::frontend {
namespace {

TEST(Proxy, IcosahedronFigures) {
  const Proxy proxy(ProxyKind::icosahedron20);
  EXPECT_EQ(proxy.faces(), 20u);
  EXPECT_EQ(proxy.face_pairs().size(), 10u);
  EXPECT_NEAR(std::sqrt(proxy.circumscribed_radius2()), 1.2584085724, 2e-5);
  EXPECT_NEAR(proxy.half_extent(), 1.0704662693, 1e-5);
}

TEST(Proxy, IcosphereFigures) {
  const Proxy proxy(ProxyKind::icosphere80);
  EXPECT_EQ(proxy.faces(), 80u);
  EXPECT_EQ(proxy.vertices().size(), 42u);
  EXPECT_EQ(proxy.face_pairs().size(), 40u);
  EXPECT_NEAR(std::sqrt(proxy.circumscribed_radius2()), 1.0704662693, 2e-5);
  EXPECT_NEAR(proxy.half_extent(), 1.0704662693, 1e-5);
}

TEST(Proxy, FacesWindOutwardsAndClearTheSphere) {
  for (const ProxyKind kind : {ProxyKind::icosahedron20, ProxyKind::icosphere80}) {
    const Proxy proxy(kind);
    for (const auto& [a, b, c] : proxy.triangles()) {
      const glm::dvec3 p(proxy.vertices()[a]), q(proxy.vertices()[b]), r(proxy.vertices()[c]);
      const glm::dvec3 n = glm::normalize(glm::cross(q - p, r - p));
      EXPECT_GE(glm::dot(n, p), 1.0);  // fp32 vertices still stay outside the unit sphere
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
