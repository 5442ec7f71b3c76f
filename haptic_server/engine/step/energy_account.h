#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/energy_state.h"

namespace haptics {

/// Observes what energy the hand is given, by object and feature (Hannaford & Ryu 2002, equation 3, of the force that was
/// written, after every limit, and of the way that it acted along). It only tells: a controller that takes back what it
/// finds would pull on a hand that leaves, and sees nothing of a device's unknown delay.
///
/// Deviation: one port, the device, but several sources behind it. What shading, friction, texture and an edit's
/// slew add to the force is theirs; what a surface does that moves is its motion's, or its edit's; the contact's is the rest.
/// So the sources sum up to the port's. What a client adds to the force is no object's. noexcept, no allocation.
class EnergyAccount {
 public:
  /// The HIP is put here (m): no force was felt on the way.
  void begin(Vec3 hip) noexcept {
    hip_ = hip;
    written_ = Vec3(0);
    heldParts_ = 0;
  }

  /// The forces held since the last tick were felt on the way to here.
  void integrate(Vec3 hip) noexcept {
    const Vec3 way = hip - hip_;
    hip_ = hip;
    const double given_J = glm::dot(written_, way);
    all_[0] += given_J;
    rows_.items[row_].given_J[0] += given_J;
    if (heldParts_ != 0) [[unlikely]]
      giveParts(way);
  }

  /// The force (N, world) that is now held, of this object's; 0: of none.
  void setHeldForce(std::uint64_t object, Vec3 written_N) noexcept {
    if (object != rows_.items[row_].object && object != 0) [[unlikely]]
      turnTo(object);
    written_ = written_N;
    heldParts_ = 0;
  }
  /// What a feature has of it: a part, 0 to 1, of this force (N, world).
  void setHeldPart(EnergyFeature feature, const Vec3& force_N, double part) noexcept {
    if (force_N.x == 0 && force_N.y == 0 && force_N.z == 0) return;
    heldParts_ |= std::uint64_t{1} << static_cast<unsigned>(feature);
    parts_[static_cast<std::size_t>(feature)] = part * force_N;
  }

  /// Joules of an object's contact were, or will be, this feature's.
  void attribute(std::uint64_t object, EnergyFeature feature, double given_J) noexcept;

  /// Joules that were counted for the object whose force is held were this one's.
  void give(std::uint64_t object, double given_J) noexcept;

  /// Energy of all objects, including those that are no longer listed.
  [[nodiscard]] const EnergyByFeature& all_J() const noexcept { return all_; }
  /// What was written last, N.
  [[nodiscard]] Vec3 written_N() const noexcept { return written_; }
  void copyTo(EnergyState& state) const noexcept;

  /// Whether one that comes from elsewhere can be used.
  [[nodiscard]] bool isWhole() const noexcept;

  HAPTICS_FIELDS(self.hip_, self.written_, self.all_, self.row_, self.heldParts_, self.parts_, self.rows_);

 private:
  void turnTo(std::uint64_t object) noexcept;
  [[nodiscard]] ObjectEnergy& rowOf(std::uint64_t object) noexcept;
  void giveParts(Vec3 way) noexcept;

  Vec3 hip_{0};
  Vec3 written_{0};
  EnergyByFeature all_{};
  std::uint64_t row_ = 0;                      // of the object that the held force is of
  std::uint64_t heldParts_ = 0;                // a bit for each feature that has a part of the held force
  std::array<Vec3, kEnergyFeatures> parts_{};  // the contact's is not used
  Sequence<ObjectEnergy, EnergyState::kMax> rows_{};
};
static_assert(std::is_trivially_copyable_v<EnergyAccount> && fields::isListed<EnergyAccount>());

}  // namespace haptics
