// SPDX-License-Identifier: Apache-2.0
// USD text: ParticleField3DGaussianSplat as OpenUSD and 3DGRUT write it, amid all else that such a file may hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/scene/scene_bytes.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

constexpr const char* kPrim = R"(
        float3[] extent = [(-1, -1, -1), (1, 1, 1)]
        float[] opacities = [0.5, 0.25]
        quatf[] orientations = [(1, 0, 0, 0), (0, 0, -1, 0)]
        point3f[] positions = [(1, 2, 3), (-1e0, .5, 7)]
        float3[] radiance:sphericalHarmonicsCoefficients = [(0.1, 0.2, 0.3), (0.4, 0.5, 0.6)] (
            elementSize = 1
            interpolation = "vertex"
        )
        uniform int radiance:sphericalHarmonicsDegree = 0
        float3[] scales = [(0.5, 0.25, 4), (1, 1, 1)]
        uniform token sortingModeHint = "cameraDistance"
)";

std::string prim(const std::string& body, const std::string& name = "gaussians") {
  return "    def ParticleField3DGaussianSplat \"" + name +
         "\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n" + "    )\n    {" + body + "    }\n";
}

std::string file(const std::string& prims) {
  return "#usda 1.0\n(\n    defaultPrim = \"World\"\n    customLayerData = {\n        dictionary a = {\n            "
         "string b "
         "= \"} ] ) \\\" #\"\n        }\n    }\n)\n\ndef Xform \"World\"\n{\n" +
         prims + "}\n";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(UsdaReader, DecodesAPrimWrittenByHand) {
  const Scene scene = scene_from(file(prim(kPrim)));
  ASSERT_EQ(scene.size(), 2U);
  EXPECT_EQ(scene.sh_degree, 0U);
  EXPECT_EQ(centre_of(scene, 0), glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_FLOAT_EQ(scene.scale[0].y, 0.25F);  // linear in the file
  EXPECT_FLOAT_EQ(scene.opacity[1], 0.25F);
  EXPECT_EQ(scene.rotation[1], glm::quat(0.0F, 0.0F, -1.0F, 0.0F));  // w x y z in the file
  EXPECT_FLOAT_EQ(scene.sh[4], 0.5F);
  EXPECT_TRUE(scene.report.noticed.empty());
}

TEST(UsdaReader, SkipsWhatElseAStageHolds) {
  const Scene plain = scene_from(file(prim(kPrim)));
  const std::string more = R"(
    custom string note = """def ParticleField3DGaussianSplat "no" { """   # and a comment: }
    asset texture = @./a "b".png@
    rel material:binding = </World/Looks/m}>
    float unset
    double3 xformOp:translate.timeSamples = {
        0: (1, 2, 3),
        1: None,
    }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    over "other" { int a = -1; int b = +2 }
    class "_c" {}
    variantSet "v" = { "one" { float w = 1 } }
    reorder properties = ["a", "b"]
    def Camera "camera" (
        hide_in_stage_window = true
    )
    {
        float focalLength = 18.1
    }
)";
  const Scene scene = scene_from(file(more + prim(kPrim)));
  EXPECT_EQ(scene.mean, plain.mean);
  EXPECT_EQ(scene.scale, plain.scale);
  EXPECT_EQ(scene.report.noticed.at("transforms of prims, not applied"), 1U);
}

TEST(UsdaReader, FloatsCountBeforeHalves) {
  const std::string half = replaced(kPrim, "float[] opacities = [0.5, 0.25]", "half[] opacitiesh = [0.75, 0.125]");
  EXPECT_FLOAT_EQ(scene_from(file(prim(half))).opacity[0], 0.75F);
  const std::string both = std::string(kPrim) + "        half[] opacitiesh = [0.75, 0.125]\n";
  EXPECT_FLOAT_EQ(scene_from(file(prim(both))).opacity[0], 0.5F);
  const std::string none = replaced(half, "half[] opacitiesh", "float[] opacities = None\n        half[] opacitiesh");
  EXPECT_FLOAT_EQ(scene_from(file(prim(none))).opacity[0], 0.75F);
}

TEST(UsdaReader, TakesAllPrimsOfAFile) { EXPECT_EQ(scene_from(file(prim(kPrim) + prim(kPrim, "more"))).size(), 4U); }

TEST(UsdaReader, RefusesInOneLineWithItsNumber) {
  EXPECT_EQ(scene_error("#usda 1.0\ndef Xform \"World\" {}\n"),
            ": no def ParticleField3DGaussianSplat in it, and no file that it names is opened");
  const auto changed = [](const char* from, const char* to) {
    return scene_error(file(prim(replaced(kPrim, from, to))));
  };
  EXPECT_EQ(changed("[0.5, 0.25]", "[0.5, 0.25, 1]"),
            "line 28: opacities must be of the 2 positions; it has 3 numbers, not 2");
  EXPECT_EQ(changed("[0.5, 0.25]", "[0.5, x]"), "line 18: needs a number");
  EXPECT_EQ(changed("[0.5, 0.25]", "[0.5 0.25]"), "line 18: needs ',' or ']'");
  EXPECT_EQ(changed("[0.5, 0.25]", "[0.5, 2]"), "line 28: opacities must be 0 to 1");
  EXPECT_EQ(changed("(1, 1, 1)]\n        uniform", "(1, -1, 1)]\n        uniform"),
            "line 28: scales must not be negative: they are linear");
  EXPECT_EQ(changed("(1, 2, 3)", "(1, 2)"), "line 20: needs ','");
  EXPECT_EQ(changed("Degree = 0", "Degree = 4"), "line 28: radiance:sphericalHarmonicsDegree must be 0 to 3");
  EXPECT_EQ(changed("uniform int radiance:sphericalHarmonicsDegree = 0", ""),
            "line 28: needs radiance:sphericalHarmonicsDegree");
  EXPECT_EQ(changed("positions = [", "positions.timeSamples = ["),
            "line 20: positions.timeSamples: splats that move are not read");
  EXPECT_EQ(scene_error(file("def Xform \"a\" { string s = \"never closed\n}")), "line 15: ends inside a string");
  const std::string good = file(prim(kPrim));
  for (std::size_t length = 10; length < good.size() - 4; length += 7)
    EXPECT_NE(scene_error(good.substr(0, length)), "");
}

}  // namespace
}  // namespace grtx::frontend::test
