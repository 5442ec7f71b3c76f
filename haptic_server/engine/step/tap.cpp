#include "haptic_server/engine/step/tap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/maths/elementary.h"
#include "haptic_server/engine/step/separation_speed.h"

namespace haptics {
namespace {

/// Of all that rings at once, or half of the device's force where that is less. More is felt as a blow.
constexpr double kMax_N = 2;
/// What is left of that once kSlowestTap_per_s has decayed for 0.1 s: it ends there, by a step of no more than this.
constexpr double kMin_N = 5e-3;
/// What taps may give the hand at once, and again in each second: they are active, and so the account has an end.
constexpr double kBudget_J = 5e-3;

[[nodiscard]] double amplitude_N(const TapMemory& tap) noexcept {
  return std::sqrt(squaredLength(tap.cosine_N) + squaredLength(tap.sine_N));
}

void account(HapticState& state, double part, Vec3 way, double period_s) noexcept {
  TapMemory& tap = state.surface.tap;
  tap.spent_J = std::max(0.0, tap.spent_J - kBudget_J * period_s);
  if (tap.force_N == Vec3(0)) return;
  const double given_J = part * glm::dot(tap.force_N, way);
  state.energy.give(tap.object, given_J);
  tap.spent_J = std::max(0.0, tap.spent_J + given_J);
}

void ring(TapMemory& tap) noexcept {
  const Vec3 cosine_N = tap.turnCosine * tap.cosine_N - tap.turnSine * tap.sine_N;
  tap.sine_N = tap.turnCosine * tap.sine_N + tap.turnSine * tap.cosine_N;
  tap.cosine_N = cosine_N;
  if (amplitude_N(tap) >= kMin_N) return;
  tap.cosine_N = tap.sine_N = Vec3(0);
}

/// The sine, which is the force, goes on from where it is.
void strike(const ServoObject& touched, HapticState& state, const StepConfig& config,
            const ContactResult& contact) noexcept {
  const SurfaceDetail* const detail = touched.detail.get();
  if (detail == nullptr || !(detail->scalars.tap_Ns_per_m > 0)) return;
  const double speed_m_per_s = -separationSpeed(state, contact.body, contact.ihip, contact.normal, config.period_s);
  TapMemory& tap = state.surface.tap;
  const double room_N = std::min(kMax_N, config.maxForce_N / 2) - amplitude_N(tap);
  const double added_N = std::min(detail->scalars.tap_Ns_per_m * speed_m_per_s, room_N);
  if (!(added_N >= kMin_N)) return;
  const double shrinking =
      elementary::exp(-std::max(kSlowestTap_per_s, detail->scalars.tap_decay_per_s) * config.period_s);
  const auto turn = elementary::sineCosine(2 * std::numbers::pi * detail->scalars.tap_Hz * config.period_s);
  tap.turnCosine = shrinking * turn.cosine;
  tap.turnSine = shrinking * turn.sine;
  tap.cosine_N += added_N * contact.normal;
  tap.object = touched.id;
}

}  // namespace

EffectsFelt feelTap(const ServoScene& scene, HapticState& state, const StepConfig& config, const ContactResult& contact,
                    double part, Vec3 way) noexcept {
  TapMemory& tap = state.surface.tap;
  account(state, part, way, config.period_s);
  if (tap.rings()) ring(tap);
  if (contact.touching && !state.now.adopted) {
    const ServoObject& touched = scene.objects[static_cast<std::size_t>(contact.body)];
    if (touched.id != state.report.object) strike(touched, state, config, contact);
  }
  const Vec3 force_N = std::clamp(2 * (1 - tap.spent_J / kBudget_J), 0.0, 1.0) * tap.sine_N;
  EffectsFelt felt;
  felt.force_N = force_N;
  felt.byTime_N = glm::distance(force_N, tap.force_N);
  tap.force_N = force_N;
  return felt;
}

}  // namespace haptics
