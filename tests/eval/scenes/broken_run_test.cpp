// A scene's judge sees a run that was broken on purpose: ours, its answers changed now and then, or its bodies' states.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

#include "haptic_server/engine/tool/tool_contact.h"
#include "tests/eval/exchange/recorder.h"
#include "tests/eval/methods.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/runtime_method.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval::broken_run_test {
namespace {

enum class Breakage { kNone, kSinks, kLetsGo, kKicks, kHolds, kNotFinite };
constexpr std::array kBreakages{Breakage::kSinks, Breakage::kLetsGo, Breakage::kKicks, Breakage::kHolds,
                                Breakage::kNotFinite};

class Broken final : public Renderer {
 public:
  Broken(std::unique_ptr<Renderer> method, Breakage breakage) : method_(std::move(method)), breakage_(breakage) {}

  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override {
    method_->begin(bodies, poses, hip);
  }
  void setSurfaceProperties(const FeltSurface& surface) override { method_->setSurfaceProperties(surface); }
  void place(Vec3 hip) override { method_->place(hip); }
  void edit(const EditedScene& scene, Vec3 hip) override { method_->edit(scene, hip); }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override { return broken(method_->tick(poses, hip), hip); }
  Felt drive(std::span<const Pose> samples, bool haveCome, Vec3 hip) override {
    return broken(method_->drive(samples, haveCome, hip), hip);
  }
  [[nodiscard]] std::vector<Dent> dents(std::size_t body) const override { return method_->dents(body); }
  [[nodiscard]] double highestBulge_m(std::size_t body) const override { return method_->highestBulge_m(body); }
  [[nodiscard]] bool turnsMirroredOver() const override { return method_->turnsMirroredOver(); }

 private:
  Felt broken(Felt felt, Vec3 hip) {
    constexpr int kEvery = 37, kHeld = 200;
    const Felt honest = felt;
    touched_ += felt.touching ? 1 : 0;
    const bool now = felt.touching && touched_ % kEvery == 0;
    switch (breakage_) {
      case Breakage::kNone:
        break;
      case Breakage::kSinks:  // by a tenth of the depth
        if (felt.touching) {
          felt.ihip += 0.1 * (hip - felt.ihip);
          felt.force_N *= 0.9;
        }
        break;
      case Breakage::kLetsGo:
        if (now) felt = {.ihip = hip};
        break;
      case Breakage::kKicks:
        if (now) felt.force_N += Vec3(0.5, 0.5, 0.5);
        break;
      case Breakage::kHolds:  // what it has let go of
        if (!felt.touching && last_.touching && held_++ < kHeld) {
          felt = last_;
          return felt;
        }
        held_ = 0;
        break;
      case Breakage::kNotFinite:
        if (now) felt.force_N.x = std::numeric_limits<double>::quiet_NaN();
        break;
    }
    if (felt.written_N && breakage_ != Breakage::kNone) felt.written_N = felt.force_N;
    last_ = honest;
    return felt;
  }

  std::unique_ptr<Renderer> method_;
  Breakage breakage_;
  int touched_ = 0, held_ = 0;
  Felt last_;
};

bool passes(const FailureScene& scene, Breakage breakage) {
  Broken method(findMethod(kOurs, methods()).make(), breakage);
  Random random = scene.random(1);
  return scene.run(method, random).pass;
}

/// Only where it is asked for.
bool takesLong(std::string_view scene) {
  constexpr std::array<std::string_view, 8> kLong{"S5", "S6", "S7", "S12", "S17", "S21", "S22", "S30"};
  return std::getenv("HAPTICS_LONG") == nullptr && std::ranges::find(kLong, scene) != kLong.end();
}

class Judges : public testing::TestWithParam<FailureScene> {};

TEST_P(Judges, SeeABrokenRun) {
  if (takesLong(GetParam().name)) GTEST_SKIP() << "HAPTICS_LONG is not set";
  const FailureScene& scene = GetParam();
  EXPECT_TRUE(std::ranges::any_of(kBreakages, [&](Breakage breakage) { return !passes(scene, breakage); }));
}

enum class WorldBreakage { kDrifts, kGains, kLosesMomentum };

/// Bodies that creep, or tell of more energy or less momentum than they had, a little more in each tick.
class BrokenWorld final : public BodyWorld {
 public:
  explicit BrokenWorld(WorldBreakage breakage) : breakage_(breakage) {}
  std::uint64_t add(const MovingSolid& solid, const Pose& pose, bool moves) override {
    return world_.add(solid, pose, moves);
  }
  [[nodiscard]] ServoObject& object(std::uint64_t id) override { return world_.object(id); }
  void publish() override { world_.publish(); }
  TelemetrySample tick(Vec3 hip) override {
    ++ticks_;
    return world_.tick(hip);
  }
  [[nodiscard]] const Pose& poseOf(std::uint64_t id) const override {
    pose_ = world_.poseOf(id);
    if (breakage_ == WorldBreakage::kDrifts) pose_.position.x += 1e-6 * ticks_;
    return pose_;
  }
  [[nodiscard]] const RigidState& stateOf(std::uint64_t id) const override {
    state_ = world_.stateOf(id);
    if (breakage_ == WorldBreakage::kLosesMomentum) state_.momentum_Ns *= 0.99;
    return state_;
  }
  [[nodiscard]] double energyOf(std::uint64_t id) const override {
    return world_.energyOf(id) * (breakage_ == WorldBreakage::kGains ? 1 + 1e-3 * ticks_ : 1);
  }
  [[nodiscard]] std::uint64_t waitedTicks() const override { return world_.waitedTicks(); }

