#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>

#include "common/scene/scene.h"
#include "haptics/v1/scene.pb.h"

// What a user sees and sets of an object: values of its record, and the operations that set them, which name no object.
namespace haptics {

/// A number, in the unit that is shown.
struct NumberProperty {
  const char* label;
  const char* tip;
  const char* unit;
  double least, most;  ///< That are usual; beyond, the server decides.
  int decimals;
  bool logarithmic;  ///< Its slider; least > 0.
  /// Nothing: the object has none.
  std::function<std::optional<double>(const ObjectRecord&)> get;
  std::function<void(const ObjectRecord&, double value, v1::Operation&)> set;
};

/// What an object has or has not.
struct SwitchProperty {
  const char* label;
  const char* tip;
  bool (*get)(const ObjectRecord&);
  /// @param floor_m  World z, on which the object comes to rest.
  void (*set)(const ObjectRecord&, bool on, double floor_m, v1::Operation&);
  bool isOfAll = false;  ///< Switched on, the others have to meet it: they are given what meetsOthers() gives.
};

/// Properties under one heading.
struct PropertyGroup {
  const char* title;
  std::span<const SwitchProperty> switches;
  bool isTexture;  ///< The family is chosen first.
  std::span<const NumberProperty> numbers;
};

[[nodiscard]] std::span<const PropertyGroup> propertyGroups();

/// As screens show it: sRGB, 8 bits each, red first.
[[nodiscard]] std::array<int, 3> shownColor(const Color& color);
void setShownColor(std::array<int, 3> color, v1::Operation& operation);
/// Has it met by others that collide: where it stays, or as it moves. Its mesh has to be closed.
void setMeetsOthers(const ObjectRecord& object, bool on, v1::Operation& operation);

/// Of the object that it is sent to.
void setObject(v1::Operation& operation, const std::string& name);

}  // namespace haptics
