#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/maths/vec.h"
#include "common/mesh/part_name.h"
#include "common/scene/asset_source.h"
#include "common/scene/deformation_properties.h"
#include "common/scene/effect_properties.h"
#include "common/scene/motion_properties.h"
#include "common/scene/surface_edits.h"
#include "common/scene/surface_properties.h"

namespace haptics {

using ObjectId = std::uint64_t;  ///< Given by the server, never reused within an epoch; 0 is no object.

struct Color {
  float red = 0.8F, green = 0.8F, blue = 0.8F;  ///< Linear, 0 to 1.
  bool operator==(const Color&) const = default;
};

struct Material {
  double stiffness_N_per_m = 800;
  double damping_Ns_per_m = 0.5;
  Color color;
  SurfaceProperties surface = {};
  bool operator==(const Material&) const = default;
};

/// One object of the scene as both databases hold it. The mesh is named by its content.
struct ObjectRecord {
  ObjectId id = 0;
  std::string name;
  std::uint64_t revision = 0;  ///< Of the commit that last changed it.
  ContentHash mesh;
  Pose pose;  ///< Of an object that moves: where it starts, and rests.
  Material material;
  std::optional<MotionProperties> motion = std::nullopt;
  DeformationProperties deformation = {};
  std::vector<Effect> effects = {};

  bool operator==(const ObjectRecord&) const = default;
  /// Else it stays, unless it is driven (SetPose::kinematic).
  [[nodiscard]] bool movesByItself() const noexcept { return motion && !motion->fixed; }
  /// SHA-256 over all fields in declaration order, canonical form (Hasher).
  [[nodiscard]] ContentHash hash() const;
  /// What it names by content, the mesh first.
  [[nodiscard]] std::vector<AssetName> assets() const;
};

/// One accepted transaction: absolute records, so that applying is replacing.
struct Commit {
  std::uint64_t revision = 0;
  ContentHash prevRoot;
  std::vector<ObjectRecord> put;
  std::vector<ObjectId> removed;
  ContentHash root;
};

/// An immutable version of the scene, shared between threads. Both the server and every mirror make the next version
/// with the same function; that their roots agree is the proof that they hold the same scene.
class SceneVersion {
 public:
  using Object = std::shared_ptr<const ObjectRecord>;

  /// Revision 0, no objects.
  SceneVersion();
  /// A version as a snapshot describes it. Refused: ids or names that are zero, empty or double.
  [[nodiscard]] static Result<SceneVersion> fromSnapshot(std::uint64_t revision, std::vector<ObjectRecord> objects);

  /// The version after the commit's changes; prevRoot and root are *not* compared here: the sequencer makes the root
  /// from the result, a mirror compares it. Refused: a revision other than revision() + 1, removal of an object that is
  /// not there, an id of zero, a name that is empty or that another object has.
  [[nodiscard]] Result<SceneVersion> apply(const Commit& commit) const;

  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }
  /// SHA-256 over the revision and, for each object in order of id, (id, revision, hash).
  [[nodiscard]] const ContentHash& root() const noexcept { return root_; }
  [[nodiscard]] const std::vector<Object>& objects() const noexcept { return objects_; }  ///< In order of id.
  [[nodiscard]] Object find(ObjectId id) const;
  [[nodiscard]] Object find(const std::string& name) const;

 private:
  std::uint64_t revision_ = 0;
  std::vector<Object> objects_;
  std::vector<ContentHash> hashes_;  // of objects_, so that a commit hashes only what it changes
  ContentHash root_;

  void updateRoot();
};

// ---- What a client asks for, after decoding and range checks (common/wire) ----

struct ObjectRef {
  std::variant<ObjectId, std::string> value;  ///< Id or name.
  [[nodiscard]] std::string text() const;     ///< `object 7` or `object "torus"`.
};

struct Precondition {
  ObjectRef object;
  std::uint64_t expectedRevision = 0;
  std::optional<ContentHash> expectedHash;
};