 private:
  WorldBreakage breakage_;
  MovingWorld world_;
  int ticks_ = 0;
  mutable Pose pose_;
  mutable RigidState state_;
};

class WithBrokenWorld final : public RuntimeMethod {
 public:
  explicit WithBrokenWorld(WorldBreakage breakage) : breakage_(breakage) {}
  [[nodiscard]] std::unique_ptr<BodyWorld> makeBodyWorld() const override {
    return std::make_unique<BrokenWorld>(breakage_);
  }

 private:
  WorldBreakage breakage_;
};

class JudgesOfBodies : public testing::TestWithParam<std::pair<const char*, WorldBreakage>> {};

TEST_P(JudgesOfBodies, SeeABrokenRun) {
  const auto& [name, breakage] = GetParam();
  if (takesLong(name)) GTEST_SKIP() << "HAPTICS_LONG is not set";
  const auto* const scene = std::ranges::find(kFailureScenes, name, &FailureScene::name);
  WithBrokenWorld method(breakage);
  Random random = scene->random(1);
  EXPECT_FALSE(scene->run(method, random).pass);
}

INSTANTIATE_TEST_SUITE_P(
    OfScenes, JudgesOfBodies,
    testing::Values(std::pair("S26", WorldBreakage::kDrifts), std::pair("S27", WorldBreakage::kDrifts),
                    std::pair("S28", WorldBreakage::kLosesMomentum), std::pair("S30", WorldBreakage::kGains),
                    std::pair("S40", WorldBreakage::kDrifts), std::pair("P7", WorldBreakage::kDrifts),
                    std::pair("P8", WorldBreakage::kDrifts), std::pair("P9", WorldBreakage::kDrifts)),
    [](const auto& of) { return std::string(of.param.first); });

/// Now and then a kick, each larger than the one before, and a hand that is let go of.
int spoiltTicks = 0;
void spoilSample(TelemetrySample& sample) {
  if (sample.object == 0 || ++spoiltTicks % 37 != 0) return;
  sample.force.contact += Vec3(0.001 * spoiltTicks);
  sample.object = 0;
}

void sinkTool(ToolResult& result) { result.proxy.position -= Vec3(1e-6); }

class JudgesOfOurs : public testing::TestWithParam<const char*> {};

TEST_P(JudgesOfOurs, SeeABrokenRun) {
  if (takesLong(GetParam())) GTEST_SKIP() << "HAPTICS_LONG is not set";
  const auto* const scene = std::ranges::find(kFailureScenes, std::string_view(GetParam()), &FailureScene::name);
  spoiltTicks = 0;
  MovingWorld::spoils = spoilSample;
  spoilsTool = sinkTool;
  const auto method = findMethod(kOurs, methods()).make();
  Random random = scene->random(1);
  const bool passed = scene->run(*method, random).pass;
  MovingWorld::spoils = nullptr;
  spoilsTool = nullptr;
  EXPECT_FALSE(passed);
}

INSTANTIATE_TEST_SUITE_P(OfScenes, JudgesOfOurs, testing::Values("S18", "S19", "S20", "S23", "S24", "S25", "S29"),
                         [](const auto& of) { return std::string(of.param); });

std::vector<FailureScene> ledScenes() {
  std::vector<FailureScene> led;
  std::ranges::copy_if(kFailureScenes, std::back_inserter(led), [](const FailureScene& scene) {
    return isExchanged(scene.concern) || scene.concern == Concern::kSoftness;
  });
  return led;
}

INSTANTIATE_TEST_SUITE_P(OfScenes, Judges, testing::ValuesIn(ledScenes()),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace haptics::eval::broken_run_test
