// SPDX-License-Identifier: Apache-2.0
// Generated scenes: the same request gives the same bytes, every preset loads, and the stress presets do what
// docs/model/synthetic-scenes.md promises.
#include "grtx/frontend/synth/synth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/scene/scene_io.h"
#include "temporary_folder.h"

namespace grtx::frontend {
namespace {

using ::testing::HasSubstr;

class Synth : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  std::string make(const std::string& preset, std::uint64_t count, std::uint64_t seed = 1, unsigned degree = 2) const {
    const std::string file = path("scene.ply");
    synthesise({preset, count, seed, degree}, file);
    return file;
  }
  std::vector<Camera> cameras() const { return load_cameras(path("scene.cameras.json")); }
  ReferenceResult render(const Scene& scene, std::size_t view, unsigned pixels, bool inside = false) const {
    ReferenceOptions options;
    options.keep_sequences = true;
    if (inside) options.proxy = ReferenceProxy::sphere;
    options.count_inside = inside;
    return render_reference(scene, cameras().at(view).resized(pixels, pixels), options);
  }

  const grtx::test::TemporaryFolder folder_;
};

double brightness(const Image& image) {
  double sum = 0.0;
  for (const glm::vec3& pixel : image.pixels) sum += static_cast<double>(pixel.x + pixel.y + pixel.z);
  return sum / (3.0 * static_cast<double>(image.pixels.size()));
}

TEST_F(Synth, SameRequestSameBytesOtherSeedOtherBytes) {
  for (const std::string& preset : synth_presets()) {
    const std::string first = read_file(make(preset, 500, 7));
    const std::string first_cameras = read_file(path("scene.cameras.json"));
    EXPECT_EQ(read_file(make(preset, 500, 7)), first) << preset;
    EXPECT_EQ(read_file(path("scene.cameras.json")), first_cameras) << preset;
    if (preset == "stress-empty") continue;
    EXPECT_NE(read_file(make(preset, 500, 8)), first) << preset;
  }
}

TEST_F(Synth, BytesAreTheSameOnEveryHost) {
  // Recorded once; a difference means that generated scenes are no longer comparable with earlier ones.
  struct Case {
    const char* preset;
    const char* hash;
  };
  for (const Case& c :
       {Case{"hall", "8987538c71ae98f4"}, Case{"building", "7a0a6d63fd77664d"}, Case{"flat", "b24ef2c884da36d1"},
        Case{"room", "35379e7924468a52"}, Case{"garden", "30065a171442e552"}, Case{"object", "cac7bb871407222d"},
        Case{"stress-needles", "2bb425399b75ba00"}}) {
    EXPECT_EQ(hex(xxh3(read_file(make(c.preset, 3000, 42)))), c.hash) << c.preset;
  }
}

TEST_F(Synth, EveryPresetLoadsAtEveryDegreeWithItsCameras) {
  for (const std::string& preset : synth_presets()) {
    for (unsigned degree = 0; degree <= 3; ++degree) {
      const Scene scene = load_scene(make(preset, 300, 1, degree));
      EXPECT_EQ(
          scene.report.rows, scene.size() +
                                 [&] {
                                   std::uint64_t dropped = 0;
                                   for (const auto& [reason, count] : scene.report.dropped) dropped += count;
                                   return dropped;
                                 }())
          << preset;
      EXPECT_EQ(scene.sh_degree, degree) << preset;
      if (preset == "stress-empty") {
        EXPECT_EQ(scene.size(), 0u);
      } else if (preset == "stress-one") {
        EXPECT_EQ(scene.size(), 1u);
      } else if (preset != "stress-params" && preset != "stress-quaternions" && preset != "stress-opacity") {
        EXPECT_EQ(scene.size(), 300u) << preset;
      }
    }
    EXPECT_GE(cameras().size(), 2u) << preset;
  }
}

TEST_F(Synth, EveryCameraSeesTheSurfacesColourAtEveryDegree) {
  // Degree 0 has the surface's colour alone. From degree 2 on there is room for all cameras (0.18 if only one is
  // fitted).
  const auto seen = [&](const std::string& preset, unsigned degree, std::size_t camera) {
    const Scene scene = load_scene(make(preset, 4000, 1, degree));
    const glm::dvec3 eye = cameras().at(camera).position - scene.offset;
    std::vector<float> grey;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const glm::vec3 view = glm::normalize(glm::vec3(glm::dvec3(scene.mean[i]) - eye));
      const auto basis = sh_basis(view, degree);
      const glm::vec3 rgb = sh_colour(&scene.sh[3 * i * scene.sh_coefficients()], basis, scene.sh_coefficients());
      grey.push_back((rgb.x + rgb.y + rgb.z) / 3.0F);
    }
    return grey;
  };
  for (const char* preset : {"hall", "building", "room", "flat", "garden", "object"}) {
    for (std::size_t camera = 0; camera < 4; ++camera) {
      const std::vector<float> flat = seen(preset, 0, camera);
      for (const unsigned degree : {2u, 3u}) {
        const std::vector<float> glossy = seen(preset, degree, camera);
        double sum = 0.0;
        for (std::size_t i = 0; i < flat.size(); ++i) sum += std::pow(glossy[i] - flat[i], 2.0F);
        EXPECT_LT(std::sqrt(sum / static_cast<double>(flat.size())), 0.08) << preset << degree << " camera " << camera;
      }
    }
  }
}

