#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/common/temporary_folder.h"
#include "tests/eval/fuzz/contact_finding.h"
#include "tests/eval/fuzz/contact_scene.h"
#include "tests/eval/fuzz/edit_finding.h"
#include "tests/eval/fuzz/edit_scene.h"

namespace haptics::eval::fuzz_files_test {
namespace {

class FuzzFiles : public testing::Test {
 protected:
  const test::TemporaryFolder above;
  const std::filesystem::path folder = above / "finding";
};

TEST_F(FuzzFiles, KeepAMotionToTheBit) {
  ContactScene scene(3, {true, 1});
  ContactMotion motion{scene.meshes(), {scene.frame()}};
  for (int i = 0; i < 100; ++i) motion.frames.push_back(scene.next(scene.frame().hip));
  writeMotion(motion, folder);
  const ContactMotion read = readMotion(folder);
  ASSERT_EQ(read.frames.size(), motion.frames.size());
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    ASSERT_EQ(read.frames[i].hip, motion.frames[i].hip);
    ASSERT_EQ(read.frames[i].poses, motion.frames[i].poses);
  }
  ASSERT_EQ(read.meshes.size(), motion.meshes.size());
  for (std::size_t i = 0; i < read.meshes.size(); ++i) {
    EXPECT_EQ(read.meshes[i].vertices, motion.meshes[i].vertices);
    EXPECT_EQ(read.meshes[i].triangles, motion.meshes[i].triangles);
    EXPECT_EQ(read.meshes[i].missing, motion.meshes[i].missing);
  }
}

/// Every number that the step gets is kept: it feels the same.
TEST_F(FuzzFiles, KeepARunToTheBit) {
  for (const std::uint64_t seed : {4, 5, 6, 7}) {
    EditScene scene(seed);
    for (int i = 0; i < 3; ++i) static_cast<void>(scene.next());
    writeRun(scene.run(), folder);
    const EditRun read = readRun(folder);
    ASSERT_EQ(read.hips, scene.run().hips);
    EditDrive drive(read);
    EditDrive original(scene.run());
    for (const Vec3 hip : read.hips) ASSERT_EQ(drive.step(hip).force.written, original.step(hip).force.written);
    ASSERT_EQ(read.windows.size(), scene.run().windows.size());
    EXPECT_EQ(read.windows.back().edit, scene.run().windows.back().edit);
  }
}

TEST_F(FuzzFiles, NameTheLineThatIsWrong) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "edits.txt") << "rate_Hz 1000\nrate_Hz none\n";
  try {
    static_cast<void>(readRun(folder));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("edits.txt, line 2"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace haptics::eval::fuzz_files_test
