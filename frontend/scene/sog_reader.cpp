// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/readers.h"

#include <webp/decode.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/frontend/scene/file_beside.h"
#include "grtx/frontend/scene/raw_encoding.h"

namespace grtx::frontend {
namespace {

using nlohmann::json;

constexpr unsigned kLargestQuatTag = 252;  // alpha of a quaternion's texel: 252 + index of the omitted component
constexpr std::size_t kMostPaletteTexels = std::size_t{65536} * 15;  // 16-bit labels, SH degree 3
constexpr std::size_t kPaletteColumns = 64;                          // SH centroids per row of their picture
constexpr std::uint64_t kMostRows = 1U << 28;                        // 16384 x 16384 texels, the most that WebP holds
constexpr std::uint64_t kMostMetaBytes = std::uint64_t{256} << 20;
constexpr int kMostDepth = 64;  // depth of a lod-meta.json's tree

/// Returns the bytes of a file that a meta.json names.
using Load = std::function<std::string(const std::string& name)>;

json parse(std::string_view bytes, const std::string& file) {
  json document = parse_json<json>(bytes, file, "meta.json");
  if (!document.is_object()) throw Error(file, "meta.json", "must be a JSON object");
  return document;
}

// `place` by value: GCC 13 and later warn of a dangling reference for a reference parameter.
const json& member(const json& object, std::string_view place, const char* name, const std::string& file) {
  if (!object.is_object() || !object.contains(name)) throw Error(file, std::string(place) + name, "is missing");
  return object.at(name);
}

std::uint64_t whole(const json& value, std::uint64_t most, const std::string& place, const std::string& file) {
  if (!value.is_number_integer() || value < 0 || value > most) {
    throw Error(file, place, "must be a whole number from 0 to " + std::to_string(most));
  }
  return value.get<std::uint64_t>();
}

std::vector<double> numbers(const json& value, std::size_t count, const std::string& place, const std::string& file) {
  const std::string rule = "must be a list of " + std::to_string(count) + " finite numbers";
  if (!value.is_array() || value.size() != count) throw Error(file, place, rule);
  std::vector<double> list;
  for (const json& entry : value) {
    if (!entry.is_number() || !std::isfinite(entry.get<double>())) throw Error(file, place, rule);
    list.push_back(entry.get<double>());
  }
  return list;
}

std::vector<std::string> names(const json& part, const char* key, std::size_t count, const std::string& file) {
  const std::string place = std::string(key) + ".files";
  const json& value = member(part, std::string(key) + ".", "files", file);
  std::vector<std::string> list;
  if (value.is_array()) {
    for (const json& entry : value) {
      if (entry.is_string()) list.push_back(entry.get<std::string>());
    }
  }
  if (list.size() != count) throw Error(file, place, "must be a list of " + std::to_string(count) + " file names");
  return list;
}

/// A picture; decoded: RGBA, row after row.
struct Picture {
  std::string bytes, name;  ///< as in the file
  std::size_t width = 0, height = 0;
  std::unique_ptr<std::uint8_t, void (*)(void*)> rgba{nullptr, WebPFree};

