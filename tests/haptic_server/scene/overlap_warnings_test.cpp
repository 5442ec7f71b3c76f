#include "haptic_server/scene/overlap_warnings.h"

#include <gmock/gmock.h>

#include "haptic_server/scene/sequencer.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::overlap_warnings_test {
namespace {

using namespace test;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr bool kFixed = true;

/// A cube of 100 mm.
Operation cube(std::string name, Vec3 position, bool fixed = false) {
  AddObject add{std::move(name), box(), {}, {}};
  add.pose.position = position;
  add.motion = MotionProperties{.mass_kg = 1, .fixed = fixed, .collision = CollisionProperties{}};
  return add;
}

class OverlapWarnings : public ::testing::Test {
 protected:
  /// Of overlaps, in the reply to an edit.
  std::vector<std::string> of(const Transaction& transaction) {
    const EditOutcome outcome = sequencer_.submit(1, ++seq_, transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) {
      ADD_FAILURE() << error->text();
      return {};
    }
    std::vector<std::string> warnings = std::get<Accepted>(outcome)->reports;
    std::erase_if(warnings, [](const std::string& line) { return line.find("inside") == std::string::npos; });
    return warnings;
  }

 private:
  BoxResolver resolver_;
  Sequencer sequencer_{1, resolver_};
  std::uint64_t seq_ = 0;
};

TEST_F(OverlapWarnings, SayNothingOfWhatLiesOnOrBesideAnother) {
  EXPECT_THAT(of(edit(cube("floor", {0, 0, 0}, kFixed), cube("a", {0, 0, 0.1}), cube("b", {0.1, 0, 0.1}))), IsEmpty());
}

TEST_F(OverlapWarnings, NameBothObjectsAndHowDeepTheyLieInEachOther) {
  const auto warnings = of(edit(cube("floor", {0, 0, 0}, kFixed), cube("a", {0.02, 0, 0.095}),  //
                                cube("b", {0.03, 0.01, 0.185})));
  EXPECT_THAT(warnings, SizeIs(2));
  EXPECT_THAT(warnings, Contains(AllOf(HasSubstr("a: warning: lies 5 mm inside floor"), HasSubstr("0.1 m/s"))));
  EXPECT_THAT(warnings, Contains(HasSubstr("a: warning: lies 10 mm inside b")));
}

TEST_F(OverlapWarnings, SayNothingOfWhatDoesNotMove) {
  EXPECT_THAT(of(edit(cube("floor", {0, 0, 0}, kFixed), cube("shelf", {0, 0, 0.05}, kFixed))), IsEmpty());
}

TEST_F(OverlapWarnings, TellOfWhatAnEditPutsIntoWhatStandsStill) {
  of(edit(cube("floor", {0, 0, 0}, kFixed), cube("a", {0, 0, 0.2})));
  EXPECT_THAT(of(edit(moveTo("a", {0.01, 0.02, 0.09}))), ElementsAre(HasSubstr("10 mm inside")));
  EXPECT_THAT(of(edit(SetMaterial{named("a"), {900.0, {}, {}}})), IsEmpty()) << "it was not put there by this edit";
}

TEST_F(OverlapWarnings, SayNothingOfWhatMayHaveMovedSince) {
  of(edit(cube("a", {0, 0, 0})));
  EXPECT_THAT(of(edit(cube("b", {0.01, 0.02, 0.09}))), IsEmpty());
}

TEST_F(OverlapWarnings, AreAFew) {
  Transaction pile;
  for (std::size_t i = 0; i < 20; ++i)
    pile.operations.push_back(cube(numbered("p", i), double(i) * Vec3(0.001, 0.0007, 0.0005)));
  EXPECT_THAT(of(pile), SizeIs(kMaxOverlapWarnings));
}

}  // namespace
}  // namespace haptics::overlap_warnings_test
