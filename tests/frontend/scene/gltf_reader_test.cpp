// SPDX-License-Identifier: Apache-2.0
// .glb and .gltf: where values lie, how nodes place them, which axes they have, and what is refused.
#include "grtx/frontend/scene/readers.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "frontend/scene/scene_bytes.h"

namespace grtx::frontend {
namespace {

GltfRows read_gltf(std::string_view bytes, const std::string& file) {
  FilesRead files;
  return frontend::read_gltf(bytes, file, files);
}

using nlohmann::json;
using test::Bytes;
using test::error_of;

/// One Gaussian of degree 0: position, rotation x y z w, scale, opacity, colour, as floats one after the other.
class GltfReader : public testing::Test {
 protected:
  GltfReader() {
    binary_.f32(1).f32(2).f32(3);
    binary_.f32(0.1).f32(0.2).f32(0.3).f32(0.9);
    binary_.f32(1).f32(std::exp(1.0)).f32(0.5);
    binary_.f32(0.25);
    binary_.f32(0.5).f32(-0.5).f32(1.5);
    const auto accessor = [](const char* type, int offset) {
      return json{{"bufferView", 0}, {"byteOffset", offset}, {"componentType", 5126}, {"count", 1}, {"type", type}};
    };
    document_ = {{"asset", {{"version", "2.0"}}},
                 {"scenes", {{{"nodes", {0}}}}},
                 {"nodes", {{{"mesh", 0}}}},
                 {"meshes",
                  {{{"primitives",
                     {{{"mode", 0},
                       {"attributes",
                        {{"POSITION", 0},
                         {"KHR_gaussian_splatting:ROTATION", 1},
                         {"KHR_gaussian_splatting:SCALE", 2},
                         {"KHR_gaussian_splatting:OPACITY", 3},
                         {"KHR_gaussian_splatting:SH_DEGREE_0_COEF_0", 4}}},
                       {"extensions", {{"KHR_gaussian_splatting", {{"kernel", "ellipse"}}}}}}}}}}},
                 {"accessors",
                  {accessor("VEC3", 0), accessor("VEC4", 12), accessor("VEC3", 28), accessor("SCALAR", 40),
                   accessor("VEC3", 44)}},
                 {"bufferViews", {{{"buffer", 0}, {"byteLength", 56}}}},
                 {"buffers", {{{"byteLength", 56}}}}};
  }

  std::string file() const {
    std::string text = document_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    Bytes bytes;
    bytes.text("glTF").add<std::uint32_t>(2).add(static_cast<std::uint32_t>(28 + text.size() + binary_.size()));
    bytes.add(static_cast<std::uint32_t>(text.size())).text("JSON").text(text);
    bytes.add(static_cast<std::uint32_t>(binary_.size())).text(std::string_view("BIN\0", 4)).text(binary_.str());
    return bytes.str();
  }
  RawRows read() const { return read_gltf(file(), "F").rows; }
  /// With one value of the document changed.
  std::string refusal(const char* pointer, const json& value) {
    const json whole = document_;
    document_[json::json_pointer(pointer)] = value;
    const std::string refused = error_of([this] { read(); });
    document_ = whole;
    return refused;
  }

  Bytes binary_;
  json document_;
};

TEST_F(GltfReader, ValuesAreTurnedHalfATurnAboutZ) {
  const RawRows rows = read();
  ASSERT_EQ(rows.x.size(), 1U);
  EXPECT_EQ(rows.x[0], -1.0);
  EXPECT_EQ(rows.y[0], -2.0);
  EXPECT_EQ(rows.z[0], 3.0);
  EXPECT_EQ(rows.rotation, (std::vector<float>{-0.3f, -0.2f, 0.1f, 0.9f}));  // w x y z
  EXPECT_EQ(rows.log_scale[0], 0.0f);
  EXPECT_FLOAT_EQ(rows.log_scale[1], 1.0f);
  EXPECT_FLOAT_EQ(rows.opacity_logit[0], static_cast<float>(std::log(0.25 / 0.75)));
  EXPECT_EQ(rows.sh, (std::vector<float>{0.5f, -0.5f, 1.5f}));
}

TEST_F(GltfReader, NodesMoveAndScale) {
  document_["nodes"] = {{{"children", {1}}, {"translation", {10, 0, 0}}, {"scale", {2, 2, 2}}},
                        {{"mesh", 0}, {"matrix", {3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 1, 0, 1}}}};
  const RawRows rows = read();  // 10 + 2 (3 x + move)
  EXPECT_EQ(rows.x[0], -16.0);
  EXPECT_EQ(rows.y[0], -14.0);
  EXPECT_EQ(rows.z[0], 18.0);
  EXPECT_FLOAT_EQ(rows.log_scale[0], static_cast<float>(std::log(6.0)));
}

TEST_F(GltfReader, IntegersAreNormalised) {
  Bytes opacity;
  opacity.text(binary_.str()).u8(51).u8(0).u8(0).u8(0);
  binary_ = opacity;
  document_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 56}, {"byteLength", 1}});
  document_["accessors"][3] = {
      {"bufferView", 1}, {"componentType", 5121}, {"count", 1}, {"type", "SCALAR"}, {"normalized", true}};
  EXPECT_FLOAT_EQ(read().opacity_logit[0], static_cast<float>(std::log(0.2 / 0.8)));
}