  std::size_t texels() const { return width * height; }
  const std::uint8_t* texel(std::size_t i) const { return rgba.get() + i * 4; }
};

/// Most texels that a picture of `count` Gaussians may have.
constexpr std::size_t most_texels(std::size_t count) { return count * 4 + 65536; }

Picture undecoded(const Load& load, const std::string& name, std::size_t least, const std::string& file,
                  std::size_t most) {
  Picture picture{load(name), name};
  int width = 0, height = 0;
  const auto* data = reinterpret_cast<const std::uint8_t*>(picture.bytes.data());
  if (WebPGetInfo(data, picture.bytes.size(), &width, &height) == 0) throw Error(file, name, "is no WebP picture");
  picture.width = static_cast<std::size_t>(width);
  picture.height = static_cast<std::size_t>(height);
  // Writers make pictures nearly square; without a limit a small file could claim a gigabyte.
  if (picture.texels() < least || picture.texels() > most) {
    throw Error(file, name,
                "has " + std::to_string(picture.texels()) + " texels; must have " + std::to_string(least) + " to " +
                    std::to_string(most));
  }
  return picture;
}

void decode(Picture& picture, const std::string& file) {
  int width = 0, height = 0;
  const auto* data = reinterpret_cast<const std::uint8_t*>(picture.bytes.data());
  picture.rgba.reset(WebPDecodeRGBA(data, picture.bytes.size(), &width, &height));
  if (picture.rgba == nullptr) throw Error(file, picture.name, "is a damaged WebP picture");
  picture.bytes = {};
}

Picture picture(const Load& load, const std::string& name, std::size_t least, const std::string& file,
                std::size_t most = 0) {
  Picture picture = undecoded(load, name, least, file, most == 0 ? most_texels(least) : most);
  decode(picture, file);
  return picture;
}

/// Pictures of one colour compress to almost nothing, so kilobytes could claim gigabytes of rows. In a real scene the
/// low bytes of means are noise, at least a byte for each.
void check_claim(const Picture& lower, const Picture& upper, std::size_t count, const std::string& file) {
  constexpr std::size_t kMostAByte = 64, kAlways = 65536;
  const std::size_t bytes = lower.bytes.size() + upper.bytes.size();
  if (count > kAlways && count / kMostAByte > bytes) {
    throw Error(file, lower.name,
                "cannot hold " + std::to_string(count) + " Gaussians in " + std::to_string(bytes) +
                    " bytes together with " + upper.name);
  }
}

/// The other three components, in the order w x y z, are (byte / 255 * 2 - 1) / sqrt 2; the one left out is the
/// largest, positive.
std::array<float, 4> rotation(const std::uint8_t* texel) {
  if (texel[3] < kLargestQuatTag) return {0.0f, 0.0f, 0.0f, 0.0f};  // dropped as a zero quaternion
  const std::size_t largest = texel[3] - kLargestQuatTag;
  std::array<float, 4> wxyz{};
  double squares = 0.0;
  for (std::size_t c = 0, from = 0; c < 4; ++c) {
    if (c == largest) continue;
    const double value = (texel[from++] / 255.0 * 2.0 - 1.0) / std::numbers::sqrt2;
    wxyz[c] = static_cast<float>(value);
    squares += value * value;
  }
  wxyz[largest] = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - squares)));
  return wxyz;
}

void read_means(const json& means, const Load& load, const std::string& file, RawRows& rows, std::size_t count) {
  const std::vector<double> low = numbers(member(means, "means.", "mins", file), 3, "means.mins", file);
  const std::vector<double> high = numbers(member(means, "means.", "maxs", file), 3, "means.maxs", file);
  const std::vector<std::string> files = names(means, "means", 2, file);
  Picture lower = undecoded(load, files[0], count, file, most_texels(count)),
          upper = undecoded(load, files[1], count, file, most_texels(count));
  check_claim(lower, upper, count, file);
  decode(lower, file);
  decode(upper, file);
  std::array<std::vector<double>*, 3> axes{&rows.x, &rows.y, &rows.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    axes[axis]->reserve(axes[axis]->size() + count);
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned step = lower.texel(i)[axis] | static_cast<unsigned>(upper.texel(i)[axis]) << 8;
      const double logarithm = low[axis] + (high[axis] - low[axis]) * (step / 65535.0);
      // Stored is sign(x) ln(|x| + 1).
      axes[axis]->push_back(std::copysign(std::expm1(std::abs(logarithm)), logarithm));
    }
  }
}

/// The value of each byte. Version 2 lists them; version 1 gives the first and the last of 256 equal steps.
using Codebook = std::vector<double>;

Codebook steps(double low, double high) {
  Codebook codebook;
  for (int byte = 0; byte < 256; ++byte) codebook.push_back(low + (high - low) * (byte / 255.0));
  return codebook;
}

/// The codebook of each channel of a picture.
std::vector<Codebook> codebooks(const json& part, const char* key, std::size_t channels, unsigned version,
                                const std::string& file) {
  const std::string place = std::string(key) + ".";
  const auto list = [&](const char* name, std::size_t count) {
    return numbers(member(part, place, name, file), count, place + name, file);
  };
  if (version == 2) return std::vector<Codebook>(channels, list("codebook", 256));
  const std::vector<double> low = list("mins", channels), high = list("maxs", channels);
  std::vector<Codebook> books;
  for (std::size_t c = 0; c < channels; ++c) books.push_back(steps(low[c], high[c]));
  return books;
}

