// SPDX-License-Identifier: Apache-2.0
// Every reader of scenes and cameras notes every file that it opens, and each byte of them counts.
#include "grtx/base/files_read.h"

#include <functional>
#include <set>

#include "frontend/scene/scene_bytes.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "paths.h"

namespace grtx::frontend {
namespace {

namespace fs = std::filesystem;
using test::TemporaryPath;

using Read = std::function<void(const std::string& path, FilesRead& files)>;

void scene(const std::string& path, FilesRead& files) { (void)load_scene(path, {}, files); }
void cameras(const std::string& path, FilesRead& files) { (void)load_cameras(path, files); }

std::set<std::string> files_in(const std::string& folder) {
  std::set<std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) all.insert(fs::weakly_canonical(entry.path()).string());
  }
  return all;
}

/// Expects that every file of the folder is noted, since all are read for what is at `path`.
void expect_all_noted(const std::string& folder, const std::string& path, const Read& read) {
  FilesRead files;
  read(path, files);
  std::set<std::string> noted;
  for (const FilesRead::File& file : files.files()) noted.insert(fs::weakly_canonical(file.path).string());
  EXPECT_EQ(noted, files_in(folder));
  for (const std::string& name : files_in(folder)) {
    const std::string bytes = read_file(name);
    write_file(name, bytes + " ");
    FilesRead changed;
    try {
      read(path, changed);
      EXPECT_NE(changed.hash(), files.hash()) << name;
    } catch (const Error&) {  // refused is as good
    }
    write_file(name, bytes);
  }
}

TEST(FilesReadTest, OfAStreamedScene) {
  const TemporaryPath folder("");
  fs::copy(grtx::paths::source_dir() + "/tests/data/sog_lod", folder.str(), fs::copy_options::recursive);
  fs::remove_all(folder.str() + "/1_0");  // of the next level of detail, which nobody asks for
  expect_all_noted(folder.str(), folder.str() + "/lod-meta.json", scene);
  expect_all_noted(folder.str(), folder.str(), scene);
}

TEST(FilesReadTest, OfAFolderWithMetaJson) {
  const TemporaryPath folder("");
  fs::copy(grtx::paths::source_dir() + "/tests/data/sog_lod/0_0", folder.str(), fs::copy_options::recursive);
  expect_all_noted(folder.str(), folder.str(), scene);
}

TEST(FilesReadTest, OfEachFormatOfOneFile) {
  const std::string from = grtx::paths::source_dir() + "/tests/data/converters/";
  for (const char* name : {"src0.ply", "d0.compressed.ply", "d0.glb", "d0.sog", "d0.splat", "d0.v4.spz"}) {
    FilesRead loaded, found;
    const Scene made = load_scene(from + name, {}, loaded);
    ASSERT_EQ(loaded.files().size(), 1U);
    find_scene_files(from + name, found);
    EXPECT_EQ(found.hash(), loaded.hash()) << name;
    EXPECT_EQ(made.hash, hex(xxh3(read_file(from + name)))) << name;
  }
}

TEST(FilesReadTest, WhatIsFoundWithoutASceneIsWhatASceneReads) {
  const std::string path = grtx::paths::source_dir() + "/tests/data/sog_lod/lod-meta.json";
  FilesRead loaded, found;
  (void)load_scene(path, {}, loaded);
  find_scene_files(path, found);
  EXPECT_EQ(found.inputs(), loaded.inputs());
  EXPECT_GT(found.files().size(), 8U);
}

TEST(FilesReadTest, OfPicturesThatSayTheSizeOfACamera) {
  const TemporaryPath folder("");
  fs::create_directories(folder.str() + "/images");
  std::string png = "\x89PNG\r\n\x1a\n";
  png += std::string("\0\0\0\x0dIHDR\0\0\0\x10\0\0\0\x08", 16);
  write_file(folder.str() + "/images/a.png", png);
  write_file(folder.str() + "/transforms.json",
             R"({"camera_angle_x": 1, "frames": [{"file_path": "images/a",
                "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})");
  FilesRead files;
  cameras(folder.str() + "/transforms.json", files);
  ASSERT_EQ(files.files().size(), 2U);
  EXPECT_EQ(files.files()[1].name, "a.png");
  png[23] = '\x10';
  write_file(folder.str() + "/images/a.png", png);
  FilesRead wider;
  cameras(folder.str() + "/transforms.json", wider);
  EXPECT_NE(wider.hash(), files.hash());
}

TEST(FilesReadTest, NamesAreNoPartOfTheHash) {
  FilesRead a, b, c;
  a.note("x/scene.ply", "bytes");
  b.note("y/moved.ply", "bytes");
  c.note("x/scene.ply", "by");
  c.note("x/more.ply", "tes");
  EXPECT_EQ(a.hash(), b.hash());
  EXPECT_NE(a.hash(), c.hash());
  EXPECT_EQ(a.inputs().at("files"), "scene.ply " + hex(xxh3("bytes")));
}

}  // namespace
}  // namespace grtx::frontend
