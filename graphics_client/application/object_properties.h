#pragma once

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
  void (*set)(bool on, double floor_m, v1::Operation&);
};

/// Properties under one heading.
struct PropertyGroup {
  const char* title;
  const SwitchProperty* has;  ///< Null: every object has them.
  bool isTexture;             ///< The family is chosen first.
  std::span<const NumberProperty> numbers;
};

[[nodiscard]] std::span<const PropertyGroup> propertyGroups();

/// Of the object that it is sent to.
void setObject(v1::Operation& operation, const std::string& name);

}  // namespace haptics
