// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/scene_io.h"

#include <filesystem>
#include <string_view>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/scene/compressed_ply_reader.h"
#include "grtx/frontend/scene/foreign_formats.h"
#include "grtx/frontend/scene/ply_header.h"
#include "grtx/frontend/scene/ply_reader.h"
#include "grtx/frontend/scene/readers.h"
#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {
namespace {

RawRows read_rows(const std::string& path, std::string_view bytes, const SceneReadOptions& options) {
  if (bytes.empty()) throw Error(path, "", "is empty");
  if (bytes.starts_with("ply")) {
    const PlyHeader header = parse_ply_header(bytes, path);
    return is_compressed_ply(header) ? read_compressed_ply(bytes, header, path) : read_ply(bytes, header, path);
  }
  if (is_spz(bytes)) return read_spz(bytes, options.spz_raw_axes, path);
  if (is_usda(bytes)) return read_usda(bytes, path);
  if (is_ksplat(bytes)) return read_ksplat(bytes, path);
  if (is_splat(bytes)) return read_splat(bytes);
  if (const std::string foreign = foreign_name(path); !foreign.empty()) throw Error(path, "", foreign);
  throw Error(path, "byte 0",
              "must be a .ply, .spz, .sog, .glb, .gltf, .usda, .ksplat or .splat scene; its content is none of them");
}

/// A folder means the SOG scene in it.
std::string file_of(const std::string& path) {
  std::error_code failed;
  if (!std::filesystem::is_directory(path, failed)) return path;
  for (const char* name : {"meta.json", "lod-meta.json"}) {
    const std::filesystem::path file = std::filesystem::path(path) / name;
    if (std::filesystem::exists(file, failed)) return file.string();
  }
  return path;  // refused as a folder
}

std::string name_of(const std::string& path) {
  const std::filesystem::path plain = std::filesystem::path(path).lexically_normal();
  return (plain.has_filename() ? plain : plain.parent_path()).filename().string();
}

/// Rows, and the bytes that identify this input.
struct Input {
  RawRows rows;
  std::string hash;
};

Input read_input(const std::string& path, const SceneReadOptions& options, FilesRead& files) {
  const std::string file = file_of(path);
  const std::string bytes = files.read(file);
  if (const std::string foreign = foreign_content(bytes); !foreign.empty()) throw Error(file, "", foreign);
  if (is_sog_archive(bytes) || is_sog_meta(bytes)) {
    SogRows sog =
        is_sog_archive(bytes) ? read_sog_archive(bytes, file) : read_sog_meta(bytes, options.sog_lod, file, files);
    return {std::move(sog.rows), hex(xxh3(sog.content))};
  }
  std::string hash = hex(files.files().back().hash);
  if (is_glb(bytes) || is_gltf(bytes)) {
    GltfRows gltf = read_gltf(bytes, file, files);
    return {std::move(gltf.rows), gltf.beside.empty() ? hash : hex(xxh3(bytes + gltf.beside))};
  }
  // The same file read with other axes counts as another input.
  if (options.spz_raw_axes && is_spz(bytes)) hash = hex(xxh3(hash + " raw axes"));
  return {read_rows(file, bytes, options), std::move(hash)};
}

}  // namespace

RawRows load_rows(const std::string& path, const SceneReadOptions& options, FilesRead& files) {
  return read_input(path, options, files).rows;
}

RawRows load_rows(const std::string& path, const SceneReadOptions& options) {
  FilesRead files;
  return load_rows(path, options, files);
}

Scene load_scene(const std::string& path, const SceneReadOptions& options, FilesRead& files) {
  Input input = read_input(path, options, files);
  return make_scene(input.rows, name_of(path), std::move(input.hash));
}

Scene load_scene(const std::string& path, const SceneReadOptions& options) {
  FilesRead files;
  return load_scene(path, options, files);
}

Scene load_scene(const std::string& path) { return load_scene(path, SceneReadOptions{}); }

void find_scene_files(const std::string& path, FilesRead& files) {
  const std::string file = file_of(path);
  const std::string bytes = files.read(file);
  // Only the reader of a text file knows which other files it names; all other formats are one file.
  if (is_sog_meta(bytes)) {
    (void)read_sog_meta(bytes, SceneReadOptions{}.sog_lod, file, files);
  } else if (is_gltf(bytes)) {
    (void)read_gltf(bytes, file, files);
  }
}

}  // namespace grtx::frontend
