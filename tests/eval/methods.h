#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "tests/eval/renderer.h"

namespace haptics::eval {

struct Method {
  std::string_view name;
  std::string_view about;
  std::function<std::unique_ptr<Renderer>()> make;
  // Which scenes it has to do with.
  bool contact = true;
  bool edits = true;
  bool surfaces = false;
  bool motion = false;
  bool softness = false;
  bool bodies = false;
  bool streams = false;
  bool outside = false;  ///< adapters/outside_method.h

  [[nodiscard]] bool isFor(Concern concern) const {
    switch (concern) {
      case Concern::kContact:
        return contact;
      case Concern::kEdits:
        return edits;
      case Concern::kSurfaces:
        return surfaces;
      case Concern::kMotion:
        return motion;
      case Concern::kSoftness:
        return softness;
      case Concern::kBodies:
        return bodies;
      case Concern::kStreams:
        return streams;
    }
    return false;
  }
};

inline constexpr std::string_view kOurs = "ours";

/// Ours first, ours with force shading and with the search in float, then the baselines.
[[nodiscard]] std::span<const Method> methods();
/// These and ours without substeps: one more option of ours that the speed-accuracy chart weighs.
[[nodiscard]] std::span<const Method> chartMethods();
/// Ours with one correction switched off: the contact core and a spring, without the rest of the step.
[[nodiscard]] std::span<const Method> ablatedMethods();

/// Ours without the clamp of K, and section 4 of the paper as printed: only for scenes with surface properties. Soft bodies
/// as usually written: only for those. Springs between bodies: only where these meet.
[[nodiscard]] std::span<const Method> singleConcernMethods();

/// One of `among`, or the method from outside that is named by its file or command. Throws std::invalid_argument, listing the
/// names of `among`, when there is none called so.
[[nodiscard]] const Method& findMethod(std::string_view name, std::span<const Method> among);

}  // namespace haptics::eval