TEST_F(Synth, RowsFormAStreamOfTheAskedLengthWithZeroNormals) {
  const std::string bytes = read_file(make("flat", 1000, 1, 2));
  EXPECT_THAT(bytes.substr(0, 80), HasSubstr("format binary_little_endian 1.0\nelement vertex 1000\n"));
  const std::size_t data = bytes.find("end_header\n") + 11;
  ASSERT_EQ(bytes.size() - data, 1000u * 41u * 4u);
  for (std::size_t row = 0; row < 1000; ++row)
    EXPECT_EQ(bytes.substr(data + row * 164 + 12, 12), std::string(12, '\0'));
}

TEST_F(Synth, BadRequestsNameTheRule) {
  struct Case {
    SynthOptions options;
    const char* text;
  };
  for (const Case& c :
       {Case{{"halls", 10, 1, 2}, "nearest name is hall"}, Case{{"stress-tie", 10, 1, 2}, "stress-ties"},
        Case{{"flat", 0, 1, 2}, "must be 1 to"}, Case{{"flat", 10, 1, 4}, "must be 0 to 3"},
        Case{{"flat", std::uint64_t{1} << 32, 1, 2}, "must be 1 to"}}) {
    EXPECT_THAT([&] { synthesise(c.options, path("bad.ply")); },
                ::testing::ThrowsMessage<Error>(::testing::HasSubstr(c.text)));
    EXPECT_FALSE(std::filesystem::exists(path("bad.ply")));
  }
}

TEST_F(Synth, TrainedLikeScenesFillTheirViews) {
  struct Case {
    const char* preset;
    double least, most;
  };
  for (const Case& c : {Case{"hall", 0.1, 0.8}, Case{"building", 0.05, 0.5}, Case{"flat", 0.1, 0.8},
                        Case{"room", 0.1, 0.8}, Case{"garden", 0.05, 0.8}, Case{"object", 0.01, 0.5}}) {
    const Scene scene = load_scene(make(c.preset, 8000));
    for (std::size_t view = 0; view < cameras().size(); ++view) {
      const double light = brightness(render(scene, view, 12).image);
      EXPECT_GT(light, c.least) << c.preset << ' ' << view;
      EXPECT_LT(light, c.most) << c.preset << ' ' << view;
    }
  }
}

TEST_F(Synth, TiesStraddleEveryMultipleOfEveryK) {
  const Scene scene = load_scene(make("stress-ties", 20000));
  const ReferenceResult result = render(scene, 0, 96);
  for (const std::size_t k : {1u, 2u, 4u, 8u, 16u, 32u}) {
    std::set<std::size_t> rounds;  // rounds after which a tie with the next hit remains
    for (const auto& hits : result.sequences) {
      for (std::size_t i = k; i < hits.size(); i += k) {
        if (hits[i].t == hits[i - 1].t) rounds.insert(i / k);
      }
    }
    for (std::size_t round = 1; round * k <= 64; ++round)
      EXPECT_TRUE(rounds.count(round)) << "k " << k << " round " << round;
  }
}

TEST_F(Synth, InsideSkipsHalfOfTheProxiesAndCountsThemOnRequest) {
  const Scene scene = load_scene(make("stress-inside", 1200));
  const ReferenceResult skipped = render(scene, 0, 16);
  const ReferenceResult counted = render(scene, 0, 16, true);
  std::size_t outside = 0;
  std::size_t at_origin = 0;
  for (const auto& hits : skipped.sequences) outside += hits.size();
  for (const auto& hits : counted.sequences) {
    at_origin += static_cast<std::size_t>(
        std::count_if(hits.begin(), hits.end(), [](const ReferenceHit& h) { return h.t == 0.0; }));
  }
  EXPECT_GT(outside, 100u);
  EXPECT_GT(at_origin, 500u);
}

TEST_F(Synth, NoHitIsBlackAndOneIsNot) {
  for (std::size_t view = 0; view < 2; ++view) {
    EXPECT_EQ(brightness(render(load_scene(make("stress-nohit", 500)), view, 32).image), 0.0);
    EXPECT_EQ(brightness(render(load_scene(make("stress-empty", 1)), view, 8).image), 0.0);
    EXPECT_GT(brightness(render(load_scene(make("stress-one", 1)), view, 32).image), 0.01);
  }
}

