// Damaged scenes, cameras, object lists and images: each is read, or refused with an Error. Nothing else.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "frontend/scene/scene_bytes.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "mutations.h"
#include "paths.h"

namespace grtx::frontend {
namespace {

namespace fs = std::filesystem;

class ReaderFuzz : public ::testing::Test {
 protected:
  ReaderFuzz() : folder_((fs::temp_directory_path() / ("grtx_fuzz_" + std::to_string(::getpid()))).string()) {
    fs::create_directories(folder_);
  }
  ~ReaderFuzz() override { fs::remove_all(folder_); }

  /// Reads `original` as file `name` with seeded damage. Any exception but Error ends the test.
  template <class Read>
  void fuzz(const std::string& name, const std::string& original, const Read& read) {
    const std::string path = folder_ + "/" + name;
    std::mt19937_64 random(testing_fuzz::seed());
    std::uint64_t refused = 0;
    for (std::uint64_t i = 0; i < testing_fuzz::count(150); ++i) {
      const std::string bytes = testing_fuzz::mutated(original, random);
      { std::ofstream(path, std::ios::binary) << bytes; }
      try {
        read(path);
      } catch (const Error& error) {
        ++refused;
        EXPECT_FALSE(error.rule().empty()) << name << ", mutation " << i;
      } catch (const std::exception& error) {
        ADD_FAILURE() << name << ", mutation " << i << " of seed " << testing_fuzz::seed() << ": " << error.what();
        write_file((fs::temp_directory_path() / ("grtx_find_" + std::to_string(i) + "_" + name)).string(), bytes);
      }
    }
    EXPECT_GT(refused, 0U) << name << ": no mutation was noticed";
  }

  std::string folder_;
};

TEST_F(ReaderFuzz, Scenes) {
  const auto read = [](const std::string& path) { (void)load_scene(path); };
  for (const auto& entry : fs::directory_iterator(grtx::paths::source_dir() + "/tests/data/converters")) {
    const std::string name = entry.path().filename().string();
    if (name != "README.md") fuzz(name, read_file(entry.path().string()).substr(0, 20000), read);
  }
}

TEST_F(ReaderFuzz, Cameras) {
  const auto read = [](const std::string& path) { (void)load_cameras(path); };
  fuzz("cameras.json",
       R"([{"id": 0, "img_name": "a", "width": 64, "height": 48, "position": [0.5, 1, -2], "rotation": [[1, 0, 0], )"
       R"([0, 1, 0], [0, 0, 1]], "fy": 50.5, "fx": 50.25}])",
       read);
  fuzz("transforms.json",
       R"({"fl_x": 50, "fl_y": 51, "cx": 32, "cy": 24, "w": 64, "h": 48, "frames": [{"file_path": "a", )"
       R"("transform_matrix": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]})",
       read);
}

TEST_F(ReaderFuzz, Colmap) {
  test::Bytes cameras, images;
  cameras.add(std::uint64_t{1}).add(std::int32_t{7}).add(std::int32_t{1});
  cameras.add(std::uint64_t{640}).add(std::uint64_t{480});
  for (const double p : {500.0, 501.0, 320.0, 240.0}) cameras.add(p);
  images.add(std::uint64_t{1}).add(std::int32_t{1});
  for (const double v : {1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0}) images.add(v);
  images.add(std::int32_t{7}).text("a.png").u8(0).add(std::uint64_t{1});
  images.add(1.0).add(2.0).add(std::int64_t{-1});
  const auto read = [&](const std::string&) { (void)load_cameras(folder_); };
  write_file(folder_ + "/images.bin", images.str());
  fuzz("cameras.bin", cameras.str(), read);
  write_file(folder_ + "/cameras.bin", cameras.str());
  fuzz("images.bin", images.str(), read);
}

TEST_F(ReaderFuzz, ObjectLists) {
  fuzz("objects.json",
       R"([{"file": "a.ply", "translate": [0, 1, 2.5], "rotate": [1, 0, 0, 0], "scale": 2}, {"file": "b.ply"}])",
       [](const std::string& path) { (void)load_object_list(path); });
}

TEST_F(ReaderFuzz, Images) {
  Image image(7, 5);
  for (unsigned i = 0; i < 35; ++i) image.pixels[i] = glm::vec3(0.02f * static_cast<float>(i));
  for (const char* name : {"i.png", "i.exr", "i.pfm"}) {
    write_image(folder_ + "/" + name, image);
    fuzz(name, read_file(folder_ + "/" + name), [](const std::string& path) { (void)read_image(path); });
  }
}

}  // namespace
}  // namespace grtx::frontend
