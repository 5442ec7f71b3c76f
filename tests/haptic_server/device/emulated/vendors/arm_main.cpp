// emulated_arm FILE TYPE: the hardware (a number of Force Dimension's, or 0: a Touch) behind an emulated vendor's library, as a process of its own, which goes on when the
// server is killed: a hand leads a mass round a circle, up and down through the middle of the workspace, against the force.
// Its firmware takes the force away when none was written for as long as its watchdog allows.
//
// A line on standard input, "FAULT MS", breaks it. Then it prints when that began, and when there was no force (CLOCK_MONOTONIC,
// ns). "watch 0" only prints the latter; "buttons BITS", "rest 1" keeps the hand in one place.
#include <poll.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iterator>

#include "common/clock/monotonic.h"
#include "common/maths/vec.h"
#include "tests/haptic_server/device/emulated/vendors/shared_arm.h"

namespace haptics {
namespace {

constexpr std::uint64_t kPeriod_ns = 500'000;
constexpr std::uint32_t kVelocity = 2, kWatchdog = 3;

struct Fault {
  const char* name;
  EmulatedArm::Shared<std::uint32_t> EmulatedArm::*place;
  std::uint32_t value = 1, ofTouch = 1;
};
constexpr Fault kFaults[]{{"unplugged", &EmulatedArm::unplugged}, {"error", &EmulatedArm::communication},
                          {"guard", &EmulatedArm::timeGuard},     {"nan", &EmulatedArm::notFinite},
                          {"jump", &EmulatedArm::jumped},         {"saturated", &EmulatedArm::saturated},
                          {"lost", &EmulatedArm::lost},           {"late", &EmulatedArm::blocks_us, 40'000, 12'000},
                          {"busy", &EmulatedArm::inUse},          {"exceeded", &EmulatedArm::forceOffCause}};

class Hardware {
 public:
  Hardware(EmulatedArm& arm, bool isTouch) : arm_(arm), isTouch_(isTouch) {}

  void tick(std::uint64_t now_ns) {
    const std::uint64_t watchdog_ns = arm_.watchdog_ns;
    if (arm_.forceOn && watchdog_ns != 0 && now_ns > arm_.written_ns + watchdog_ns) takeForceAway(kWatchdog);
    const bool isOn = arm_.forceOn && !arm_.unplugged && !(isTouch_ && arm_.forceOffCause);
    const Vec3 theirs = isOn ? Vec3(arm_.force[0].load(), arm_.force[1].load(), arm_.force[2].load()) : Vec3(0);
    move(isTouch_ ? Vec3(theirs.x, -theirs.z, theirs.y) : Vec3(theirs.y, -theirs.x, theirs.z),
         1e-9 * static_cast<double>(now_ns));
    if (watching_ && theirs == Vec3(0)) {
      std::printf("zero %llu\n", static_cast<unsigned long long>(now_ns));
      watching_ = false;
    }
    if (broken_ != nullptr && now_ns > until_ns_) {
      (arm_.*broken_->place) = 0;
      broken_ = nullptr;
    }
  }

  void hear(const char* line, std::uint64_t now_ns) {
    char word[16] = "";
    double value = 0;
    if (std::sscanf(line, "%15s %lf", word, &value) != 2) return;
    if (std::strcmp(word, "rest") == 0) resting_ = value != 0;
    if (std::strcmp(word, "buttons") == 0) arm_.buttons = static_cast<std::uint32_t>(value);
    if (std::strcmp(word, "watch") == 0) watching_ = true;
    for (const Fault& fault : kFaults) {
      if (std::strcmp(word, fault.name) == 0) {
        broken_ = &fault;
        until_ns_ = now_ns + static_cast<std::uint64_t>(value * 1e6);
        (arm_.*fault.place) = isTouch_ ? fault.ofTouch : fault.value;
        begin(word, now_ns);
      }
    }
    if (std::strcmp(word, "velocity") == 0) {
      takeForceAway(kVelocity);
      begin(word, now_ns);
    }
  }

 private:
  EmulatedArm& arm_;
  const bool isTouch_;
  Vec3 at_{0.02, 0, 0.02}, velocity_{0};
  const Fault* broken_ = nullptr;
  std::uint64_t until_ns_ = 0;
  bool watching_ = false, resting_ = false;

  void begin(const char* word, std::uint64_t now_ns) {
    std::printf("%s %llu\n", word, static_cast<unsigned long long>(now_ns));
    watching_ = true;
  }
  void takeForceAway(std::uint32_t cause) {
    arm_.forceOffCause = cause;
    arm_.forceOn = 0;
  }
  /// In the server's frame; the mass is drawn by a spring and a damper to the hand.
  void move(Vec3 force, double t) {
    constexpr double kMass = 0.25, kSpring = 400, kDamper = 6, kStep = 1e-9 * kPeriod_ns;
    const Vec3 hand = resting_
                          ? Vec3(0)
                          : Vec3(0.02 * std::cos(1.57 * t), 0.02 * std::sin(1.57 * t), 0.012 * std::cos(5 * t) - 0.002);
    velocity_ += kStep / kMass * (force + kSpring * (hand - at_) - kDamper * velocity_);
    at_ += kStep * velocity_;
    const auto theirs = [this](Vec3 v) { return isTouch_ ? 1e3 * Vec3(v.x, v.z, -v.y) : Vec3(-v.y, v.x, v.z); };
    const Vec3 position = theirs(at_), velocity = theirs(velocity_);
    for (std::size_t i = 0; i < 3; ++i) {
      arm_.position[i] = (&position.x)[i];
      arm_.velocity[i] = (&velocity.x)[i];
    }
  }
};

int run(const char* file, unsigned type) {
  EmulatedArm* const arm = mapArm(file);
  if (arm == nullptr) return 1;
  arm->type = type;
  arm->initialised = 1;
  arm->hasWrist = type == 34 || type == 104;
  arm->hasActiveWrist = type == 104;
  for (std::size_t i = 0; i < 9; ++i) arm->rotation[i] = i % 4 == 0 ? 1 : 0;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::setvbuf(stdin, nullptr, _IONBF, 0);  // poll() sees no line that a buffer holds
  Hardware hardware(*arm, type == 0);
  std::uint64_t next_ns = monotonicNow_ns();
  hardware.tick(next_ns);
  std::puts("ready");
  for (;;) {
    next_ns += kPeriod_ns;
    const timespec until{static_cast<time_t>(next_ns / 1'000'000'000), static_cast<long>(next_ns % 1'000'000'000)};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    const std::uint64_t now_ns = monotonicNow_ns();
    hardware.tick(now_ns);
    pollfd input{STDIN_FILENO, POLLIN, 0};
    char line[64];
    if (::poll(&input, 1, 0) != 1) continue;
    if (std::fgets(line, sizeof line, stdin) == nullptr) return 0;
    hardware.hear(line, now_ns);
  }
}

}  // namespace
}  // namespace haptics

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  return haptics::run(argv[1], static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10)));
}