struct BoxSource {
  Vec3 size_m{0};
  std::uint32_t segments = 1;
};
struct SphereSource {
  double radius_m = 0;
  std::uint32_t segments = 32;
};
struct CylinderSource {
  double radius_m = 0, height_m = 0;
  std::uint32_t segments = 64;
};
struct TorusSource {
  double majorRadius_m = 0, minorRadius_m = 0;
  std::uint32_t majorSegments = 128, minorSegments = 64;
};

struct MeshSource {
  std::variant<BoxSource, SphereSource, CylinderSource, TorusSource, FileSource, AssetSource> source;
  std::optional<double> unit_m = std::nullopt;  ///< Metres per unit of a file; none: ImportOptions::unit_m.
  /// Instead of unit_m: scale to this longest side, centre at the origin.
  std::optional<double> largestExtent_m = std::nullopt;
  bool keepCrossings = false;  ///< Of a file: ImportOptions::keepCrossings.
  PartName part = {};          ///< Of a file: ImportOptions::part.
  /// Keep as much of the mesh as it takes for a force error below this, in JNDs (common/maths/perception.h); none: all.
  std::optional<double> simplifyError = std::nullopt;
};
/// Of MeshSource::simplifyError: ten times what a hand just notices is another shape.
inline constexpr double kMinSimplifyError = 1e-3, kMaxSimplifyError = 10;

struct PoseEdit {
  std::optional<Vec3> position;
  std::optional<Quat> rotation;  ///< Normalised.
};

struct MaterialEdit {
  std::optional<double> stiffness_N_per_m, damping_Ns_per_m;
  std::optional<Color> color = std::nullopt;
  SurfaceEdit surface = {};
};

struct AddObject {
  std::string name;
  MeshSource mesh;
  PoseEdit pose;
  MaterialEdit material;
  std::optional<MotionProperties> motion = std::nullopt;
  DeformationEdit deformation = {};
  std::vector<Effect> effects = {};
};
struct RemoveObject {
  ObjectRef object;
};
struct RemeshObject {
  ObjectRef object;
  MeshSource mesh;
};
struct SetPose {
  ObjectRef object;
  PoseEdit pose;
  bool kinematic = false;  ///< A motion, which makes no revision, instead of an edit.
};
struct SetMaterial {
  ObjectRef object;
  MaterialEdit material;
};
struct SetMotion {
  ObjectRef object;
  std::optional<MotionProperties> motion;  ///< None: taken away.
};
struct SetDeformation {
  ObjectRef object;
  DeformationEdit deformation;
  bool kinematic = false;  ///< As in SetPose: of the lattice alone.
};
struct SetEffects {
  ObjectRef object;
  std::vector<Effect> effects;  ///< In place of all that there are.
};
struct Operation
    : std::variant<AddObject, RemoveObject, RemeshObject, SetPose, SetMaterial, SetMotion, SetDeformation, SetEffects> {
  using variant::variant;
  using variant::operator=;
  Operation() noexcept;
  Operation(const Operation&);
  Operation(Operation&&) noexcept;
  Operation& operator=(const Operation&);
  Operation& operator=(Operation&&) noexcept;
  ~Operation();
};

struct Transaction {
  std::vector<Precondition> preconditions;
  std::vector<Operation> operations;
};

/// Calls visit(name, its value in each of the materials or edits...) for every number; the names are those of scene.proto.
template <class Visit, class... Materials>
void forEachMaterialScalar(const Visit& visit, Materials&... materials) {
  visit("stiffness_N_per_m", materials.stiffness_N_per_m...);
  visit("damping_Ns_per_m", materials.damping_Ns_per_m...);
  forEachScalar(visit, materials.surface.scalars...);
}

[[nodiscard]] Pose edited(Pose pose, const PoseEdit& edit);
[[nodiscard]] Material edited(Material material, const MaterialEdit& edit);

}  // namespace haptics
