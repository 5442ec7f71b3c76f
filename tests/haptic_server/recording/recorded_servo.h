#pragma once

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/maths/rotation.h"
#include "common/wire/convert.h"
#include "haptic_server/engine/step/tool_step.h"
#include "haptic_server/engine/step/two_hands.h"
#include "haptic_server/recording/flight_recorder.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/servo/scene_mailbox.h"
#include "tests/common/temporary_folder.h"

namespace haptics::test {

/// A slab with a texture that rubs, a shaded ball and, where asked for, a block that can be pushed or a cushion that
/// yields.
inline const std::string kScene = R"(
operations { add { name: "slab" mesh { box { size_m { x: 0.2 y: 0.2 z: 0.02 } segments: 8 } } pose { position { z: -0.01 } }
  material { friction { mu_static: 0.6 mu_dynamic: 0.4 variation: 0.3 field { grain { grain_m: 0.002 } } }
             texture { amplitude_m: 0.0003 field { noise { wavelength_m: 0.004 octaves: 2 } } } } } }
operations { add { name: "ball" mesh { sphere { radius_m: 0.02 segments: 8 } } pose { position { x: 0.03 z: 0.005 } }
  material { shading { crease_rad: 0.6 } } } })";
inline const std::string kBlock = R"(
operations { add { name: "block" mesh { box { size_m { x: 0.02 y: 0.02 z: 0.02 } } } pose { position { x: -0.035 z: 0.01 } }
  motion { mass_kg: 0.1 planes { normal { z: 1 } friction: 0.4 } } } })";
/// Two that meet, and one that stands still.
inline const std::string kBricks = R"(
operations { add { name: "left" mesh { box { size_m { x: 0.02 y: 0.02 z: 0.02 } } } pose { position { x: -0.035 z: 0.012 } }
  motion { mass_kg: 0.1 planes { normal { z: 1 } friction: 0.4 } collision {} } } }
operations { add { name: "right" mesh { sphere { radius_m: 0.01 segments: 12 } } pose { position { x: -0.034 z: 0.035 } }
  motion { mass_kg: 0.1 planes { normal { z: 1 } } collision {} } } }
operations { add { name: "wall" mesh { box { size_m { x: 0.02 y: 0.1 z: 0.04 } } } pose { position { x: -0.07 z: 0.02 } }
  motion { fixed: true collision { friction: 0.1 } } } })";
inline const std::string kTool = R"(
operations { add { name: "bar" mesh { box { size_m { x: 0.03 y: 0.01 z: 0.006 } } }
  motion { tool { spacing_m: 0.003 torsion_Nm_per_rad: 0.5 } } } })";
/// With something between its jaws.
inline const std::string kForceps = R"(
operations { add { name: "forceps" mesh { file: "forceps.obj" }
  motion { tool { spacing_m: 0.003 jaws { axis { y: -1 } reach { x: 1 } grip_Nm_per_rad: 0.2 } } } } }
operations { add { name: "bead" mesh { sphere { radius_m: 0.005 segments: 12 } }
  pose { position { x: 0.035 z: 0.03 } } } })";
inline const std::string kCushion = R"(
operations { add { name: "cushion" mesh { sphere { radius_m: 0.02 segments: 16 } } pose { position { x: -0.035 z: -0.008 } }
  deformation { softness { stiffness_N_per_m: 300 radius_m: 0.01 return_s: 0.2 } } } })";

inline Transaction transactionOf(const std::string& text) {
  return fromWire(parseSceneText(text, "test").value()).value();
}

inline std::string bytesOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A room, a servo in virtual time whose hand strokes slab, ball and block in turn, and the recorder beside it, as in the
/// server.
class RecordedServo {
 public:
  static constexpr double kRate_Hz = 1000;

  /// @param isChecked  The recorder checks the replay and writes no file.
  explicit RecordedServo(const std::string& scene = kScene, int hands = 1, bool isChecked = false)
      : hands_(hands), isChecked_(isChecked), recorder_(FlightRecorder::open(recorderOptions(), ring_).value()) {
    if (hands > 1) second_ = std::make_unique<HapticState>(config_);
    if (hands > 1) followFirstHand(*second_);
    if (!scene.empty()) apply(scene);
  }

