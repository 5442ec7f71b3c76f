#pragma once

#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

// Springs whose constant varies over the surface, k(x) = k f(x), where x is the place of the IHIP on the shape without dents.
// Of the energy E = k f(x) d^2 / 2 of a spring that is d long the hand feels
//
//   F = -grad E = k f d n - (d^2 / 2) k grad f,
//
// of grad f the part along the ways that the IHIP has there: on a polygon in its plane, on a line along it, in a groove of
// two surfaces along that. Without the second term, which pushes to where the spring is softer, a closed loop that presses
// where it is soft and lets go where it is stiff takes k (f_2 - f_1) d^2 / 2 out of nothing. Deviation from the paper, whose
// surfaces have one constant each.
//
// On a rigid body with force shading x is the point that shading projects the HIP to, which moves over the mesh's lines
// without a jump; at a depth d it moves as on the triangle whose corners are d below the mesh's, along their normals. Without
// shading the IHIP jumps over convex lines, which takes or gives the part d / R of the term, R the radius of curvature.
//
// Of the tissue in series, which yields by y with t(x) = t g(x), it is likewise -(y^2 / 2) t grad g: at rest the two springs
// are in balance, so that moving along the surface changes their energy only through k and t.
//
// A map so steep and fine that the term would be sideways a spring stiffer than StepConfig::stableLateral_N_per_m is felt
// with a part of it, as textures are: it is then not conservative, but stable.

/// A factor where a body is touched. World, 1/m.
[[nodiscard]] FactorSample factorAt(const SurfaceFactor& factor, const ServoObject& object, const Body& body,
                                    std::uint32_t triangle, Vec3 place, double most) noexcept;

/// f at a place on a body whose stiffness varies.
[[nodiscard]] FactorSample stiffnessFactorAt(const ServoObject& object, const Body& body, std::uint32_t triangle,
                                             Vec3 place) noexcept;

/// Every felt stiffness of those that hold the IHIP goes to where that is.
void varyStiffness(const ServoScene& scene, HapticState& state) noexcept;

/// The second term.
/// @param factor  Whose spring it is; sample  of it, at the place, with the gradient along the IHIP's ways.
/// @param spring_N_per_m  k: at a factor of 1.
/// @param squared_m2  d^2.
[[nodiscard]] Vec3 pushAlong_N(const SurfaceFactor& factor, const FactorSample& sample, double spring_N_per_m,
                               double squared_m2, const StepConfig& config) noexcept;

/// Of a gradient on a triangle of a shaded body (both world, 1/m), that by the place of a HIP so far below it (m).
[[nodiscard]] Vec3 belowShaded(const ServoObject& object, const Body& body, std::uint32_t triangle, double depth_m,
                               Vec3 normal, Vec3 gradient) noexcept;

/// The component of a world direction along the directions in which the held IHIP can move.
[[nodiscard]] Vec3 alongContact(const HapticState& state, Vec3 direction) noexcept;

/// The second term of all contact springs that hold the IHIP, N, world.
/// @param penetration_m  From the HIP to the IHIP.
/// @param depth_m  d, where one body holds it: below the textured surface.
[[nodiscard]] Vec3 contactPushAlong_N(const ServoScene& scene, const HapticState& state, const StepConfig& config,
                                      Vec3 penetration_m, double depth_m) noexcept;

}  // namespace haptics