/// Spherical harmonics beyond the constant: each Gaussian has a label, which selects a palette entry, whose bytes
/// select values of a code book.
struct Harmonics {
  unsigned degree = 0;
  std::size_t coefficients = 0;  ///< without the constant
  Codebook codebook;
  Picture palette, labels;
  std::size_t entries = 0;
};

constexpr std::size_t coefficients_of(unsigned degree) { return std::size_t{degree + 1} * (degree + 1) - 1; }

/// Version 1 tells degree and entries only by the palette's size, and has numbers where version 2 has lists.
void read_palette_of_version_1(const json& part, const Load& load, const std::string& name, const std::string& file,
                               Harmonics& harmonics) {
  if (part.value("quantization", json(8)) != 8) throw Error(file, "shN.quantization", "must be 8");
  const auto number = [&](const char* key) {
    return numbers(json::array({member(part, "shN.", key, file)}), 1, std::string("shN.") + key, file).front();
  };
  harmonics.codebook = steps(number("mins"), number("maxs"));
  harmonics.palette = picture(load, name, 1, file, kMostPaletteTexels);
  while (harmonics.degree < 3 && harmonics.palette.width != kPaletteColumns * harmonics.coefficients)
    harmonics.coefficients = coefficients_of(++harmonics.degree);
  if (harmonics.palette.width != kPaletteColumns * harmonics.coefficients)
    throw Error(file, name, "must be 192, 512 or 960 texels wide");
  harmonics.entries = harmonics.palette.height * kPaletteColumns;
}

Harmonics read_harmonics(const json& meta, const Load& load, unsigned version, const std::string& file,
                         std::size_t count) {
  Harmonics harmonics;
  if (!meta.contains("shN")) return harmonics;
  const json& part = meta.at("shN");
  const std::vector<std::string> files = names(part, "shN", 2, file);
  if (version == 1) {
    read_palette_of_version_1(part, load, files[0], file, harmonics);
  } else {
    harmonics.degree = static_cast<unsigned>(whole(member(part, "shN.", "bands", file), 3, "shN.bands", file));
    if (harmonics.degree == 0) return harmonics;
    harmonics.coefficients = coefficients_of(harmonics.degree);
    harmonics.entries = whole(member(part, "shN.", "count", file), 65536, "shN.count", file);
    harmonics.codebook = codebooks(part, "shN", 1, version, file).front();
    harmonics.palette = picture(load, files[0], 1, file, kMostPaletteTexels);
  }
  if (harmonics.palette.width != kPaletteColumns * harmonics.coefficients) {
    throw Error(file, files[0],
                "must be " + std::to_string(kPaletteColumns * harmonics.coefficients) + " texels wide for degree " +
                    std::to_string(harmonics.degree));
  }
  if (harmonics.entries > harmonics.palette.height * kPaletteColumns) {
    throw Error(file, files[0], "has too few rows for shN.count");
  }
  harmonics.labels = undecoded(load, files[1], count, file, most_texels(count));
  return harmonics;
}

std::size_t count_of(const json& meta, const json& means, unsigned version, const std::string& file) {
  if (version == 2) return whole(member(meta, "", "count", file), kMostRows, "count", file);
  const json& shape = member(means, "means.", "shape", file);
  return whole(shape.is_array() && !shape.empty() ? shape.front() : json(), kMostRows, "means.shape", file);
}

