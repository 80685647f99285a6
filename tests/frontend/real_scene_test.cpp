// Anchors on real trained scenes: bytes a Gaussian of both structures, image identity. Skipped where the scenes lack.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "frontend/image.h"
#include "frontend/scene_io.h"
#include "render_helpers.h"

namespace grtx::frontend {
namespace {

/// The folder of scenes, or "" where there is none.
std::string scene_folder() {
  if (const char* named = std::getenv("GRTX_SCENES")) return named;
  const std::filesystem::path beside = std::filesystem::path(GRTX_SOURCE_DIR) / ".." / "shared" / "scenes";
  return std::filesystem::is_directory(beside) ? beside.string() : "";
}

/// Path of an unpacked .ply; unpacks NAME.ply.xz into the temporary folder with xz. "" when the scene is missing.
std::string scene_path(const std::string& name) {
  const std::string folder = scene_folder();
  if (folder.empty()) return "";
  const std::string plain = folder + "/" + name + ".ply";
  if (std::filesystem::exists(plain)) return plain;
  if (!std::filesystem::exists(plain + ".xz")) return "";
  const std::string unpacked = testing::TempDir() + "/grtx_" + name + ".ply";
  if (!std::filesystem::exists(unpacked)) {
    const std::string partial = unpacked + "." + std::to_string(::getpid());
    if (std::system(("xz -dkc '" + plain + ".xz' > '" + partial + "'").c_str()) != 0) return "";
    std::filesystem::rename(partial, unpacked);
  }
  return unpacked;
}

struct RealScene {
  const char* file;
  const char* cameras;
};
std::ostream& operator<<(std::ostream& out, const RealScene& s) { return out << s.file; }

class RealSceneTest : public testing::TestWithParam<RealScene> {};

TEST_P(RealSceneTest, StructureSizesAndImageIdentity) {
  const std::string path = scene_path(GetParam().file);
  if (path.empty()) GTEST_SKIP() << "no real scenes: put them into ../shared/scenes or name the folder in GRTX_SCENES";
  const Scene scene = load_scene(path);
  Camera camera = load_cameras(scene_folder() + "/" + GetParam().cameras + ".cameras.json")[0].resized(48, 48);
  const PreparedGaussians gaussians(scene, true);
  const double count = static_cast<double>(scene.size());
  const AccelerationStructure monolithic(gaussians, {AccelKind::tri20, 6, false});
  const AccelerationStructure two_level(gaussians, {AccelKind::tlas_tri20, 6, false});
  // The paper's table in binary units, +-1.5 %.
  EXPECT_GE(static_cast<double>(monolithic.image().size()) / count, 1705.0 * 0.985);
  EXPECT_LE(static_cast<double>(monolithic.image().size()) / count, 1721.0 * 1.015);
  EXPECT_GE(static_cast<double>(two_level.image().size()) / count, 147.6 * 0.985);
  EXPECT_LE(static_cast<double>(two_level.image().size()) / count, 149.4 * 1.015 + 2048.0 / count);
  TracerOptions options;
  const RenderResult expected = test::trace_scene(scene, camera, monolithic, gaussians, options);
  EXPECT_GT(expected.counters.blended, 1000u);
  for (const AccelerationStructure* accel : {&monolithic, &two_level}) {
    for (const bool checkpoint : {false, true}) {
      options.checkpoint = checkpoint;
      const RenderResult actual = test::trace_scene(scene, camera, *accel, gaussians, options);
      EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u);
      EXPECT_TRUE(expected.sequences == actual.sequences);
    }
  }
}

// The two largest scenes are left to bench/: their monolithic builds take a minute on two cores.
INSTANTIATE_TEST_SUITE_P(Scenes, RealSceneTest,
                         testing::Values(RealScene{"statue_st-peter_sh0", "st-peter"},
                                         RealScene{"pizza_161k_sh3", "pizza"}, RealScene{"playbot_L2", "playbot"}));

}  // namespace
}  // namespace grtx::frontend
