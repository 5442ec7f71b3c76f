#pragma once

#include <cstdint>

#include "haptic_server/engine/step/haptic_step.h"

namespace haptics::eval {

struct MovingSolid;

/// Bodies that move and meet one another, by one method, under a HIP that a scene leads. SI, world frame.
class BodyWorld {
 public:
  virtual ~BodyWorld() = default;

  /// @return Its id; they count up from 1.
  virtual std::uint64_t add(const MovingSolid& solid, const Pose& pose, bool moves) = 0;
  [[nodiscard]] virtual ServoObject& object(std::uint64_t id) = 0;  ///< As the next publish() takes it over.
  virtual void publish() = 0;
  /// @return The force on the hand is filled in by every method.
  virtual TelemetrySample tick(Vec3 hip) = 0;

  [[nodiscard]] virtual const Pose& poseOf(std::uint64_t id) const = 0;
  /// Of a body that moves.
  [[nodiscard]] virtual const RigidState& stateOf(std::uint64_t id) const = 0;
  /// Of what moves, kinetic and potential, J.
  [[nodiscard]] virtual double energyOf(std::uint64_t id) const = 0;
  /// Ticks so far in which bodies waited for their allowance.
  [[nodiscard]] virtual std::uint64_t waitedTicks() const = 0;
};

}  // namespace haptics::eval
