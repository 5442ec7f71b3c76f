#include "tests/haptic_server/device/emulated/falcon_model.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/device/usb/delta_kinematics.h"
#include "haptic_server/device/usb/falcon.h"

namespace haptics::test {
namespace {

using K = DeltaKinematics;

constexpr std::uint64_t kByteAt1500k_ns = 6'667, kByteAtLoader_ns = 70'000, kByteAtGreeting_ns = 1'000'000;
constexpr std::uint64_t kSlowness_ns = 12'000'000;
constexpr double kUnitsPerNm = Falcon::kMotorUnitsPerNm;
constexpr std::size_t kDamagedByte = 300;
constexpr unsigned kBlue = 4;
constexpr std::uint64_t kPullAndPush_ns = 300'000'000;

// Upright: x right, y away from the user, z up. The device's own: x right, y up, z towards the user.
Vec3 toDevice(Vec3 upright) { return K::kCentre + Vec3(upright.x, upright.z, -upright.y); }
Vec3 toUpright(Vec3 vector) { return {vector.x, -vector.z, vector.y}; }

}  // namespace

std::optional<EmulatedFault> emulatedFault(const std::string& name) {
  constexpr std::array kNames{"none", "shifted", "short", "silence", "stall",
                              "slow", "unhomed", "jump",  "glitch",  "firmware"};
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<EmulatedFault>(found - kNames.begin());
}

FalconModel::FalconModel(std::string serial) : serial_(std::move(serial)), mechanics_(*findDevicePreset("falcon")) {}

std::vector<std::uint8_t> FalconModel::descriptors() const {
  return {18,   1,    0x00, 0x02, 0,    0,    0,    8,    0x03,
          0x04, 0x48, 0xCB, 0x00, 0x06, 1,    2,    3,    1,   // 0403:cb48, full speed
          9,    2,    32,   0,    1,    1,    0,    0xA0, 45,  //
          9,    4,    0,    0,    2,    0xFF, 0xFF, 0xFF, 2,   //
          7,    5,    0x81, 2,    64,   0,    0,               // bulk IN
          7,    5,    0x02, 2,    64,   0,    0};              // bulk OUT
}

std::string FalconModel::stringDescriptor(int index) const {
  return index == 1 ? "Novint" : index == 2 ? "Falcon (emulated)" : index == 3 ? serial_ : "";
}

void FalconModel::powerCycle() {
  mode_ = Mode::kBoot;
  programmed_ = referenced_ = homingAsked_ = halted_ = false;
  baud_ = 0x4138;
  heard_.clear();
  said_.clear();
  motors_ = {};
  motor_N_ = Vec3(0);
  firmwareBytes_ = 0;
}

void FalconModel::setFault(EmulatedFault fault, std::uint64_t) {
  fault_ = fault;
  halted_ = fault == EmulatedFault::kStall;
  jump_ = fault == EmulatedFault::kJump ? 400 : fault == EmulatedFault::kGlitch ? 90 : 0;
}

int FalconModel::control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint64_t) {
  if (type != 0x40) return -EPIPE;
  switch (request) {
    case 0:
      if (value != 2) heard_.clear();
      if (value != 1) said_.clear();
      return 0;
    case 1: {
      const auto mask = static_cast<std::uint8_t>(value >> 8);
      const std::uint8_t before = lines_;
      lines_ = static_cast<std::uint8_t>((lines_ & ~mask) | (value & mask));
      const bool dtrRises = (mask & 1) != 0 && (before & 1) == 0 && (lines_ & 1) != 0;
      if (dtrRises && baud_ == 0x4138) mode_ = Mode::kBoot;  // DTR resets the controller
      return 0;
    }
    case 2:
    case 4:
      return 0;
    case 3:
      baud_ = value;
      if (baud_ == 0x0002) {
        if (mode_ == Mode::kLoader && firmwareBytes_ > 0) programmed_ = true;
        if (programmed_) mode_ = Mode::kRunning;
        heard_.clear();
      }
      return 0;
    case 6:
      eventChar_ = value;
      return 0;
    case 9:
      latency_ns_ = std::max(1, value & 0xFF) * 1'000'000ULL;
      return 0;
    default:
      return -EPIPE;
  }
}

int FalconModel::out(std::span<const std::uint8_t> bytes, std::uint64_t now_ns) {
  advance(now_ns);
  for (const std::uint8_t byte : bytes) takeByte(byte, now_ns);
  return static_cast<int>(bytes.size());
}

void FalconModel::say(std::span<const std::uint8_t> bytes, std::uint64_t ready_ns) {
  for (const std::uint8_t byte : bytes) said_.push_back({byte, ready_ns});
}

