// SPDX-License-Identifier: Apache-2.0
// Files of Gaussians in formats that are not read: the line names the format and the way out.
#include "grtx/frontend/scene/foreign_formats.h"

#include <gmock/gmock.h>

#include "grtx/base/error.h"
#include "grtx/frontend/scene/scene_io.h"
#include "temporary_folder.h"

namespace grtx::frontend {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A zip archive's begin: the local header of its first file.
std::string zip_of(const std::string& first, const std::string& content = "") {
  std::string bytes = std::string("PK\x03\x04", 4) + std::string(26, '\0') + first + content;
  bytes[26] = static_cast<char>(first.size());
  return bytes;
}

class ForeignFormats : public testing::Test {
 protected:
  std::string line_of(const std::string& name, const std::string& bytes) {
    const std::string path = folder_.write(name, bytes);
    try {
      (void)load_scene(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "read";
  }
  test::TemporaryFolder folder_;
};

TEST_F(ForeignFormats, AreMetaJsonThatIsNotInTheArchive) {
  for (const char* first : {"default.usda", "scene.usdc", "a/b.usd"}) {
    EXPECT_THAT(line_of("s.usdz", zip_of(first)),
                AllOf(HasSubstr("s.usdz: is a USD scene in binary"), HasSubstr("usdcat"), HasSubstr("exports a .ply")));
  }
  const std::string torch = zip_of("archive/data.pkl", "\x80\x02}q");
  for (const char* name : {"s.pt", "s.pth", "s.ckpt", "no_extension"}) {
    EXPECT_THAT(line_of(name, torch), AllOf(HasSubstr(": is a PyTorch checkpoint"), Not(HasSubstr("meta.json"))))
        << name;
  }
  EXPECT_THAT(line_of("s.npz", zip_of("means.npy")), HasSubstr(": is NumPy arrays"));
  EXPECT_THAT(line_of("s.zip", zip_of("point_cloud.ply", "PK\x05\x06")),
              HasSubstr(": is a packed file without a .sog scene, which is not read: unpack it"));
  EXPECT_THAT(line_of("s.sog", zip_of("meta.json")), Not(HasSubstr("which is not read")));  // damaged, but SOG
}

TEST_F(ForeignFormats, AreNamedByTheirFirstBytes) {
  EXPECT_THAT(line_of("b", "RAD0 and more"), HasSubstr("is RAD (Spark)"));
  EXPECT_THAT(line_of("c", "spx\1 and more"), HasSubstr("is SPX (Reall3dViewer)"));
  EXPECT_THAT(line_of("d", "PXR-USDC and more"), HasSubstr("is a USD scene in binary"));
  EXPECT_THAT(line_of("f",
                      "\xfd"
                      "7zXZ and more"),
              HasSubstr("unpack it"));
}

TEST_F(ForeignFormats, AreNamedByTheirNameWhereBytesTellNothing) {
  EXPECT_THAT(line_of("meta.lcc", R"({"version": "5.0", "totalSplats": 7})"),
              HasSubstr("is named as LCC (XGRIDS), which is not read"));
  EXPECT_THAT(line_of("s.CKPT", "something else"), HasSubstr("is named as a PyTorch checkpoint"));
  EXPECT_THAT(line_of("s.obj", "something else"), HasSubstr("its content is none of them"));
}

TEST_F(ForeignFormats, ZerosAreAnEmptyScene) {
  EXPECT_THAT(line_of("s.ksplat", std::string(4096, '\0')), HasSubstr("its content is none of them"));
  EXPECT_THAT(line_of("s.splat", std::string(4096, '\0')), HasSubstr("its content is none of them"));
}

}  // namespace
}  // namespace grtx::frontend
