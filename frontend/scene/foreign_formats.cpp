// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/foreign_formats.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "grtx/frontend/scene/raw_encoding.h"

namespace grtx::frontend {
namespace {

using namespace std::string_view_literals;

constexpr auto kZip = "PK\x03\x04"sv, kZipEnd = "PK\x05\x06"sv;

/// Name of a zip archive's first file; "" if the bytes are no archive.
std::string_view first_in_zip(std::string_view bytes) {
  constexpr std::size_t kNameLengthAt = 26, kNameAt = 30;  // of the local header
  if (!bytes.starts_with(kZip) || bytes.size() < kNameAt) return "";
  return bytes.substr(kNameAt, load<std::uint16_t>(bytes, kNameLengthAt));
}

bool holds(std::string_view bytes, std::string_view text) { return bytes.find(text) != std::string_view::npos; }

bool is_usd(std::string_view bytes) {  // the first file of a USDZ is the scene
  const std::string_view first = first_in_zip(bytes);
  return bytes.starts_with("PXR-USDC") || first.ends_with(".usdc") || first.ends_with(".usda") ||
         first.ends_with(".usd");
}
bool is_pytorch(std::string_view bytes) {  // an archive since version 1.6, a pickled number before
  return (bytes.starts_with(kZip) && holds(bytes, "/data.pkl"sv)) ||
         bytes.starts_with("\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9"sv);
}
bool is_numpy(std::string_view bytes) {
  return bytes.starts_with("\x93NUMPY"sv) || first_in_zip(bytes).ends_with(".npy");
}
bool is_rad(std::string_view bytes) { return bytes.starts_with("RAD0"); }
bool is_spx(std::string_view bytes) { return bytes.starts_with("spx\1"sv); }
bool is_packed(std::string_view bytes) {  // an archive of another kind than .sog, or a compressed file
  return (bytes.starts_with(kZip) && holds(bytes, kZipEnd) && !holds(bytes, "meta.json"sv)) ||
         bytes.starts_with(
             "\xfd"
             "7zXZ"sv) ||
         bytes.starts_with("7z\xbc\xaf\x27\x1c"sv) || bytes.starts_with("\x28\xb5\x2f\xfd"sv);
}
bool by_name_only(std::string_view) { return false; }

constexpr const char* kSplatTransform =
    "'splat-transform IN OUT.ply' makes a .ply of it (npm @playcanvas/splat-transform)";

struct ForeignFormat {
  const char* what;
  const char* step;
  bool (*is)(std::string_view);
  std::array<const char*, 4> extensions;
};
/// The first whose content fits counts.
constexpr std::array<ForeignFormat, 7> kFormats = {{
    {"a USD scene in binary",
     "'usdcat --flatten IN -o OUT.usda' makes text of it (OpenUSD), or the program that trained it exports a .ply",
     is_usd,
     {".usdz", ".usd", ".usdc"}},
    {"a PyTorch checkpoint",
     "let the program that trained it export a .ply, as 3DGRUT's export_ply or Nerfstudio's 'ns-export gaussian-splat' "
     "do",
     is_pytorch,
     {".pt", ".pth", ".ckpt"}},
    {"NumPy arrays", "let the program that wrote them export a .ply", is_numpy, {".npz", ".npy"}},
    {"LCC (XGRIDS)", kSplatTransform, by_name_only, {".lcc", ".lcc2"}},
    {"RAD (Spark)", "take the .ply or .spz that it was built from", is_rad, {".rad"}},
    {"SPX (Reall3dViewer)", "gsbox makes a .ply of it", is_spx, {".spx"}},
    {"a packed file without a .sog scene", "unpack it", is_packed, {".zip", ".7z", ".xz", ".zst"}},
}};

std::string said_of(const ForeignFormat& format) {
  return std::string(format.what) + ", which is not read: " + format.step;
}

}  // namespace

std::string foreign_content(std::string_view bytes) {
  const auto* const found = std::ranges::find_if(kFormats, [&](const ForeignFormat& f) { return f.is(bytes); });
  return found == kFormats.end() ? "" : "is " + said_of(*found);
}

std::string foreign_name(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension.empty()) return "";
  for (const ForeignFormat& format : kFormats) {
    for (const char* const known : format.extensions) {
      if (known != nullptr && extension == known) return "is named as " + said_of(format);
    }
  }
  return "";
}

}  // namespace grtx::frontend
