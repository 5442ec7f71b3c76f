#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "common/maths/vec.h"
#include "haptic_server/device/presets.h"
#include "tests/eval/teleoperation/line.h"

namespace haptics::eval {

/// Master and follower with the line between them, in virtual time.
class Coupling {
 public:
  /// For the motors.
  struct Forces {
    Vec3 master_N{0}, follower_N{0};
  };

  virtual ~Coupling() = default;
  /// Each millisecond.
  /// @param contact_N  On the follower, by what it touches.
  virtual Forces tick(Vec3 master_m, Vec3 follower_m, Vec3 contact_N) = 0;
  struct Packets {
    long forth = 0, back = 0;
  };
  /// So far; each end sends one a tick at most.
  [[nodiscard]] virtual Packets packets() const = 0;
};

struct CoupledEnds {
  const DevicePreset* master = nullptr;
  const DevicePreset* follower = nullptr;
  LineQuality line;
  std::uint64_t seed = 0;
};

struct CouplingMethod {
  const char* name;
  const char* title;
  std::unique_ptr<Coupling> (*make)(const CoupledEnds&);
};

constexpr double kCoupling_N_per_m = 600,
                 kCoupling_Ns_per_m = 10;  ///< Of every method; of ours these are the usual ones.

/// Ours is the first.
[[nodiscard]] std::span<const CouplingMethod> couplingMethods() noexcept;

}  // namespace haptics::eval
