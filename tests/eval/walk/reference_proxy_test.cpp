#include "tests/eval/walk/reference_proxy.h"

#include <gtest/gtest.h>

#include "tests/eval/random.h"
#include "tests/eval/walk/cracked_block.h"

namespace haptics::eval {
namespace {

TEST(ReferenceProxy, GoesOnFromTheTipOfACrackOutsideOfTheBody) {
  const CrackedBlock block;
  const Vec3 tip(Vec3f(CrackedBlock::kTip));
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 hip = tip + Vec3(0, 0, -0.006) + random.direction() * 0.004;
    ReferenceProxy reference(block.soup);
    reference.resume(tip + random.direction() * 1e-12, hip);
    EXPECT_LT(glm::distance(reference.ihip(), tip), 1e-6) << "HIP at " << hip.x << ' ' << hip.y << ' ' << hip.z;
  }
}

}  // namespace
}  // namespace haptics::eval
