#include "common/importer/mesh_picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "common/mesh/generators.h"
#include "common/process/pending_file.h"
#include "tests/common/temporary_folder.h"

namespace haptics::mesh_picture_test {
namespace {

struct Seen {
  int grey = 0, orange = 0, blue = 0;
};

Seen seenOf(const TriMesh& mesh) {
  const test::TemporaryFolder folder;
  const auto written = writePicture(mesh, folder / "mesh.png");
  EXPECT_TRUE(written);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&image, (folder / "mesh.png").c_str()), 0) << image.message;
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0) << image.message;
  Seen seen;
  for (std::size_t i = 0; i < pixels.size(); i += 3) {
    const int red = pixels[i], green = pixels[i + 1], blue = pixels[i + 2];
    seen.orange += red > 2 * blue ? 1 : 0;
    seen.blue += blue > 2 * red ? 1 : 0;
    seen.grey += red < 250 && red <= 2 * blue && blue <= 2 * red && green > 0 ? 1 : 0;
  }
  return seen;
}

TEST(MeshPicture, ShowsFacesFromOutsideGreyTheirBacksOrangeAndOpenEdgesBlue) {
  TriMesh box = makeBox({0.1, 0.2, 0.3}, 1).value();
  const Seen closed = seenOf(box);
  EXPECT_GT(closed.grey, 50'000);
  EXPECT_EQ(closed.orange + closed.blue, 0);

  TriMesh open = box;
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 4);
  EXPECT_GT(seenOf(open).orange, 1'000);
  EXPECT_GT(seenOf(open).blue, 200);

  for (TriangleIndices& triangle : box.triangles) std::swap(triangle[1], triangle[2]);
  EXPECT_LT(seenOf(box).grey, closed.grey / 20);  // where orange meets the paper
}

TEST(MeshPicture, IsRefusedWhereItCannotBeWritten) {
  EXPECT_FALSE(writePicture(makeBox({0.1, 0.2, 0.3}, 1).value(), "/no such folder/mesh.png"));
}

TEST(CheckEnding, TakesItInAnyCaseOrNone) {
  for (const char* name : {"a.png", "a.b.PNG", "a", "/dev/stdout", "a.png/b"})
    EXPECT_TRUE(checkEnding(name, ".png")) << name;
  for (const char* name : {"a.jpg", "a.png.jpg", "a.", "a.pngs"}) EXPECT_FALSE(checkEnding(name, ".png")) << name;
}

}  // namespace
}  // namespace haptics::mesh_picture_test