TEST_F(Synth, FarClustersLookAlikeFromTheirCameras) {
  const Scene scene = load_scene(make("stress-far", 800));
  for (std::size_t view = 0; view < 4; ++view) {
    const ReferenceResult result = render(scene, view, 24);
    std::size_t hits = 0;
    for (const auto& sequence : result.sequences) hits += sequence.empty() ? 0 : 1;
    EXPECT_GT(hits, 100u) << view;
    for (const glm::vec3& pixel : result.image.pixels) EXPECT_TRUE(std::isfinite(pixel.x + pixel.y + pixel.z));
  }
}

TEST_F(Synth, AxisRaysHaveExactZerosAndMeetGaussians) {
  const Scene scene = load_scene(make("stress-axis", 1500));
  const std::vector<Camera> views = cameras();
  for (std::size_t view = 0; view < views.size(); ++view) {
    const glm::dvec3 middle = views[view].direction(64, 64);
    EXPECT_EQ(std::abs(middle.x) + std::abs(middle.y) + std::abs(middle.z), 1.0) << view;
    EXPECT_GT(render(scene, view, 129).sequences[64 * 129 + 64].size(), 3u) << view;
  }
}

TEST_F(Synth, HardParametersLeaveOnlyUsableRows) {
  const Scene scene = load_scene(make("stress-params", 2000));
  EXPECT_FALSE(scene.report.dropped.empty());
  EXPECT_FALSE(scene.report.clamped.empty());
  EXPECT_GT(scene.size(), 1000u);
  for (std::size_t view = 0; view < 2; ++view) {
    const ReferenceResult result = render(scene, view, 16);
    for (const auto& hits : result.sequences) {
      for (const ReferenceHit& hit : hits) EXPECT_TRUE(hit.t > 0.0 && hit.alpha >= 1.0 / 255.0 && hit.alpha <= 0.99);
    }
  }
}

TEST_F(Synth, QuaternionsOfEveryKeptLengthTurnAlike) {
  const Scene scene = load_scene(make("stress-quaternions", 450));  // 30 rounds of 15 lengths
  EXPECT_EQ(scene.report.dropped, (std::map<std::string, std::uint64_t>{{"quaternion norm < 1e-12", 30u * 4u}}));
  ASSERT_EQ(scene.size(), 30u * 11u);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const std::size_t same_turn = i / 11 % 2 * 11;  // the first of each turn has length 2^0 times its own
    EXPECT_EQ(scene.rotation[i], scene.rotation[same_turn]) << i;
  }
}

TEST_F(Synth, OpacitiesAtTheirLimitsAreCounted) {
  const Scene scene = load_scene(make("stress-opacity", 350));  // 10 rounds of 35 logits
  EXPECT_EQ(scene.report.dropped.at("opacity logit -infinity"), 10u);
  EXPECT_EQ(scene.report.dropped.at("NaN opacity"), 10u);
  EXPECT_EQ(scene.report.dropped.size(), 2u);
  EXPECT_EQ(scene.report.clamped.at("opacity logit +infinity, opacity 1"), 10u);
  const auto unacceptable = static_cast<std::uint64_t>(
      std::count_if(scene.opacity.begin(), scene.opacity.end(), [](float o) { return o <= 1.0f / 255.0f; }));
  EXPECT_EQ(scene.report.noticed.at("opacity <= 1/255 (can never be accepted)"), unacceptable);
  EXPECT_GE(unacceptable, 70u);  // five saturated logits and two below 1/255
  const ReferenceResult result = render(scene, 0, 64);
  std::set<std::uint32_t> seen;
  for (const auto& hits : result.sequences) {
    for (const ReferenceHit& hit : hits) seen.insert(hit.gaussian);
  }
  for (const std::uint32_t id : seen) EXPECT_GT(scene.opacity[id], 0.99f / 255.0f);
  EXPECT_GT(seen.size(), 80u);
}

TEST_F(Synth, CopiesTieOnEveryRay) {
  const Scene scene = load_scene(make("stress-copies", 300));
  const ReferenceResult result = render(scene, 0, 17);
  std::size_t longest = 0;
  for (const auto& hits : result.sequences) {
    longest = std::max(longest, hits.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      EXPECT_EQ(hits[i].t, hits[0].t);
      EXPECT_EQ(hits[i].gaussian, i);
    }
  }
  EXPECT_GT(longest, 100u);
}

TEST_F(Synth, OnePointOrdersByEntryNotByCentre) {
  const Scene scene = load_scene(make("stress-onepoint", 300));
  for (std::size_t i = 1; i < scene.size(); ++i) ASSERT_EQ(scene.mean[i], scene.mean[0]);
  const ReferenceResult result = render(scene, 0, 17);
  std::size_t longest = 0;
  for (const auto& hits : result.sequences) longest = std::max(longest, hits.size());
  EXPECT_GT(longest, 30u);
}

}  // namespace
}  // namespace grtx::frontend