/// Appends a unit's rows. All units of a scene have the degree of the first.
void read_unit(const json& meta, const Load& load, const std::string& file, RawRows& rows) {
  const unsigned version = meta.contains("version") ? 2 : 1;
  if (version == 2 && meta.at("version") != 2) throw Error(file, "version", "must be 2, or not there: version 1");
  const json& means = member(meta, "", "means", file);
  const json& scales = member(meta, "", "scales", file);
  const json& quats = member(meta, "", "quats", file);
  const json& sh0 = member(meta, "", "sh0", file);
  const std::size_t count = count_of(meta, means, version, file);
  const std::vector<Codebook> scale_of = codebooks(scales, "scales", 3, version, file);
  std::vector<Codebook> colour_of = codebooks(sh0, "sh0", 4, version, file);
  if (version == 2) {  // alpha is the opacity itself
    for (std::size_t byte = 0; byte < 256; ++byte) colour_of[3][byte] = logit_of(static_cast<double>(byte) / 255.0);
  }
  Harmonics harmonics = read_harmonics(meta, load, version, file, count);
  const bool first = rows.x.empty();
  if (first) rows.sh_degree = harmonics.degree;
  if (rows.sh_degree != harmonics.degree) throw Error(file, "shN.bands", "must be the same in all parts of a scene");
  if (count == 0) return;
  rows.require_memory_for(count, file);

  read_means(means, load, file, rows, count);
  if (harmonics.coefficients != 0) decode(harmonics.labels, file);
  const Picture scale = picture(load, names(scales, "scales", 1, file)[0], count, file);
  const Picture quat = picture(load, names(quats, "quats", 1, file)[0], count, file);
  const Picture colour = picture(load, names(sh0, "sh0", 1, file)[0], count, file);
  const std::size_t all = rows.x.size();
  rows.log_scale.reserve(all * 3);
  rows.rotation.reserve(all * 4);
  rows.opacity_logit.reserve(all);
  rows.sh.reserve(all * (harmonics.coefficients + 1) * 3);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows.log_scale.push_back(static_cast<float>(scale_of[axis][scale.texel(i)[axis]]));
    for (const float component : rotation(quat.texel(i))) rows.rotation.push_back(component);
    rows.opacity_logit.push_back(static_cast<float>(colour_of[3][colour.texel(i)[3]]));
    for (std::size_t c = 0; c < 3; ++c) rows.sh.push_back(static_cast<float>(colour_of[c][colour.texel(i)[c]]));
    if (harmonics.coefficients == 0) continue;
    const std::size_t label = harmonics.labels.texel(i)[0] | std::size_t{harmonics.labels.texel(i)[1]} << 8;
    if (label >= harmonics.entries) {
      throw Error(file, "Gaussian " + std::to_string(i),
                  "its SH label must be below " + std::to_string(harmonics.entries));
    }
    const std::size_t begin =
        label / kPaletteColumns * harmonics.palette.width + label % kPaletteColumns * harmonics.coefficients;
    for (std::size_t k = 0; k < harmonics.coefficients; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        rows.sh.push_back(static_cast<float>(harmonics.codebook[harmonics.palette.texel(begin + k)[c]]));
      }
    }
  }
}

Load beside(const std::string& file, std::string& content, FilesRead& files) {
  return [file, &content, &files](const std::string& name) {
    std::string bytes = read_beside(file, name, files);
    content += bytes;
    return bytes;
  };
}

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct CloseEntry {
  void operator()(zip_file_t* entry) const { zip_fclose(entry); }
};

class Archive {
 public:
  Archive(std::string_view bytes, const std::string& file) : file_(file) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    if (source != nullptr) archive_.reset(zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error));
    if (archive_ == nullptr) {
      if (zip_error_code_zip(&error) == ZIP_ER_MEMORY) throw std::bad_alloc();
      const std::string reason = zip_error_strerror(&error);
      zip_source_free(source);
      zip_error_fini(&error);
      throw Error(file_, "", "is a damaged zip archive: " + reason);
    }
    zip_error_fini(&error);
  }

  std::string read(const std::string& name) const {
    zip_stat_t stat;
    if (zip_stat(archive_.get(), name.c_str(), 0, &stat) != 0) throw Error(file_, name, "is not in the archive");
    if (stat.size > kMostMetaBytes) throw Error(file_, name, "is larger than 256 MiB");
    const std::unique_ptr<zip_file_t, CloseEntry> entry(zip_fopen(archive_.get(), name.c_str(), 0));
    if (entry == nullptr) throw Error(file_, name, "cannot be unpacked");
    std::string bytes;  // grows with the actual output, not with the claimed size
    std::vector<char> piece(1 << 16);
    for (;;) {
      const zip_int64_t got = zip_fread(entry.get(), piece.data(), piece.size());
      if (got < 0) throw Error(file_, name, "cannot be unpacked: it is damaged");
      if (got == 0) break;
      bytes.append(piece.data(), static_cast<std::size_t>(got));
      if (bytes.size() > kMostMetaBytes) throw Error(file_, name, "is larger than 256 MiB");
    }
    if (bytes.size() != stat.size) throw Error(file_, name, "is cut off");
    return bytes;
  }

 private:
  std::string file_;
  std::unique_ptr<zip_t, CloseArchive> archive_;
};

