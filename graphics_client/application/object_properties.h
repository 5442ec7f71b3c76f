#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"
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
  bool isHidden = false;  ///< Where the object has none; else it is grey there.
};

/// Along the axes of the object's frame, around its mesh; of size 0 until that is here.
struct ObjectBox {
  Vec3 low_m{0}, high_m{0};
  [[nodiscard]] Vec3 centre_m() const { return (low_m + high_m) / 2.0; }
  [[nodiscard]] Vec3 top_m() const { return {centre_m().x, centre_m().y, high_m.z}; }
  [[nodiscard]] double longest_m() const;
};

/// What an operation needs beside the record.
struct Surroundings {
  double floor_m = 0;  ///< World z, on which the object comes to rest.
  ObjectBox box = {};
  Pose pose = {};  ///< Where it is, which of one that moves is not where the scene has it.
};

/// What an object has or has not.
struct SwitchProperty {
  const char* label;
  const char* tip;
  bool (*get)(const ObjectRecord&);
  void (*set)(const ObjectRecord&, bool on, const Surroundings&, v1::Operation&);
  bool isOfAll = false;  ///< Switched on, the others have to meet it: they are given what meetsOthers() gives.
  bool (*isThere)(const ObjectRecord&) = nullptr;  ///< Null: always. Else it is hidden where this is false.
};

/// One of several.
struct ChoiceProperty {
  const char* label;
  const char* tip;
  std::vector<std::string> entries;
  /// Nothing: the object has none.
  std::function<std::optional<std::size_t>(const ObjectRecord&)> get;
  std::function<Result<void>(const ObjectRecord&, std::size_t entry, const Surroundings&, v1::Operation&)> set;
};

/// Properties under one heading.
struct PropertyGroup {
  const char* title;
  std::span<const SwitchProperty> switches;
  bool isTexture;  ///< The family is chosen first.
  std::span<const NumberProperty> numbers;
  std::span<const ChoiceProperty> choices = {};
};

[[nodiscard]] std::span<const PropertyGroup> propertyGroups();
[[nodiscard]] ObjectBox boxOf(const TriMesh& mesh);

/// Of a unit vector; the two others stay in their ratio.
void setComponent(Vec3& direction, int axis, double value);

/// As screens show it: sRGB, 8 bits each, red first.
[[nodiscard]] std::array<int, 3> shownColor(const Color& color);
void setShownColor(std::array<int, 3> color, v1::Operation& operation);
/// Has it met by others that collide: where it stays, or as it moves. Its mesh has to be closed.
void setMeetsOthers(const ObjectRecord& object, bool on, v1::Operation& operation);

/// Of the object that it is sent to.
void setObject(v1::Operation& operation, const std::string& name);

}  // namespace haptics
