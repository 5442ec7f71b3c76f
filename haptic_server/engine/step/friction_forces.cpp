#include "haptic_server/engine/step/friction_forces.h"

#include <algorithm>
#include <array>

#include "haptic_server/engine/step/material_map.h"

namespace haptics {
namespace {

/// Encoder steps that the IHIP must come back to end sliding: a tremor of one step each way along the surface, the same
/// in depth, which moves the limit of the stretch, and the step itself.
constexpr double kHysteresisSteps = 6;
/// No less, though a device may resolve it: a hand's own tremor.
constexpr double kMinHysteresis_m = 60e-6;
/// Cosine of the normals of one surface in two ticks, where several hold the IHIP. Larger forgets a surface that turns;
/// smaller takes another one for it.
constexpr double kSameSurface = 0.7;

class HeldFrictions {
 public:
  HeldFrictions(const ServoScene& scene, HapticState& state, const StepConfig& config, const Vec3& ihip) noexcept
      : scene_(scene), state_(state), config_(config), ihip_(ihip) {}

  void run(std::span<const PressedSurface> pressed, ForceResult& result) noexcept {
    auto& held = state_.surface.friction;
    if (pressed.size() == 1 && held[1].object == 0) [[likely]] {
      const Vec3 force_N = follow(held[0], pressed[0]);
      reportTo(held[0], result);
      return apply(force_N, result);
    }
    runSeveral(pressed, result);
  }

 private:
  [[gnu::noinline]] void runSeveral(std::span<const PressedSurface> pressed, ForceResult& result) noexcept {
    recognise(pressed);
    auto& held = state_.surface.friction;
    Vec3 force_N(0);
    for (std::size_t k = 0; k < pressed.size(); ++k) {
      force_N += follow(held[k], pressed[k]);
      if (result.friction == FrictionState::kNone) reportTo(held[k], result);
    }
    apply(force_N, result);
  }

  static void reportTo(const HeldFriction& held, ForceResult& result) noexcept {
    result.friction = held.law.state();
    result.stickingPoint = held.stickingPoint;
  }
  void apply(Vec3 force_N, ForceResult& result) const noexcept {
    if (const double length_N = glm::length(force_N); length_N > 0)
      result.force.friction = force_N * blendWeight(length_N);
  }

  /// Puts what is remembered in the order of what is pressed now. The contact's only surface goes on in the one that is
  /// most like it, however it turned: the IHIP slides over edges.
  void recognise(std::span<const PressedSurface> pressed) noexcept {
    auto& held = state_.surface.friction;
    std::array<HeldFriction, ContactState::kMaxHolding> next{};
    for (double least = -2;; least = kSameSurface) {
      double best = least;
      HeldFriction *from = nullptr, *to = nullptr;
      for (std::size_t k = 0; k < pressed.size(); ++k) {
        if (next[k].object != 0) continue;
        for (HeldFriction& before : held) {
          const double cosine = glm::dot(before.normal, pressed[k].normal);
          if (before.object == 0 || cosine <= best) continue;
          best = cosine;
          from = &before;
          to = &next[k];
        }
      }
      if (from == nullptr) break;
      *to = *from;
      from->object = 0;
    }
    held = next;
  }

  /// One tick of one surface: force on the hand, world, N.
  [[nodiscard, gnu::always_inline]] Vec3 follow(HeldFriction& held, const PressedSurface& pressed) const noexcept {
    const Body& body = state_.bodies[pressed.body];
    const ServoObject& object = scene_.objects[pressed.body];
    const FrictionDetail* friction = object.detail && object.detail->friction ? &*object.detail->friction : nullptr;
    // Its own spring is the same over the surface: one that varied while it sticks would give energy.
    const double spring_N_per_m = state_.objects[pressed.body].stiffness.mean().spring_N_per_m;
    const bool isOther = held.object != 0 && held.object != object.id;
    held.object = object.id;
    held.normal = pressed.normal;
    if (friction == nullptr || !(friction->most() > 0) || !(spring_N_per_m > 0)) {
      held.law.release();
      return Vec3(0);
    }
    const Vec3 place = body.frame.toLocal(ihip_);
    const FrictionCoefficients mu = friction->varies() ? varying(*friction, pressed, place) : friction->mean();
    if (isOther) held.law.carry(body.frame.toLocal(held.stickingPoint));
    if (isOther || state_.now.detailEdited) held.law.edit(mu);
    const PressedPoint at{place, body.frame.toLocalDirection(pressed.normal), pressed.pressing_N};
    const FrictionScale scale{friction->stiffnessFor(spring_N_per_m, config_.stableLateral_N_per_m),
                              std::max(kHysteresisSteps * config_.positionStep_m, kMinHysteresis_m)};
    const Vec3 force = held.law.follow(at, mu, scale, config_.period_s);
    held.stickingPoint = body.frame.toWorld(held.law.stickingPoint());
    return body.frame.rotate(force);
  }

  /// @param place  Object frame.
  [[nodiscard]] FrictionCoefficients varying(const FrictionDetail& friction, const PressedSurface& pressed,
                                             const Vec3& place) const noexcept {
    if (isDeformed(scene_, state_, pressed.body)) return onMaterial(friction, pressed, place);
    return friction.at(state_.bodies[pressed.body].surface->triangle(pressed.triangle), place, place);
  }
  [[nodiscard, gnu::noinline]] FrictionCoefficients onMaterial(const FrictionDetail& friction,
                                                               const PressedSurface& pressed,
                                                               const Vec3& place) const noexcept {
    const TriangleRecord dented =
        pressed.dented != nullptr ? *pressed.dented : dentedTriangle(scene_, state_, pressed.body, pressed.triangle);
    return friction.at(dented, place,
                       mapToMaterial(scene_, state_, pressed.body, pressed.triangle, dented).place(place));
  }

  /// After an edit friction goes on from the force that it was.
  [[nodiscard]] double blendWeight(double force_N) const noexcept {
    double& blendWeight = state_.surface.frictionWeight;
    if (state_.now.detailEdited && force_N > 0) {
      blendWeight = std::min(glm::length(state_.surface.frictionForce_N) / force_N, SurfaceMemory::kMaxFrictionWeight);
    }
    if (blendWeight != 1) [[unlikely]] {
      const double most = config_.period_s / BumpState::kFadeIn_s;
      blendWeight += std::clamp(1 - blendWeight, -most, most);
    }
    return blendWeight;
  }

  const ServoScene& scene_;
  HapticState& state_;
  const StepConfig& config_;
  const Vec3& ihip_;
};

}  // namespace

void computeFriction(const ServoScene& scene, HapticState& state, const StepConfig& config, const Vec3& ihip,
                     std::span<const PressedSurface> pressed, ForceResult& result) noexcept {
  HeldFrictions(scene, state, config, ihip).run(pressed, result);
}

}  // namespace haptics