  void apply(const std::string& text) { ASSERT_TRUE(sceneService_.loadStartScene(transactionOf(text))); }

  /// As a client edits.
  void submit(const std::string& text) {
    bool accepted = false;
    const auto reply = [&](const EditOutcome& outcome) {
      accepted = std::holds_alternative<std::shared_ptr<const AcceptedEdit>>(outcome);
    };
    ASSERT_TRUE(sceneService_.submitEdit(1, ++submitted_, transactionOf(text), reply));
    sceneService_.executeAll();
    ASSERT_TRUE(accepted);
  }

  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick({hand(), DeviceState::kReady, {}});
  }
  /// With the device turned to and fro.
  void runTurning(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const double t = 0.001 * static_cast<double>(tick_);
      tick({hand(), DeviceState::kReady, {}, rotationBy({0.2 * std::sin(3 * t), 0.3 * std::cos(2 * t), 0.1})});
    }
  }
  /// With the gripper opened and closed.
  void runGripping(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const double height_m = 0.03 + 0.002 * std::sin(0.01 * static_cast<double>(tick_));
      DeviceReading reading{Vec3(0, 0, height_m), DeviceState::kReady, {}};
      reading.gripper_rad = reading.handle.gripper_rad = 0.25 + 0.25 * std::cos(0.004 * static_cast<double>(tick_));
      reading.handle.measured = HandleReading::kGripper;
      tick(reading);
    }
  }
  /// With the device turned to and fro, and a button that grasps pressed now and then.
  void runGrasping(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const double t = 0.001 * static_cast<double>(tick_);
      DeviceReading reading{
          hand(), DeviceState::kReady, {}, rotationBy({0.2 * std::sin(3 * t), 0.3 * std::cos(2 * t), 0.1})};
      reading.status.set(HandAction::kGrasp, i % 700 >= 500);
      tick(reading);
    }
  }
  /// Of a device with buttons, a gripper, and what else is measured; the hand takes hold of its workspace now and then.
  void runClutching(int ticks) {
    Vec3 held(0);
    for (int i = 0; i < ticks; ++i) {
      DeviceReading reading{hand(), DeviceState::kReady, {}};
      reading.status.set(HandAction::kClutch, i % 400 >= 200);
      reading.status.set(HandAction::kMark, i % 4 == 0);
      reading.status.buttons = 1U << (tick_ % 32);
      if (!reading.status.does(HandAction::kClutch)) held = reading.position;
      reading.position = held;
      const auto measured = static_cast<double>(tick_);
      reading.handle = {{measured, 1, 2}, {3, -measured, 4}, 0.1 * measured, tick_ % 8};
      tick(reading);
    }
  }
  /// While a client adds something now and then.
  void runAdding(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      DeviceReading reading{hand(), DeviceState::kReady, {}};
      const auto number = static_cast<double>(tick_);
      if (i % 300 >= 100) reading.added = AddedWrench({{0.001 * number, -0.3, 0.2}, {0, 1e-6 * number, 0}});
      tick(reading);
    }
  }
  /// With the second hand there where the first will be a little later.
  void runBoth(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      tick({hand(), DeviceState::kReady, {}}, {hand(300) + Vec3(0, 0, 0.002), DeviceState::kReady, {}});
    }
  }
  void tick(const DeviceReading& reading, const DeviceReading& secondReading) {
    const std::uint64_t number = scene_->number, pending = next_ != nullptr ? next_->number : 0;
    const std::uint64_t secondNumber = secondScene_->number, secondPending = secondNext_ ? secondNext_->number : 0;
    ring_.beginTick(std::array{StateMoment{state_.get(), number, pending},
                               StateMoment{second_.get(), secondNumber, secondPending}});
    const ServoScene* newest = mailbox_.newest();
    if (newest != nullptr) next_ = secondNext_ = newest;
    if (next_ != nullptr && adoptScene(*next_, *state_, tick_)) scene_ = std::exchange(next_, nullptr);
    if (secondNext_ != nullptr && adoptScene(*secondNext_, *second_, tick_))
      secondScene_ = std::exchange(secondNext_, nullptr);
    if (next_ == nullptr && secondNext_ == nullptr) mailbox_.adopted();
    const StepInput input{tick_, 0, reading}, secondInput{tick_, 0, secondReading};
    ++tick_;
    ForceResult result, secondResult;
    computeForce(*scene_, *state_, config_, input, result);
    computeForce(*secondScene_, *second_, config_, secondInput, secondResult);
    finishSteps({*scene_, *state_, config_, input, result},
                {*secondScene_, *second_, config_, secondInput, secondResult}, last_, lastOfSecond_);
    const std::uint64_t given = newest != nullptr ? newest->number : 0;
    ring_.add(std::array{RecordedTick{input, given, last_.force.written, last_.fault, {}, {}},
                         RecordedTick{secondInput, given, lastOfSecond_.force.written, lastOfSecond_.fault, {}, {}}});
    contactTicks_ += last_.object != 0 && lastOfSecond_.object != 0 ? 1 : 0;
  }
  void tick(const DeviceReading& reading) {
    ring_.beginTick(std::array{StateMoment{state_.get(), scene_->number, next_ != nullptr ? next_->number : 0}});
    const auto twin = hasTwin_ ? stateFrom(stateImage(*state_), *scene_, config_).value() : nullptr;
    if (twin) {
      EXPECT_EQ(twin->denting.isHeldUp, state_->denting.isHeldUp);
    }
    const ServoScene* newest = mailbox_.newest();
    if (newest != nullptr) next_ = newest;
    if (next_ != nullptr && twin) static_cast<void>(adoptScene(*next_, *twin, tick_));
    if (next_ != nullptr && adoptScene(*next_, *state_, tick_)) {
      scene_ = std::exchange(next_, nullptr);
      mailbox_.adopted();
    }
    const StepInput input{tick_++, 0, reading};
    const Vec3* const added_N = reading.added.acts ? &reading.added.force_N : nullptr;
    last_ = hapticStep(*scene_, *state_, config_, input, added_N);
    if (twin) judge(hapticStep(*scene_, *twin, config_, input, added_N));
    contactTicks_ += last_.object != 0 ? 1 : 0;
    ring_.add(std::array{RecordedTick{input, newest != nullptr ? newest->number : 0, last_.force.written, last_.fault,
                                      writtenTorque_Nm(*state_, config_, reading.added), reading.handle, reading.added,
                                      writtenGrip_Nm(*state_)}});
  }
  /// From here on each tick is also computed from the image of the state before it.
  void computeTwice() { hasTwin_ = true; }
  void skip(int ticks) { tick_ += static_cast<std::uint64_t>(ticks); }

  /// What came of the check, finished.
  [[nodiscard]] ReplayCheck::Count check() {
    recorder_->start();
    EXPECT_TRUE(recorder_->stop());
    return recorder_->check()->count();
  }
  /// The recorder's, once it has stopped.
  [[nodiscard]] const std::string& warnings() const { return warnings_; }
  /// The file of every tick, finished.
  [[nodiscard]] std::string recording() {
    recorder_->start();
    EXPECT_TRUE(recorder_->stop());
    return bytesOf(folder_ / "all");
  }

  std::function<void()> onInfo;  ///< When the recorder says something; on its thread.
  [[nodiscard]] FlightRecorder& recorder() { return *recorder_; }
  [[nodiscard]] const FlightRing& ring() const { return ring_; }
  /// Descriptor of the scene journal's memory.
  [[nodiscard]] int journal() const { return journal_; }
  [[nodiscard]] const TelemetrySample& last() const { return last_; }
  [[nodiscard]] HapticState& state() const { return *state_; }
  [[nodiscard]] const ServoScene& scene() const { return *scene_; }
  [[nodiscard]] const StepConfig& config() const { return config_; }
  [[nodiscard]] std::uint64_t contactTicks() const { return contactTicks_; }
  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

 private:
  void judge(const TelemetrySample& again) const {
    EXPECT_EQ(again.force.written, last_.force.written) << "tick " << last_.tick;
    EXPECT_EQ(again.force.contact, last_.force.contact) << "tick " << last_.tick;
    EXPECT_EQ(again.ihip, last_.ihip) << "tick " << last_.tick;
    EXPECT_EQ(again.energyGiven_J, last_.energyGiven_J) << "tick " << last_.tick;
  }
  [[nodiscard]] Vec3 hand(std::uint64_t later = 0) const {
    const double t = 0.001 * static_cast<double>(tick_ + later);
    const double x = 0.05 * std::sin(1.7 * t);
    return {x, 0.004 * std::cos(2.3 * t), 0.006 * std::cos(4.1 * t) + 0.004};
  }

  [[nodiscard]] FlightRecorder::Options recorderOptions() {
    FlightRecorder::Options options;
    options.facts.server = "test";
    options.facts.stepSources = ownStepSources();
    options.facts.rate_Hz = kRate_Hz;
    options.facts.config = config_;
    options.facts.limits.hands = hands_;
    if (hands_ > 1) options.facts.secondHand = HandFacts{"second", config_};
    if (!isChecked_) options.record = folder_ / "all";
    options.checkReplay = isChecked_;
    options.folder = folder_ / "last";
    options.keepScenes = [this](int descriptor) { journal_ = descriptor; };
    options.info = [this](const std::string&) {
      if (onInfo) onInfo();
    };
    options.warning = [this](const std::string& text) { warnings_ += text + '\n'; };
    return options;
  }

  TemporaryFolder folder_;
  StepConfig config_{.period_s = 1 / kRate_Hz,
                     .maxForce_N = 3.3,
                     .positionStep_m = 5.5e-5,
                     .stableLateral_N_per_m = 900,
                     .observer = ObserverSettings{.mass_kg = 0.07,
                                                  .viscousFriction_Ns_per_m = 0.5,
                                                  .delay_s = 1.5e-3,
                                                  .bandwidth_Hz = 75,
                                                  .hardBandwidth_Hz = 200,
                                                  .softUpTo_N_per_m = 300,
                                                  .hardFrom_N_per_m = 1300},
                     .rotation = {.radius_m = 0.05,
                                  .maxTorque_Nm = 0.05,
                                  .observer = ObserverSettings{.mass_kg = 0.1, .viscousFriction_Ns_per_m = 0.5}},
                     .maxGrip_Nm = 0.1,
                     .rise_s = 0.5};
  int hands_;
  bool isChecked_;
  std::string warnings_;
  FlightRing ring_{kRate_Hz, static_cast<std::size_t>(hands_)};
  int journal_ = -1;
  std::unique_ptr<FlightRecorder> recorder_;
  SceneMailbox mailbox_;
  SceneService sceneService_{{.assetFolders = {SCENES_FOLDER},
                              .makePlan = {},
                              .device = {.hands = hands_},
                              .log = {},
                              .onServoScene =
                                  [this](const ServoScene& scene, const std::vector<ServoObjectSource>& objects) {
                                    recorder_->onSceneBuilt(scene, objects);
                                  }},
                             mailbox_};
  std::unique_ptr<HapticState> second_;  // of a second hand
  TelemetrySample lastOfSecond_;
  ServoScene emptyForSecond_;
  const ServoScene* secondScene_ = &emptyForSecond_;
  const ServoScene* secondNext_ = nullptr;
  std::unique_ptr<HapticState> state_ = std::make_unique<HapticState>(config_);
  ServoScene empty_;
  const ServoScene* scene_ = &empty_;
  const ServoScene* next_ = nullptr;
  std::uint64_t tick_ = 0;
  std::uint64_t contactTicks_ = 0, submitted_ = 0;
  bool hasTwin_ = false;
  TelemetrySample last_;
};

}  // namespace haptics::test
