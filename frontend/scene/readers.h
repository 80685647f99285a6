// SPDX-License-Identifier: Apache-2.0
// Readers of scene formats: whether bytes are of a format, and their rows. Readers of .ply have headers of their own.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "grtx/base/files_read.h"
#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

// .splat: 32 bytes per Gaussian without a header; colour without view dependence.

/// The format has no magic number: true when the size is a multiple of 32 and most rows hold a plausible position and
/// scale.
bool is_splat(std::string_view bytes);

/// Precondition: is_splat(bytes).
RawRows read_splat(std::string_view bytes);

// .ksplat (GaussianSplats3D): sections of splats; at levels 1 and 2 positions are steps inside buckets.

/// True when the bytes begin as version 0.1 with counts that can be.
bool is_ksplat(std::string_view bytes);

/// Throws Error{file, place, rule}.
RawRows read_ksplat(std::string_view bytes, const std::string& file);

// USD text (.usda) with prims of type ParticleField3DGaussianSplat.

/// True when the bytes begin as USD text.
bool is_usda(std::string_view bytes);

/// All such prims of the file in turn, in their own axes: those of the trainer's .ply and cameras. Transforms of prims
/// are counted, not applied; files that it names are not opened. Throws Error{file, line, rule}.
RawRows read_usda(std::string_view bytes, const std::string& file);

// .spz (Niantic): quantised attributes in blocks; versions 1 to 3 in one gzip stream, version 4 in zstd streams.

/// Signs of the SH coefficients from k1 on when y and z change sign. The last one, of k24, follows the format's
/// library; the basis function itself is even in every axis.
inline constexpr std::array<float, 24> kSpzShSign{-1, -1, 1,                 //
                                                  -1, 1,  1,  -1, 1,         //
                                                  -1, 1,  -1, -1, 1, -1, 1,  //
                                                  -1, 1,  -1, 1,  1, -1, 1, -1, -1};

/// True when the bytes start like a gzip stream or like version 4.
bool is_spz(std::string_view bytes);

/// raw_axes: see SceneReadOptions::spz_raw_axes. Throws Error{file, place, rule}.
RawRows read_spz(std::string_view bytes, bool raw_axes, const std::string& file);

// SOG versions 1 and 2 (PlayCanvas): attributes as lossless WebP pictures beside a meta.json, in a folder or in a zip
// archive (.sog); and its streamed form, lod-meta.json over several of them.

/// True when the bytes start like a zip archive.
bool is_sog_archive(std::string_view bytes);

/// True when the bytes are a JSON object with the keys that meta.json or lod-meta.json must have.
bool is_sog_meta(std::string_view bytes);

/// A scene as rows, and all bytes that it was read from, in the order of reading, for the scene's hash.
struct SogRows {
  RawRows rows;
  std::string content;
};

/// bytes: the archive. Throws Error{file, place, rule}; `place` names the file inside.
SogRows read_sog_archive(std::string_view bytes, const std::string& file);

/// bytes: meta.json or lod-meta.json; pictures and units are beside `file`. lod: level of detail of a streamed scene, 0
/// the finest; the `environment` of lod-meta.json belongs to every level. files: those beside it are noted there.
/// Throws Error.
SogRows read_sog_meta(std::string_view bytes, unsigned lod, const std::string& file, FilesRead& files);

// glTF 2.0 whose points carry KHR_gaussian_splatting: binary (.glb), or JSON (.gltf) with its buffers inside or beside
// it.

/// True when the bytes start like a .glb.
bool is_glb(std::string_view bytes);

/// True when the bytes are a JSON object with an "asset", as in every .gltf. Test for a SOG's meta.json first: it may
/// have one, too.
bool is_gltf(std::string_view bytes);

/// A scene as rows, and the bytes of buffers in other files, in the order of reading, for the scene's hash.
struct GltfRows {
  RawRows rows;
  std::string beside;
};

/// bytes: a .glb or .gltf; buffers with a relative uri are beside `file`. Reads all splat primitives of the file's
/// scene in turn, into the axes of a .ply: glTF's y points up, so positions, rotations and harmonics are turned by half
/// a turn about z, as PlayCanvas' tools do. Nodes may move and scale uniformly; a rotating node is refused, because its
/// harmonics would have to be rotated. files: buffers beside it are noted. Throws Error{file, place, rule}.
GltfRows read_gltf(std::string_view bytes, const std::string& file, FilesRead& files);

}  // namespace grtx::frontend
