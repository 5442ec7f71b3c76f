#include "tests/eval/worst/play.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "tests/eval/instructions.h"

namespace haptics::eval {
namespace {

constexpr double kRoom_m = 0.06;
constexpr double kBetweenAdoptions_s = 0.2;

template <class Work>
double nsOf(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

Vec3 WorstHand::next(Vec3 ihip, double period_s) {
  left_s_ -= period_s;
  if (left_s_ <= 0) {
    const double* const gene = &genes_[kEach * target_];
    target_ = (target_ + 1) % kTargets;
    place_ = kRoom_m * (2.0 * Vec3(gene[0], gene[1], gene[2]) - 1.0);
    speed_m_per_s_ = 0.02 * std::pow(250.0, gene[3]);
    left_s_ = 0.02 * std::pow(10.0, gene[4]);
  }
  const Vec3 way = place_ - hip_;
  const double far_m = glm::length(way);
  const Vec3 wanted = far_m > 0 ? way * (std::min(speed_m_per_s_, far_m / 0.01) / far_m) : Vec3(0);
  velocity_m_per_s_ += (wanted - velocity_m_per_s_) * std::min(1.0, period_s / 0.005);
  hip_ += velocity_m_per_s_ * period_s;
  const double deepest_m = 0.002 + 0.02 * genes_.back();
  if (glm::distance(hip_, ihip) > deepest_m) hip_ += (ihip - hip_) * std::min(1.0, period_s / 0.02);
  return hip_;
}

Play::Play(std::shared_ptr<const ServoScene> scene, const Genome& genome, const Settings& settings)
    : settings_(settings), config_{.period_s = 1 / settings.rate_Hz, .maxForce_N = 1e9}, hand_(genome) {
  if (!settings.bounded) config_.work_per_s = std::numeric_limits<double>::infinity();
  auto other = std::make_shared<ServoScene>(*scene);
  other->revision = scene->revision + 1;
  other->objects.front().pose.position += Vec3(0.0005, 0.0003, 0.0002);
  other->objects.front().poseRevision = other->revision;
  scenes_ = {std::move(scene), std::move(other)};
  servo_ = std::make_unique<Servo>(Servo{HapticState(config_), CacheWarmer(config_), scenes_[0]});
  (void)adoptScene(*servo_->scene, servo_->state, 0);
}

std::int64_t Play::run(Servo& servo, Vec3 hip) const {
  const auto every = static_cast<std::uint64_t>(kBetweenAdoptions_s * settings_.rate_Hz);
  if (tick_ > 0 && tick_ % every == 0) {
    const auto& next = scenes_[tick_ / every % 2];
    if (adoptScene(*next, servo.state, tick_)) servo.scene = next;
  }
  servo.cacheWarmer(*servo.scene, servo.state);
  ForceResult felt;
  const StepInput input{tick_, 0, {hip, DeviceState::kReady}};
  computeForce(*servo.scene, servo.state, config_, input, felt, &servo.cacheWarmer.cache());
  servo.cacheWarmer.note(felt.contact.work.allowance);
  (void)finishStep(*servo.scene, servo.state, config_, input, felt);
  return servo.state.allowance.left() - felt.contact.work.allowance.left();
}

Play::Tick Play::tick() {
  hip_ = hand_.next(servo_->state.contact.ihip, config_.period_s);
  const std::uint64_t spentBefore = servo_->state.report.allowanceSpent;
  Tick tick;
  tick.ns = nsOf([&] { tick.units = run(*servo_, hip_); });
  tick.allowanceSpent = servo_->state.report.allowanceSpent != spentBefore;
  ++tick_;
  return tick;
}

Vec3 Play::hipOfNext() const {
  WorstHand hand = hand_;
  return hand.next(servo_->state.contact.ihip, config_.period_s);
}

double Play::timeOfNext_ns() {
  constexpr int kRuns = 5;
  const Vec3 hip = hipOfNext();
  const auto copy = std::make_unique<Servo>(*servo_);
  double shortest_ns = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRuns; ++i) {
    *copy = *servo_;
    shortest_ns = std::min(shortest_ns, nsOf([&] { (void)run(*copy, hip); }));
  }
  return shortest_ns;
}

Play::Cost Play::costOfNext() {
  const Vec3 hip = hipOfNext();
  const double ns = timeOfNext_ns();
  const auto copy = std::make_unique<Servo>(*servo_);
  return {countInstructions([&] { (void)run(*copy, hip); }), ns};
}

std::vector<double> playWith(Renderer& method, const ServoScene& scene, const Genome& genome, int ticks) {
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces;
  std::vector<Pose> poses;
  for (const ServoObject& object : scene.objects) {
    surfaces.push_back(object.surface);
    poses.push_back(object.pose);
  }
  method.begin(surfaces, poses, WorstHand::start());
  method.contactOnly();
  WorstHand hand(genome);
  Vec3 ihip = WorstHand::start();
  std::vector<double> durations_ns;
  for (int i = 0; i < ticks; ++i) {
    const Vec3 hip = hand.next(ihip, kPeriod_s);
    durations_ns.push_back(nsOf([&] { ihip = method.tick(poses, hip).ihip; }));
  }
  return durations_ns;
}

}  // namespace haptics::eval