/// Reads the unit in an archive.
void read_archive(std::string_view bytes, const std::string& file, RawRows& rows) {
  const Archive archive(bytes, file);
  const Load load = [&](const std::string& name) { return archive.read(name); };
  read_unit(parse(archive.read("meta.json"), file), load, file, rows);
}

/// Units that hold a level, with their number of Gaussians in it: file -> count.
void collect_level(const json& node, const std::string& level, std::size_t files, int depth, const std::string& file,
                   std::map<std::size_t, std::uint64_t>& units) {
  if (!node.is_object() || depth > kMostDepth) throw Error(file, "tree", "must be nodes, at most 64 deep");
  if (const json lods = node.value("lods", json()); lods.is_object() && lods.contains(level)) {
    const json& reference = lods.at(level);
    const std::size_t unit =
        whole(member(reference, "lods.", "file", file), std::numeric_limits<int>::max(), "lods.file", file);
    if (unit >= files) throw Error(file, "lods.file", "must be below " + std::to_string(files));
    units[unit] += whole(member(reference, "lods.", "count", file), kMostRows, "lods.count", file);
  }
  const json children = node.value("children", json());
  if (children.is_array()) {
    for (const json& child : children) collect_level(child, level, files, depth + 1, file, units);
  }
}

void read_streamed(const json& meta, unsigned lod, const std::string& file, SogRows& scene, FilesRead& files) {
  const std::uint64_t levels = whole(meta.at("lodLevels"), 64, "lodLevels", file);
  if (lod >= levels)
    throw Error(file, "lodLevels",
                "has " + std::to_string(levels) + " levels of detail, 0 the finest; not " + std::to_string(lod));
  const json& listed = member(meta, "", "filenames", file);
  constexpr auto is_name = [](const json& name) { return name.is_string(); };
  if (!listed.is_array() || !std::all_of(listed.begin(), listed.end(), is_name))
    throw Error(file, "filenames", "must be a list of file names");
  std::map<std::size_t, std::uint64_t> units;
  collect_level(member(meta, "", "tree", file), std::to_string(lod), listed.size(), 0, file, units);
  const Load load = beside(file, scene.content, files);
  const auto read = [&](const std::string& name) {
    const std::string path = (std::filesystem::path(file).parent_path() / name).string();
    const std::string unit = load(name);
    if (is_sog_archive(unit)) {
      read_archive(unit, path, scene.rows);
    } else {
      read_unit(parse(unit, path), beside(path, scene.content, files), path, scene.rows);
    }
  };
  // Writers use null for none.
  if (const json environment = meta.value("environment", json()); environment.is_string()) {
    read(environment);
  } else if (!environment.is_null()) {
    throw Error(file, "environment", "must be a file name or null");
  }
  for (const auto& [unit, count] : units) {
    const std::size_t before = scene.rows.x.size();
    read(listed.at(unit));
    if (scene.rows.x.size() - before != count) {
      throw Error(file, listed.at(unit).get<std::string>(),
                  "must hold the " + std::to_string(count) + " Gaussians that the tree says");
    }
  }
}

}  // namespace

bool is_sog_archive(std::string_view bytes) { return bytes.starts_with("PK\x03\x04"); }

bool is_sog_meta(std::string_view bytes) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  const auto names_one = [&](const char* key) { return bytes.find(key) != std::string_view::npos; };
  return first != std::string_view::npos && bytes[first] == '{' &&
         (names_one("\"means\"") || names_one("\"lodLevels\""));
}

SogRows read_sog_archive(std::string_view bytes, const std::string& file) {
  SogRows scene;
  scene.content = bytes;
  read_archive(bytes, file, scene.rows);
  return scene;
}

SogRows read_sog_meta(std::string_view bytes, unsigned lod, const std::string& file, FilesRead& files) {
  const json meta = parse(bytes, file);
  SogRows scene;
  scene.content = bytes;
  if (meta.contains("lodLevels")) {
    read_streamed(meta, lod, file, scene, files);
  } else {
    read_unit(meta, beside(file, scene.content, files), file, scene.rows);
  }
  return scene;
}

}  // namespace grtx::frontend