TEST_F(GltfReader, TextWithItsBufferInsideIsTheBinaryFile) {
  const RawRows binary = read();
  for (std::size_t padding = 0; padding < 3; ++padding) {
    document_["buffers"][0]["uri"] =
        "data:application/octet-stream;base64," + test::base64(binary_.str() + std::string(padding, '\1'));
    ASSERT_TRUE(is_gltf(document_.dump(2)));
    const GltfRows text = read_gltf(document_.dump(2), "F");
    EXPECT_EQ(text.rows.x, binary.x);
    EXPECT_EQ(text.rows.rotation, binary.rotation);
    EXPECT_EQ(text.rows.sh, binary.sh);
    EXPECT_EQ(text.beside, "");
  }
}

TEST_F(GltfReader, BuffersBesideTheFileBelongToTheScene) {
  const test::TemporaryPath temporary("_gltf");
  const std::string& folder = temporary.str();
  std::filesystem::create_directories(folder);
  write_file(folder + "/my splats.bin", binary_.str());
  document_["buffers"][0]["uri"] = "my%20splats.bin";
  write_file(folder + "/s.gltf", document_.dump());
  FilesRead files;
  const Scene scene = load_scene(folder + "/s.gltf", {}, files);
  ASSERT_EQ(scene.size(), 1U);
  ASSERT_EQ(files.files().size(), 2U);
  EXPECT_EQ(files.files()[1].name, "my splats.bin");
  const GltfRows text = read_gltf(document_.dump(), folder + "/s.gltf");
  EXPECT_EQ(text.beside, binary_.str());
  std::string changed = binary_.str();
  changed[0] ^= 1;
  write_file(folder + "/my splats.bin", changed);
  EXPECT_NE(load_scene(folder + "/s.gltf").hash, scene.hash);
  document_["buffers"][0]["uri"] = "none.bin";
  EXPECT_NE(error_of([&] { read_gltf(document_.dump(), folder + "/s.gltf"); }), "");
}

TEST_F(GltfReader, NodesAreTreesOfBoundedDepth) {
  document_["nodes"] = json::array();
  for (int i = 0; i < 100; ++i) document_["nodes"].push_back({{"children", {i + 1}}});
  document_["nodes"].push_back({{"mesh", 0}});
  EXPECT_EQ(error_of([&] { read(); }), "nodes[65]: nodes must be at most 64 deep");
  document_["nodes"] = json::array();  // 2^40 paths
  for (int i = 0; i < 40; ++i) document_["nodes"].push_back({{"children", {i + 1, i + 1}}});
  document_["nodes"].push_back({{"mesh", 0}});
  EXPECT_EQ(error_of([&] { read(); }), "nodes[40]: must have one parent at most");
}

TEST_F(GltfReader, DamageIsRefused) {
  const char* rotated =
      "nodes[0]: must not rotate, mirror or stretch its splats; uniform scales and translations are read";
  EXPECT_EQ(refusal("/nodes/0/rotation", {0, 1, 0, 0}), rotated);
  EXPECT_EQ(refusal("/nodes/0/scale", {1, 2, 1}), rotated);
  EXPECT_EQ(refusal("/nodes/0/matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), rotated);
  EXPECT_EQ(refusal("/nodes/0/children", {0}), "nodes[0]: must have one parent at most");
  EXPECT_EQ(refusal("/buffers/0/uri", "..%00"), ".." + std::string(1, '\0') + ": must be a file beside it");
  EXPECT_EQ(refusal("/nodes/0/mesh", 4), "meshes[4]: does not exist");
  EXPECT_EQ(refusal("/accessors/4/byteOffset", 48),
            "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0: goes beyond its bufferView");
  EXPECT_EQ(refusal("/bufferViews/0/byteLength", 60), "POSITION: its bufferView goes beyond its buffer");
  EXPECT_EQ(refusal("/accessors/3/count", 2), "KHR_gaussian_splatting:OPACITY: must have 1 entries, as POSITION");
  EXPECT_EQ(refusal("/accessors/0/componentType", 7), "POSITION: must be of float, byte or short components");
  EXPECT_EQ(refusal("/buffers/0/uri", "../x.bin"), "../x.bin: must be a file beside it");
  EXPECT_EQ(refusal("/buffers/0/uri", "data:text/plain,AAAA"), "buffers[0].uri: must be data in base64");
  EXPECT_EQ(refusal("/buffers/0/uri", "data:;base64,AAA"), "buffers[0].uri: must be data in base64");
  EXPECT_EQ(refusal("/buffers/0/uri", "data:;base64,A*A="), "buffers[0].uri: must be data in base64");
  EXPECT_EQ(refusal("/buffers/0/uri", 1), "buffers[0].uri: must be a text");
  EXPECT_EQ(refusal("/bufferViews/0/buffer", 1), "buffers[1]: does not exist");
  EXPECT_EQ(refusal("/meshes/0/primitives/0/mode", 4), "primitives.mode: must be 0: splats are points");
  EXPECT_EQ(refusal("/meshes/0/primitives/0/attributes/KHR_gaussian_splatting:SH_DEGREE_1_COEF_0", 4),
            "attributes.KHR_gaussian_splatting:SH_DEGREE_1_COEF_1: is missing");
  EXPECT_EQ(refusal("/meshes/0/primitives/0/extensions", json::object()),
            "meshes: no points with KHR_gaussian_splatting: it holds no Gaussians");
  const std::string whole = file();
  for (const std::size_t size : {std::size_t{4}, std::size_t{19}, std::size_t{40}, whole.size() - 1}) {
    EXPECT_NE(error_of([&] { read_gltf(whole.substr(0, size), "F"); }), "") << size;
  }
}

}  // namespace
}  // namespace grtx::frontend
