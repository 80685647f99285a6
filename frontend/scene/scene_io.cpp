#include "grtx/frontend/scene/scene_io.h"

#include <filesystem>
#include <string_view>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/scene/compressed_ply_reader.h"
#include "grtx/frontend/scene/ply_header.h"
#include "grtx/frontend/scene/ply_reader.h"
#include "grtx/frontend/scene/scene_rows.h"
#include "grtx/frontend/scene/splat_reader.h"
#include "grtx/frontend/scene/spz_reader.h"

namespace grtx::frontend {
namespace {

RawRows read_rows(const std::string& path, std::string_view bytes, const SceneReadOptions& options) {
  if (bytes.empty()) throw Error(path, "", "is empty");
  if (bytes.starts_with("ply")) {
    const PlyHeader header = parse_ply_header(bytes, path);
    return is_compressed_ply(header) ? read_compressed_ply(bytes, header, path) : read_ply(bytes, header, path);
  }
  if (is_spz(bytes)) return read_spz(bytes, options.spz_raw_axes, path);
  if (is_splat(bytes)) return read_splat(bytes);
  throw Error(path, "byte 0", "must be a .ply, .spz or .splat scene; its content is none of them");
}

}  // namespace

Scene load_scene(const std::string& path, const SceneReadOptions& options) {
  const std::string bytes = read_file(path);
  std::string hash = hex(xxh3(bytes));
  // The same file read with other axes is another input.
  if (options.spz_raw_axes && is_spz(bytes)) hash = hex(xxh3(hash + " raw axes"));
  return make_scene(read_rows(path, bytes, options), std::filesystem::path(path).filename().string(), std::move(hash));
}

Scene load_scene(const std::string& path) { return load_scene(path, SceneReadOptions{}); }

}  // namespace grtx::frontend
