#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/scene/scene.h"

// The colours of the picture, as the screen shows them (sRGB, 0 to 1), and the markers' sizes.
namespace haptics::palette {

struct Shade {
  double red, green, blue;

  bool operator==(const Shade&) const = default;
};

/// As pictures store it; what is too bright is full.
[[nodiscard]] inline std::array<unsigned char, 3> bytes(Shade shade) {
  const auto byte = [](double part) {
    return static_cast<unsigned char>(std::lround(255 * std::clamp(part, 0.0, 1.0)));
  };
  return {byte(shade.red), byte(shade.green), byte(shade.blue)};
}

inline constexpr Shade kSkyTop{0.66, 0.74, 0.83};
inline constexpr Shade kSkyBottom{0.95, 0.96, 0.97};
inline constexpr Shade kFloor{0.90, 0.91, 0.92};
inline constexpr Shade kFloorLine{0.84, 0.855, 0.87};
inline constexpr Shade kFloorBoldLine{0.74, 0.76, 0.785};
inline constexpr Shade kShadow{0.77, 0.785, 0.805};

inline constexpr Shade kHip{0.86, 0.16, 0.20};        // red: where the device is
inline constexpr Shade kIhip{0.05, 0.42, 0.90};       // blue: where the contact is
inline constexpr Shade kSpring{0.20, 0.22, 0.26};     // the line between them
inline constexpr Shade kPrimitive{1.00, 0.80, 0.05};  // contacted polygon, line or vertex
inline constexpr Shade kTrail{0.05, 0.42, 0.90};
inline constexpr Shade kPointer{0.00, 0.62, 0.62};   // where the mouse pulls the hand to
inline constexpr Shade kMeasured{0.45, 0.10, 0.45};  // places that are measured
inline constexpr Shade kSelected{0.95, 0.35, 0.00};  // around the selected object
inline constexpr Shade kForceLow{0.10, 0.62, 0.30};
inline constexpr Shade kForceMiddle{0.95, 0.60, 0.05};
inline constexpr Shade kForceHigh{0.85, 0.10, 0.10};
inline constexpr Shade kSlippery{0.80, 0.86, 0.88};
inline constexpr Shade kGripping{0.86, 0.66, 0.40};
inline constexpr Shade kRough{0.48, 0.22, 0.12};
inline constexpr Shade kSticking{0.55, 0.20, 0.62};  // the sticking point
inline constexpr Shade kSliding{0.95, 0.55, 0.10};
inline constexpr Shade kTorque{0.55, 0.20, 0.62};
inline constexpr Shade kPulls{0.00, 0.50, 0.55};     // effects: springs and guides,
inline constexpr Shade kKeepsOut{0.80, 0.15, 0.25};  // forbidden sides and tubes,
inline constexpr Shade kDrags{0.45, 0.25, 0.70};     // viscosity,
inline constexpr Shade kActs{0.90, 0.50, 0.00};      // constant forces and vibrations
inline constexpr Shade kFaded{0.62, 0.64, 0.66};     // what is shown but no longer true

/// Of handles: along or about x, y, z, and the one under the pointer.
inline constexpr std::array kAxes{Shade{0.85, 0.15, 0.15}, Shade{0.10, 0.60, 0.15}, Shade{0.15, 0.30, 0.90}};
inline constexpr Shade kLitHandle{1.00, 0.75, 0.00};

/// Words are read on a card over whatever is behind it: contrast 4.5 and more (WCAG 2.1, 1.4.3).
inline constexpr Shade kCard{1, 1, 1};
inline constexpr double kCardOpacity = 0.92;
inline constexpr Shade kText{0.10, 0.12, 0.15};
inline constexpr Shade kLabel{0.36, 0.40, 0.45};
inline constexpr Shade kGood{0.04, 0.47, 0.20};
inline constexpr Shade kWarning{0.60, 0.35, 0.00};
inline constexpr Shade kBad{0.76, 0.06, 0.08};

[[nodiscard]] inline Shade mix(Shade a, Shade b, double s) {
  return {a.red + (b.red - a.red) * s, a.green + (b.green - a.green) * s, a.blue + (b.blue - a.blue) * s};
}

/// The standard's transfer curve (IEC 61966-2-1), from light to what a screen is given.
[[nodiscard]] inline double encodeSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

[[nodiscard]] inline Shade shadeOf(const Color& color) {
  return {encodeSrgb(color.red), encodeSrgb(color.green), encodeSrgb(color.blue)};
}

/// Green through orange to red as the force nears the device's limit; share 0 to 1.
[[nodiscard]] inline Shade forceShade(double share) {
  return share < 0.5 ? mix(kForceLow, kForceMiddle, 2 * share) : mix(kForceMiddle, kForceHigh, 2 * share - 1);
}

/// From an object's own colour at rest to that of the deepest dent; share 0 to 1.
[[nodiscard]] inline Shade displacementShade(Shade own, double share) {
  const double s = share < 1 ? share : 1;
  return s < 0.5 ? mix(own, kForceMiddle, 2 * s) : mix(kForceMiddle, kForceHigh, 2 * s - 1);
}

/// From little friction to much; share 0 to 1.
[[nodiscard]] inline Shade frictionShade(double share) {
  return share < 0.5 ? mix(kSlippery, kGripping, 2 * share) : mix(kGripping, kRough, 2 * share - 1);
}

}  // namespace haptics::palette