void FalconModel::takeByte(std::uint8_t byte, std::uint64_t now_ns) {
  switch (mode_) {
    case Mode::kBoot: {
      if (baud_ == 0x0015 && byte == 0x41) {
        mode_ = Mode::kLoader;
        firmwareBytes_ = 0;
        say(std::array<std::uint8_t, 1>{0x41}, now_ns + 2 * kByteAtLoader_ns);
        return;
      }
      if (baud_ != 0x4138) return;
      heard_.push_back(byte);
      if (heard_.size() > 3) heard_.pop_front();
      if (!std::ranges::equal(heard_, std::array<std::uint8_t, 3>{0x0A, 0x43, 0x0D})) return;
      heard_.clear();
      say(std::array<std::uint8_t, 4>{0x0A, 0x44, 0x2C, 0x0D}, now_ns + 4 * kByteAtGreeting_ns);
      return;
    }
    case Mode::kLoader: {
      const bool damage = fault_ == EmulatedFault::kFirmware && firmwareBytes_ == kDamagedByte;
      ++firmwareBytes_;
      say(std::array<std::uint8_t, 1>{static_cast<std::uint8_t>(byte ^ (damage ? 0x10 : 0))},
          now_ns + 62 * kByteAtLoader_ns);
      return;
    }
    case Mode::kRunning:
      if (heard_.empty() && byte != '<') return;
      heard_.push_back(byte);
      if (heard_.size() < 16) return;
      if (byte == '>') takeCommand(now_ns);
      heard_.clear();
  }
}

std::array<std::int16_t, 3> FalconModel::counts() const {
  const auto angles = K::anglesAt(toDevice(mechanics_.position()));
  if (!angles) return {};
  const Vec3 exact = falconCounts(*angles) + Vec3(referenced_ ? 0 : 700);  // unreferenced: from wherever it was
  return {static_cast<std::int16_t>(std::lround(exact.x) + jump_), static_cast<std::int16_t>(std::lround(exact.y)),
          static_cast<std::int16_t>(std::lround(exact.z))};
}

void FalconModel::takeCommand(std::uint64_t now_ns) {
  const auto nibble = [&](std::size_t i) { return static_cast<unsigned>(heard_[i] - 'A') & 0xF; };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    unsigned number = 0;
    for (std::size_t digit = 0; digit < 4; ++digit) number |= nibble(1 + 4 * axis + digit) << (4 * digit);
    motors_[axis] = static_cast<std::int16_t>(static_cast<std::uint16_t>(number));
  }
  homingAsked_ = (nibble(13) & 1) != 0;
  if (!homingAsked_) referenced_ = false;
  lights_ = nibble(13) & 0xE;
  if ((lights_ & kBlue) == 0) blueSince_ns_ = now_ns;
  if (now_ns - blueSince_ns_ > kPullAndPush_ns) referenced_ = true;
  // Motors turn against the angles: torque = -units, force = A^T torque.
  const Vec3 torque = -Vec3(motors_[0], motors_[1], motors_[2]) / kUnitsPerNm;
  motor_N_ = toUpright(torque * K::anglesByPosition(toDevice(mechanics_.position())));

  ++replies_;
  if (fault_ == EmulatedFault::kSilence) return;
  std::array<std::uint8_t, 16> reply;
  reply.front() = '<';
  reply.back() = '>';
  const auto at = counts();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto number = static_cast<std::uint16_t>(at[axis]);
    for (std::size_t digit = 0; digit < 4; ++digit) {
      reply[1 + 4 * axis + digit] = static_cast<std::uint8_t>('A' + (number >> (4 * digit) & 0xF));
    }
  }
  unsigned homed = saysHomed_.value_or(referenced_ && homingAsked_) ? 7 : 0;
  if (fault_ == EmulatedFault::kUnhomed) homed &= 5;
  reply[13] = static_cast<std::uint8_t>('A' + (homed << 4 | buttons_));
  reply[14] = 'A';
  const std::uint64_t slowness_ns = fault_ == EmulatedFault::kSlow ? kSlowness_ns : 0;
  const std::uint64_t ready_ns = now_ns + 32 * kByteAt1500k_ns + slowness_ns;
  const std::span<const std::uint8_t> whole(reply);
  if (fault_ == EmulatedFault::kShort) {
    say(whole.first(9), ready_ns);
  } else if (fault_ == EmulatedFault::kShifted) {
    constexpr std::array<std::uint8_t, 3> kNoise{0x00, 'C', 0xFF};
    say(kNoise, ready_ns);
    say(whole.first(13), ready_ns);
  } else {
    say(whole, ready_ns);
  }
}

std::optional<std::uint64_t> FalconModel::inReadyAt(std::uint64_t posted_ns) const {
  if (halted_) return posted_ns;
  const std::uint64_t empty_ns = std::max(posted_ns, lastIn_ns_ + latency_ns_);
  if (said_.empty()) return empty_ns;
  const std::uint64_t ready_ns = said_.front().ready_ns;
  const bool flush = said_.size() >= 62 || (eventChar_ & 0x100) != 0;
  return std::max(posted_ns, flush ? ready_ns : std::max(ready_ns, std::min(empty_ns, ready_ns + latency_ns_)));
}

int FalconModel::in(std::span<std::uint8_t> bytes, std::uint64_t now_ns) {
  lastIn_ns_ = now_ns;
  if (halted_) return -EPIPE;
  if (bytes.size() < 2) return -EOVERFLOW;
  bytes[0] = 0x01;
  bytes[1] = 0x60;
  std::size_t length = 2;
  while (length < std::min<std::size_t>(bytes.size(), 64) && !said_.empty() && said_.front().ready_ns <= now_ns) {
    bytes[length++] = said_.front().byte;
    said_.pop_front();
  }
  return static_cast<int>(length);
}

void FalconModel::advance(std::uint64_t now_ns) { mechanics_.advance(now_ns, motor_N_); }

}  // namespace haptics::test
