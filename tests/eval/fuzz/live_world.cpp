#include "tests/eval/fuzz/live_world.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/maths/rotation.h"
#include "common/wire/convert.h"
#include "haptic_server/servo/server_step_config.h"

namespace haptics::eval {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr SessionId kEditor = 1;
constexpr double kBuildEvery_s = 0.005;
constexpr double kGoals_m = 0.05;  // of the hand's goals
constexpr double kStatesPer_s = 2;

template <class T>
[[nodiscard]] const T& one(Random& random, std::span<const T> of) {
  return of[static_cast<std::size_t>(random.below(static_cast<int>(of.size())))];
}

[[nodiscard]] SimulationSettings simulationOf(const DevicePreset& preset, double rate_Hz, Random& random) {
  return {.device = preset, .hand = one(random, handPresets()), .period_s = 1 / rate_Hz};
}

}  // namespace

LiveSetup LiveSetup::drawnFrom(Random& random) {
  LiveSetup setup;
  constexpr std::array kRates{1000.0, 1000.0, 1000.0, 2000.0, 4000.0, 10'000.0};
  setup.rate_Hz = one(random, std::span<const double>(kRates));
  setup.stabilised = random.chance(0.7);
  setup.hands = random.chance(0.3) ? 2 : 1;
  setup.rise_s = random.chance(0.5) ? 0.5 : 0;
  for (DevicePreset& device : setup.device) device = one(random, devicePresets());
  setup.limits.period_s = 1 / setup.rate_Hz;
  setup.limits.stiffest_N_per_m = random.chance(0.8) ? std::exp(random.between(std::log(100), std::log(1e4))) : kNone;
  setup.limits.maxDamping_Ns_per_m = random.chance(0.8) ? random.between(0, 5) : kNone;
  setup.limits.stiffestTorsion_Nm_per_rad = random.chance(0.8) ? random.between(0.01, 2) : kNone;
  setup.limits.hands = static_cast<int>(setup.hands);
  return setup;
}

StepConfig LiveSetup::stepOf(const DeviceInfo& info) const {
  StepConfig config = serverStepConfig(info, rate_Hz, stabilised);
  config.rise_s = rise_s;
  return hands == 1 ? config : perHandConfig(config);
}

HandTarget WanderingHand::next(double dt_s, Vec3 /*felt_N*/) noexcept {
  left_s_ -= dt_s;
  if (left_s_ <= 0) {
    left_s_ = random_.between(0.02, 0.6);
    speed_m_per_s_ = random_.chance(0.25) ? 0 : std::exp(random_.between(std::log(0.01), std::log(1.0)));
    for (int i = 0; i < 3; ++i) goal_m_[i] = random_.between(-kGoals_m, kGoals_m);
    turn_rad_per_s_ = random_.between(-3, 3);
    axis_ = random_.direction();
  }
  const Vec3 way = goal_m_ - place_m_;
  const double length = glm::length(way), step = speed_m_per_s_ * dt_s;
  place_m_ = length > step ? place_m_ + way * (step / length) : goal_m_;
  return {place_m_, Vec3(0)};
}

Quat WanderingHand::nextRotation(double dt_s) noexcept {
  angle_rad_ += turn_rad_per_s_ * dt_s;
  return rotationBy(0.3 * std::sin(angle_rad_) * axis_);
}

FailingDevice::FailingDevice(const DevicePreset& preset, double rate_Hz, std::uint64_t seed)
    : hand_(seed),
      device_(
          [&] {
            Random random(seed + 1);
            return simulationOf(preset, rate_Hz, random);
          }(),
          hand_),
      random_(seed + 2) {}

DeviceReading FailingDevice::read(std::uint64_t tick) noexcept {
  DeviceReading reading = device_.read(tick);
  if (tick >= until_) {
    failure_ = random_.chance(2e-4) ? static_cast<Failure>(1 + random_.below(5)) : Failure::kNone;
    until_ = tick + 1 + (failure_ == Failure::kNone ? 0 : static_cast<std::uint64_t>(random_.below(300)));
  }
  switch (failure_) {
    case Failure::kNone:
      break;
    case Failure::kLost:
      reading.state = DeviceState::kStopped;
      break;
    case Failure::kNotFinite:
      reading.position.y = std::numeric_limits<double>::quiet_NaN();
      break;
    case Failure::kStale:
      reading.status.age_us = 6'000;
      break;
    case Failure::kNotHomed:
      reading.status.homed = false;
      break;
    case Failure::kJump:
      reading.position += Vec3(0.02, 0, 0);
      break;
  }
  return reading;
}

LiveWorld::LiveWorld(std::uint64_t seed, double duration_s, const std::filesystem::path& recording)
    : random_(seed),
      setup_(LiveSetup::drawnFrom(random_)),
      edits_(seed),
      end_(static_cast<std::uint64_t>(duration_s * setup_.rate_Hz)) {
  for (std::size_t hand = 0; hand < setup_.hands; ++hand)
    devices_.emplace_back(setup_.device[hand], setup_.rate_Hz, 10 * seed + 5 * hand);
  std::vector<StepConfig> steps;
  for (const FailingDevice& device : devices_) steps.push_back(setup_.stepOf(device.info()));
  const bool warms = random_.chance(0.3);  // takes two thirds of a tick's time, and changes no force
  loop_ = std::make_unique<ServoLoop>(devices_[0], mailbox_, steps[0], warms);
  if (setup_.hands > 1) loop_->addHand(devices_[1], steps[1]);
  ring_ = std::make_unique<FlightRing>(setup_.rate_Hz, setup_.hands);
  loop_->recordInto(*ring_);

  FlightRecorder::Options options;
  options.facts = {.server = "fuzz",
                   .stepSources = std::string(ownStepSources()),
                   .device = devices_[0].info().name,
                   .rate_Hz = setup_.rate_Hz,
                   .why = {},
                   .config = steps[0],
                   .limits = setup_.limits};
  if (setup_.hands > 1) options.facts.secondHand = HandFacts{devices_[1].info().name, steps[1]};
  options.record = recording;
  options.folder = recording;  // no folder: of faults, whose recordings nobody would play, none is made
  options.info = options.warning = [](const std::string&) {};
  options.ticksPerState = static_cast<std::uint64_t>(setup_.rate_Hz / kStatesPer_s);
  auto recorder = FlightRecorder::open(std::move(options), *ring_);
  if (!recorder) throw std::runtime_error(recorder.error().text());
  recorder_ = *std::move(recorder);

  scenes_ = std::make_unique<SceneService>(
      SceneService::Options{.assetFolders = {},
                            .makePlan = {},
                            .takeMotion = [this] { return loop_->hand().takeMotionForBuilder(); },
                            .device = setup_.limits,
                            .log = {},
                            .onServoScene =
                                [this](const ServoScene& scene, const std::vector<ServoObjectSource>& objects) {
                                  recorder_->onSceneBuilt(scene, objects);
                                },
                            .now_ns = [this] { return now_ns(); }},
      mailbox_);
}

std::uint64_t LiveWorld::now_ns() const noexcept {
  return static_cast<std::uint64_t>(static_cast<double>(tick_) * 1e9 / setup_.rate_Hz);
}

Result<void> LiveWorld::run() {
  loop_->runFlatOut(*this);
  recorder_->collect();
  return recorder_->stop();
}

void LiveWorld::edit() {
  auto transaction = fromWire(edits_.next(scenes_->history()->version));
  if (!transaction) return;
  const auto count = [this](const EditOutcome& outcome) {
    accepted_ += std::holds_alternative<std::shared_ptr<const AcceptedEdit>>(outcome) ? 1 : 0;
  };
  static_cast<void>(scenes_->submitEdit(kEditor, ++submitted_, *std::move(transaction), count));
}

ReplaySource::Next LiveWorld::next(Tick& tick) noexcept {
  if (tick_ >= end_) return Next::kEnd;
  if (tick_ >= editDue_) {
    edit();
    const double shortest_s = edits_.streams() ? 0.001 : 0.01, longest_s = edits_.streams() ? 0.03 : 1;
    editDue_ = tick_ + static_cast<std::uint64_t>(setup_.rate_Hz *
                                                  std::exp(random_.between(std::log(shortest_s), std::log(longest_s))));
    buildDue_ = tick_;
  }
  if (tick_ >= buildDue_) {
    buildDue_ = tick_ + static_cast<std::uint64_t>(std::ceil(kBuildEvery_s * setup_.rate_Hz));
    scenes_->executeAll();
    recorder_->collect();
  }
  if (random_.chance(1e-3)) tick_ += static_cast<std::uint64_t>(1 + random_.below(random_.chance(0.1) ? 200 : 20));
  tick = {tick_++, mailbox_.newest()};
  ++ran_;
  return Next::kTick;
}

}  // namespace haptics::eval
