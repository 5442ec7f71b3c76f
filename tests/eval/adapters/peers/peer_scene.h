#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "common/maths/vec.h"
#include "tests/eval/adapters/haptics_method.h"

// What the adapters to other people's libraries share.
namespace haptics::eval::peers {

/// Of the spheres that libraries of bodies put into the hand: these know no point.
inline constexpr double kProxyRadius_m = 1e-3;

inline Vec3 toVec3(const double* v) { return {v[0], v[1], v[2]}; }
inline Pose toPose(const haptics_pose& pose) {
  const double* const q = pose.rotation;
  return {{q[0], q[1], q[2], q[3]}, toVec3(pose.position)};
}

inline void answerPlace(haptics_answer& answer, Vec3 ihip) {
  for (int k = 0; k < 3; ++k) answer.ihip_m[k] = ihip[k];
}

/// A spring from the hand to a place of the surface.
inline void answerContact(haptics_answer& answer, Vec3 ihip, Vec3 hip, double stiffness_N_per_m) {
  answer.flags = HAPTICS_TOUCHING;
  answerPlace(answer, ihip);
  for (int k = 0; k < 3; ++k) answer.force_N[k] = stiffness_N_per_m * (ihip[k] - hip[k]);
}

/// Of a sphere that rests on the surface: the place below it that is nearest to the hand. It is felt from where the hand itself
/// is below the surface, not from a radius above.
inline void answerSphere(haptics_answer& answer, Vec3 centre, Vec3 hip, double stiffness_N_per_m) {
  const double apart = glm::distance(centre, hip);
  if (apart <= kProxyRadius_m) return answerPlace(answer, hip);
  answerContact(answer, hip + (centre - hip) * (1 - kProxyRadius_m / apart), hip, stiffness_N_per_m);
}

/// @return What `load` throws, for haptics_method_functions::load.
template <class Load>
const char* whyNot(Load load) {
  static std::string why;
  try {
    load();
    return nullptr;
  } catch (const std::exception& error) {
    why = error.what();
  }
  return why.c_str();
}

/// The adapter of a World that is made from a scene, and has place(hip) and tick(poses, hip, answer).
/// @param name, version  Outlive the library's use.
template <class World>
const haptics_method_functions* functionsOf(std::uint32_t abilities, const char* name, const char* version) {
  static std::unique_ptr<World> world;
  static const haptics_method_functions functions{
      HAPTICS_METHOD_ABI,
      abilities,
      name,
      version,
      [](const haptics_scene* scene) {
        return whyNot([scene] {
          world.reset();
          world = std::make_unique<World>(*scene);
        });
      },
      [](const double* hip) { world->place(toVec3(hip)); },
      [](const haptics_pose* poses, const double* hip, haptics_answer* answer) {
        world->tick(poses, toVec3(hip), *answer);
      }};
  return &functions;
}

}  // namespace haptics::eval::peers
