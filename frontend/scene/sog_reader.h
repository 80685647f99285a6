// SOG versions 1 and 2 (PlayCanvas): attributes as lossless WebP pictures beside a meta.json, in a folder or in a zip
// archive (.sog); and its streamed form, lod-meta.json over several of them.
#pragma once

#include <string>
#include <string_view>

#include "grtx/base/files_read.h"
#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// True when the bytes start like a zip archive.
bool is_sog_archive(std::string_view bytes);

/// True when the bytes are a JSON object that names what meta.json or lod-meta.json must have.
bool is_sog_meta(std::string_view bytes);

/// A scene as rows, and everything that it was read from, in the order of reading, for the scene's hash.
struct SogRows {
  RawRows rows;
  std::string content;
};

/// bytes: the archive. Throws Error{file, place, rule}; the place names the file inside.
SogRows read_sog_archive(std::string_view bytes, const std::string& file);

/// bytes: meta.json or lod-meta.json; pictures and units are beside `file`. lod: level of detail of a streamed scene, 0
/// the finest; what lod-meta.json names `environment` belongs to every level. files: takes those beside it.
/// Throws Error.
SogRows read_sog_meta(std::string_view bytes, unsigned lod, const std::string& file, FilesRead& files);

}  // namespace grtx::frontend
