#include "graphics_client/editing/object_warnings.h"

#include <gmock/gmock.h>

namespace haptics::object_warnings_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Warned : testing::Test {
  ObjectWarnings warnings;
  v1::ObjectState cup;

  Warned() {
    cup.set_name("cup");
    cup.set_stiffness_n_per_m(9000);
  }
  void reply(const std::vector<std::string>& report) {
    v1::Accepted accepted;
    *accepted.add_object() = cup;
    for (const std::string& line : report) accepted.add_report(line);
    warnings.add(accepted);
  }
};

TEST_F(Warned, HoldsTheWarningsOfAnObjectAndNoOtherWords) {
  reply({"cup: generated, 12 triangles", "cup: warning: too stiff", "cup-2: warning: too light",
         "cup: warning: rough: it is"});
  EXPECT_THAT(warnings.of("cup"), ElementsAre("too stiff", "rough: it is"));
  EXPECT_THAT(warnings.of("cup-2"), IsEmpty()) << "the reply has no such object";
  EXPECT_THAT(warnings.of("saucer"), IsEmpty());
}

TEST_F(Warned, KeepsThemWhenOnlyPoseOrColourChange) {
  reply({"cup: warning: too stiff"});
  cup.mutable_pose()->mutable_position()->set_x(1);
  cup.mutable_color()->set_red(1);
  cup.set_revision(8);
  reply({});
  EXPECT_THAT(warnings.of("cup"), ElementsAre("too stiff"));
}

TEST_F(Warned, DropsThemWhenWhatTheyAreOfChanges) {
  reply({"cup: warning: too stiff"});
  cup.set_stiffness_n_per_m(500);
  reply({});
  EXPECT_THAT(warnings.of("cup"), IsEmpty());
}

}  // namespace
}  // namespace haptics::object_warnings_test
