#include "tests/eval/teleoperation/couplings.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "graphics_client/client/teleoperation.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {
namespace {

TeleoperationPacket::Vector listed(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 vectorOf(const TeleoperationPacket::Vector& v) { return {v[0], v[1], v[2]}; }

template <class Packet>
class LinedCoupling : public Coupling {
 public:
  [[nodiscard]] Packets packets() const override { return {forth_.sent(), back_.sent()}; }

 protected:
  explicit LinedCoupling(const CoupledEnds& ends)
      : forth_(ends.line, 2 * ends.seed), back_(ends.line, 2 * ends.seed + 1) {}

  Line<Packet> forth_, back_;
  double now_s_ = 0;
};

/// graphics_client/client/teleoperation.h
class PassiveCoupling final : public LinedCoupling<TeleoperationPacket> {
 public:
  explicit PassiveCoupling(const CoupledEnds& ends)
      : LinedCoupling(ends), master_(settingsOf(*ends.master)), follower_(settingsOf(*ends.follower)) {}

  Forces tick(Vec3 master_m, Vec3 follower_m, Vec3 contact_N) override {
    forth_.take(now_s_, [this](const auto& packet) { follower_.receive(packet); });
    back_.take(now_s_, [this](const auto& packet) { master_.receive(packet); });
    const Forces forces{vectorOf(master_.tick(listed(master_m))),
                        vectorOf(follower_.tick(listed(follower_m), listed(contact_N)))};
    if (const auto packet = master_.send()) forth_.put(now_s_, *packet);
    if (const auto packet = follower_.send()) back_.put(now_s_, *packet);
    now_s_ += kPeriod_s;
    return forces;
  }

 private:
  MasterPort master_;
  FollowerPort follower_;

  static TeleoperationPort::Settings settingsOf(const DevicePreset& device) {
    return {.period_s = kPeriod_s,
            .maxForce_N = device.maxForce_N,
            .resolution_m = device.resolution_m,
            .stiffness_N_per_m = kCoupling_N_per_m,
            .damping_Ns_per_m = kCoupling_Ns_per_m};
  }
};

/// Of encoders, as the ends of all methods but ours have it.
class Speed {
 public:
  Vec3 after(Vec3 place_m) {
    constexpr double kSmooth_s = 5e-3;
    if (last_m_) speed_ += kPeriod_s / (kPeriod_s + kSmooth_s) * ((place_m - *last_m_) / kPeriod_s - speed_);
    last_m_ = place_m;
    return speed_;
  }

 private:
  std::optional<Vec3> last_m_;
  Vec3 speed_{0};
};

struct PlainPacket {
  long tick = 0;
  Vec3 place_m{0}, force_N{0};
};

/// Without an account of energy: the newest packet counts.
class PlainCoupling : public LinedCoupling<PlainPacket> {
 public:
  PlainCoupling(const CoupledEnds& ends, bool feelsContact) : LinedCoupling(ends), feelsContact_(feelsContact) {}

  Forces tick(Vec3 master_m, Vec3 follower_m, Vec3 contact_N) override {
    const auto newest = [](PlainPacket& heard) {
      return [&heard](const PlainPacket& packet) {
        if (packet.tick > heard.tick) heard = packet;
      };
    };
    forth_.take(now_s_, newest(atFollower_));
    back_.take(now_s_, newest(atMaster_));
    ++tick_;
    forth_.put(now_s_, {tick_, master_m, {}});
    back_.put(now_s_, {tick_, follower_m, contact_N});
    now_s_ += kPeriod_s;
    const auto towards = [](const PlainPacket& heard, Vec3 place_m, Vec3 speed) {
      return heard.tick == 0 ? Vec3(0) : kCoupling_N_per_m * (heard.place_m - place_m) - kCoupling_Ns_per_m * speed;
    };
    const Vec3 masterSpeed = masterSpeed_.after(master_m), followerSpeed = followerSpeed_.after(follower_m);
    return {feelsContact_ ? atMaster_.force_N : towards(atMaster_, master_m, masterSpeed),
            towards(atFollower_, follower_m, followerSpeed)};
  }

 private:
  bool feelsContact_;
  PlainPacket atFollower_, atMaster_;
  long tick_ = 0;
  Speed masterSpeed_, followerSpeed_;
};

struct Wave {
  long tick = 0;
  Vec3 value{0};
};

/// Niemeyer & Slotine 1991, of the impedance b: u = (b v + F) / sqrt(2b) forth, w = (b v - F) / sqrt(2b) back. A packet is taken when
/// the latest one of its tick may have come; for one that is lost, the wave before it: without one, a force that stands would fade.
class WaveCoupling final : public LinedCoupling<Wave> {
 public:
  explicit WaveCoupling(const CoupledEnds& ends)
      : LinedCoupling(ends),
        delay_(1 + std::lround((ends.line.delay_s + ends.line.jitter_s) / kPeriod_s)),
        forthWaves_(static_cast<std::size_t>(delay_) + 1),
        backWaves_(forthWaves_.size()) {}

  Forces tick(Vec3 master_m, Vec3 follower_m, Vec3) override {
    const auto keep = [](std::vector<Wave>& waves) {
      return [&waves](const Wave& wave) { waves[static_cast<std::size_t>(wave.tick) % waves.size()] = wave; };
    };
    forth_.take(now_s_, keep(forthWaves_));
    back_.take(now_s_, keep(backWaves_));
    if (tick_ == 0) wanted_m_ = follower_m;

    const double root = std::sqrt(2 * kImpedance_Ns_per_m);
    const Vec3 masterSpeed = masterSpeed_.after(master_m), w = heard(backWaves_, lastBack_);
    const Vec3 pushed_N = kImpedance_Ns_per_m * masterSpeed - root * w;
    forth_.put(now_s_, {tick_, root * masterSpeed - w});

    const Vec3 u = heard(forthWaves_, lastForth_), followerSpeed = followerSpeed_.after(follower_m);
    // The speed that is wanted and the force depend on each other.
    const Vec3 spring_N = kCoupling_N_per_m * (wanted_m_ - follower_m) - kCoupling_Ns_per_m * followerSpeed;
    const Vec3 wanted = (root * u - spring_N) / (kImpedance_Ns_per_m + kCoupling_Ns_per_m);
    const Vec3 pulls_N = spring_N + kCoupling_Ns_per_m * wanted;
    wanted_m_ += kPeriod_s * wanted;
    back_.put(now_s_, {tick_, u - 2 / root * pulls_N});
    now_s_ += kPeriod_s;
    ++tick_;
    return {-pushed_N, pulls_N};
  }

 private:
  static constexpr double kImpedance_Ns_per_m = 10;

  long delay_, tick_ = 0;
  std::vector<Wave> forthWaves_, backWaves_;  // by tick
  Vec3 wanted_m_{0}, lastForth_{0}, lastBack_{0};
  Speed masterSpeed_, followerSpeed_;

  [[nodiscard]] Vec3 heard(const std::vector<Wave>& waves, Vec3& last) const {
    const long due = tick_ - delay_;
    if (due < 0) return Vec3(0);
    const Wave& wave = waves[static_cast<std::size_t>(due) % waves.size()];
    if (wave.tick == due) last = wave.value;
    return last;
  }
};

template <class Made, auto... More>
std::unique_ptr<Coupling> make(const CoupledEnds& ends) {
  return std::make_unique<Made>(ends, More...);
}

constexpr std::array kMethods{
    CouplingMethod{"ours", "this runtime's", make<PassiveCoupling>},
    CouplingMethod{"wave_variables", "wave variables", make<WaveCoupling>},
    CouplingMethod{"position_force", "position–force, plain", make<PlainCoupling, true>},
    CouplingMethod{"position_position", "position–position, plain", make<PlainCoupling, false>},
};

}  // namespace

std::span<const CouplingMethod> couplingMethods() noexcept { return kMethods; }

}  // namespace haptics::eval
