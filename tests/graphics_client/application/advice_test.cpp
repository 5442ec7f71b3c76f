#include "graphics_client/application/advice.h"

#include <gtest/gtest.h>

namespace haptics::advice_test {
namespace {

constexpr const char* kBall = R"([
  {"scene": "ball", "verdict": "use ball.ply", "replaces_mesh": true},
  {"scene": "ball", "triangles": 16384, "own_mesh": true, "advised": false},
  {"scene": "ball", "triangles": 5792, "own_mesh": false, "advised": true},
  {"scene": "ball", "triangles": 3000, "own_mesh": false, "advised": false})";

std::string adviceOnBall(const std::string& more) { return adviceIn(kBall + more + "]").value().at("ball"); }

TEST(Advice, SaysHowManyTrianglesFeelTheSame) { EXPECT_EQ(adviceOnBall(""), "16,384 triangles; 5,792 feel the same."); }

TEST(Advice, NamesFeaturesThatCannotBeFeltAndMotionsThatFail) {
  EXPECT_EQ(adviceOnBall(R"(, {"scene": "ball", "feature": "texture", "judged": true, "felt": false},
                             {"scene": "ball", "feature": "shading", "judged": true, "felt": true},
                             {"scene": "ball", "feature": "softness", "judged": false, "why": "it yields"},
                             {"scene": "ball", "motion": "stroked at 2 m/s", "pass": false},
                             {"scene": "ball", "motion": "pressed through", "pass": true})"),
            "16,384 triangles; 5,792 feel the same. Not felt: texture. The IHIP gets inside: stroked at 2 m/s.");
}

TEST(Advice, SaysWhyAMeshIsKept) {
  const auto advice =
      adviceIn(R"([{"scene": "box", "verdict": "keep; every triangle is needed", "replaces_mesh": false},
                                   {"scene": "all objects", "rate_Hz": 500}])");
  EXPECT_EQ(*advice, (std::map<std::string, std::string>{{"box", "keep; every triangle is needed."}}));
}

TEST(Advice, SaysHowManyPointsOfAToolFeelTheSame) {
  const std::string own = R"([{"scene": "probe", "own_spacing": true, "points": 1400, "advised": )";
  EXPECT_EQ(adviceIn(own + R"(false}, {"scene": "probe", "own_spacing": false, "points": 300, "advised": true}])")
                ->at("probe"),
            "1,400 points; 300 feel the same.");
  EXPECT_EQ(adviceIn(own + "true}]")->at("probe"), "Each of its points is needed.");
}

TEST(Advice, OfRecordsThatAreNoneIsRefused) {
  EXPECT_FALSE(adviceIn("[{}]"));
  EXPECT_FALSE(adviceIn(R"([{"scene": "ball", "verdict": 3}])"));
  EXPECT_FALSE(adviceIn(R"({"scene": )"));
}

}  // namespace
}  // namespace haptics::advice_test
