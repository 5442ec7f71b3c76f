#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/unknown_field_set.h>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

namespace pb = google::protobuf;

std::string indexed(const char* field, int index) { return std::string(field) + "[" + std::to_string(index) + "]"; }

/// Fields, at any depth, that this version does not know.
Refusal checkKnown(const pb::Message& message, const std::string& path) {
  const pb::Reflection& reflection = *message.GetReflection();
  if (const auto& unknown = reflection.GetUnknownFields(message); !unknown.empty()) {
    return Error{path + "#" + std::to_string(unknown.field(0).number()),
                 "is a field that this server does not know; the client is newer than the server"};
  }
  std::vector<const pb::FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const pb::FieldDescriptor* field : set) {
    if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      if (auto bad = checkKnown(reflection.GetMessage(message, field), path + field->name() + ".")) return bad;
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      const std::string at = path + indexed(field->name().c_str(), i) + ".";
      if (auto bad = checkKnown(reflection.GetRepeatedMessage(message, field, i), at)) return bad;
    }
  }
  return std::nullopt;
}

Result<ObjectRef> refFrom(const v1::ObjectRef& message) {
  switch (message.ref_case()) {
    case v1::ObjectRef::kId:
      if (message.id() == 0) return refused("object.id", "is 0; ids start at 1");
      return ObjectRef{message.id()};
    case v1::ObjectRef::kName:
      if (auto bad = checkName(message.name(), "object.name")) return refuse(bad);
      return ObjectRef{message.name()};
    case v1::ObjectRef::REF_NOT_SET:
      break;
  }
  return refused("object", "is missing; give its id or its name");
}

Result<MeshSource> fileFrom(const v1::MeshSource& message) {
  const std::string& path = message.file();
  if (auto bad = checkFilePath(path, "file")) return refuse(bad);
  if (message.has_unit_m() && message.has_largest_extent_m()) {
    return refused("largest_extent_m", "is given beside unit_m; give one of them");
  }
  MeshSource mesh{FileSource{path}};
  if (message.has_unit_m()) {
    if (auto bad = checkLength(message.unit_m(), "unit_m")) return refuse(bad);
    mesh.unit_m = message.unit_m();
  }
  if (message.has_largest_extent_m()) {
    if (auto bad = checkLength(message.largest_extent_m(), "largest_extent_m")) return refuse(bad);
    mesh.largestExtent_m = message.largest_extent_m();
  }
  mesh.keepCrossings = message.keep_crossings();
  if (message.has_part()) {
    if (message.part().empty() || message.part().size() > PartName::kLongest) {
      return refused("part", "has " + std::to_string(message.part().size()) + " bytes; a name of 1 to " +
                                 std::to_string(PartName::kLongest) + ", or a number from 0, is wanted");
    }
    mesh.part = PartName(message.part());
  }
  return mesh;
}

/// 0, which is how an absent number arrives, stands for the default.
Refusal readSegments(std::uint32_t given, std::uint32_t atLeast, const std::string& field, std::uint32_t& segments) {
  if (given == 0) return std::nullopt;
  if (given < atLeast || given > kMaxSegments) {
    return Error{field, "is " + std::to_string(given) + "; give " + std::to_string(atLeast) + " to " +
                            std::to_string(kMaxSegments) + ", or leave it out"};
  }
  segments = given;
  return std::nullopt;
}

constexpr std::uint32_t kMinAround = 3;  // segments that close around an axis

Result<MeshSource> boxFrom(const v1::Box& message) {
  BoxSource box{.size_m = vectorFrom(message.size_m())};
  if (!message.has_size_m()) return refused("box.size_m", "is missing; give x, y and z");
  if (auto bad = checkSize(message.size_m(), "box.size_m")) return refuse(bad);
  if (auto bad = readSegments(message.segments(), 1, "box.segments", box.segments)) return refuse(bad);
  return MeshSource{box};
}

Result<MeshSource> sphereFrom(const v1::Sphere& message) {
  SphereSource sphere{.radius_m = message.radius_m()};
  if (auto bad = checkLength(sphere.radius_m, "sphere.radius_m")) return refuse(bad);
  if (auto bad = readSegments(message.segments(), 1, "sphere.segments", sphere.segments)) return refuse(bad);
  return MeshSource{sphere};
}

Result<MeshSource> cylinderFrom(const v1::Cylinder& message) {
  CylinderSource cylinder{.radius_m = message.radius_m(), .height_m = message.height_m()};
  if (auto bad = checkLength(cylinder.radius_m, "cylinder.radius_m")) return refuse(bad);
  if (auto bad = checkLength(cylinder.height_m, "cylinder.height_m")) return refuse(bad);
  if (auto bad = readSegments(message.segments(), kMinAround, "cylinder.segments", cylinder.segments)) {
    return refuse(bad);
  }
  return MeshSource{cylinder};
}

Result<MeshSource> torusFrom(const v1::Torus& message) {
  TorusSource torus{.majorRadius_m = message.major_radius_m(), .minorRadius_m = message.minor_radius_m()};
  if (auto bad = checkLength(torus.majorRadius_m, "torus.major_radius_m")) return refuse(bad);
  if (auto bad = checkLength(torus.minorRadius_m, "torus.minor_radius_m")) return refuse(bad);
  if (torus.minorRadius_m >= torus.majorRadius_m) {
    return refused("torus.minor_radius_m", "is not below major_radius_m; the ring would cut itself");
  }
  const std::uint32_t major = message.major_segments();
  const std::uint32_t minor = message.minor_segments();
  if (auto bad = readSegments(major, kMinAround, "torus.major_segments", torus.majorSegments)) return refuse(bad);
  if (auto bad = readSegments(minor, kMinAround, "torus.minor_segments", torus.minorSegments)) return refuse(bad);
  return MeshSource{torus};
}

Result<MeshSource> wholeMeshFrom(const v1::MeshSource& message) {
  if (message.source_case() == v1::MeshSource::kFile) return fileFrom(message);
  if (message.has_unit_m()) return refused("unit_m", "is for files only; other meshes are in metres");
  if (message.has_largest_extent_m()) return refused("largest_extent_m", "is for files only; give the size itself");
  if (message.has_part()) return refused("part", "is for files only; other meshes are one");
  if (message.has_keep_crossings())
    return refused("keep_crossings", "is for files only; other meshes are left as they are");
  switch (message.source_case()) {
    case v1::MeshSource::kAsset:
      return hashFromWire(message.asset(), "asset").map([](const ContentHash& hash) {
        return MeshSource{AssetSource{hash}};
      });
    case v1::MeshSource::kBox:
      return boxFrom(message.box());
    case v1::MeshSource::kSphere:
      return sphereFrom(message.sphere());
    case v1::MeshSource::kCylinder:
      return cylinderFrom(message.cylinder());
    case v1::MeshSource::kTorus:
      return torusFrom(message.torus());
    default:
      return refused("source", "is missing; give file, asset, box, sphere, cylinder or torus");
  }
}

Result<MeshSource> meshFrom(const v1::MeshSource& message) {
  auto mesh = wholeMeshFrom(message);
  if (!mesh || !message.has_simplify()) return mesh;
  const double error = message.simplify().error();
  if (auto bad =
          checkAbove0(error, {kMinSimplifyError, kMaxSimplifyError, ", where 1 is just noticeable"}, "simplify.error"))
    return refuse(bad);
  mesh->simplifyError = error;
  return mesh;
}

Result<PoseEdit> poseEditFrom(const v1::Pose& message) {
  PoseEdit edit;
  if (message.has_position()) {
    if (auto bad = checkPosition(message.position(), "pose.position")) return refuse(bad);
    edit.position = vectorFrom(message.position());
  }
  if (message.has_rotation()) {
    if (auto bad = checkRotation(message.rotation(), "pose.rotation")) return refuse(bad);
    edit.rotation = normalised(rotationFrom(message.rotation()));
  }
  return edit;
}

Result<MaterialEdit> materialFrom(const v1::Material& message) {
  MaterialEdit edit;
  if (message.has_color()) {
    if (auto bad = checkColor(message.color(), "material.color")) return refuse(bad);
    edit.color = Color{message.color().red(), message.color().green(), message.color().blue()};
  }
  if (auto bad = take(surfaceFrom(message), edit.surface, "material.")) return refuse(bad);
  Refusal first;
  const auto read = [&](std::string_view name, std::optional<double>& value) {
    const pb::FieldDescriptor& scalar = materialScalar(name);
    if (first || !message.GetReflection()->HasField(message, &scalar)) return;
    value = message.GetReflection()->GetDouble(message, &scalar);
    first = checkScalar(*value, scalar, "material." + scalar.name());
  };
  forEachMaterialScalar(read, edit);
  if (first) return refuse(first);
  return edit;
}

Result<Operation> addFrom(const v1::AddObject& message) {
  AddObject add;
  add.name = message.name();
  if (auto bad = checkName(message.name(), "name")) return refuse(bad);
  if (auto bad = take(meshFrom(message.mesh()), add.mesh, "mesh.")) return refuse(bad);
  if (auto bad = take(poseEditFrom(message.pose()), add.pose)) return refuse(bad);
  if (auto bad = take(materialFrom(message.material()), add.material)) return refuse(bad);
  if (message.has_motion()) {
    if (auto bad = take(motionFrom(message.motion()), add.motion, "motion.")) return refuse(bad);
  }
  if (auto bad = take(deformationFrom(message.deformation()), add.deformation, "deformation.")) return refuse(bad);
  if (auto bad = take(effectsFrom(message.effects()), add.effects)) return refuse(bad);
  return add;
}

Result<Operation> removeFrom(const v1::RemoveObject& message) {
  RemoveObject remove;
  if (auto bad = take(refFrom(message.object()), remove.object)) return refuse(bad);
  return remove;
}

Result<Operation> remeshFrom(const v1::RemeshObject& message) {
  RemeshObject remesh;
  if (auto bad = take(refFrom(message.object()), remesh.object)) return refuse(bad);
  if (auto bad = take(meshFrom(message.mesh()), remesh.mesh, "mesh.")) return refuse(bad);
  return remesh;
}

Result<Operation> setPoseFrom(const v1::SetPose& message) {
  SetPose set;
  if (auto bad = take(refFrom(message.object()), set.object)) return refuse(bad);
  if (auto bad = take(poseEditFrom(message.pose()), set.pose)) return refuse(bad);
  if (!set.pose.position && !set.pose.rotation) return refused("pose", "is empty; give position, rotation or both");
  set.kinematic = message.kinematic();
  return set;
}

Result<Operation> setMaterialFrom(const v1::SetMaterial& message) {
  SetMaterial set;
  if (auto bad = take(refFrom(message.object()), set.object)) return refuse(bad);
  if (auto bad = take(materialFrom(message.material()), set.material)) return refuse(bad);
  const MaterialEdit& material = set.material;
  if (!material.stiffness_N_per_m && !material.damping_Ns_per_m && !material.color && material.surface.empty()) {
    return refused("material", "is empty; give what is to change");
  }
  return set;
}

Result<Operation> setMotionFrom(const v1::SetMotion& message) {
  SetMotion set;
  if (auto bad = take(refFrom(message.object()), set.object)) return refuse(bad);
  if (message.motion().ByteSizeLong() == 0) return set;
  if (auto bad = take(motionFrom(message.motion()), set.motion, "motion.")) return refuse(bad);
  return set;
}

Result<Operation> setDeformationFrom(const v1::SetDeformation& message) {
  SetDeformation set;
  if (auto bad = take(refFrom(message.object()), set.object)) return refuse(bad);
  if (auto bad = take(deformationFrom(message.deformation()), set.deformation, "deformation.")) return refuse(bad);
  if (set.deformation.empty()) return refused("deformation", "is empty; give softness, lattice or residue");
  set.kinematic = message.kinematic();
  return set;
}

Result<Operation> setEffectsFrom(const v1::SetEffects& message) {
  SetEffects set;
  if (auto bad = take(refFrom(message.object()), set.object)) return refuse(bad);
  if (auto bad = take(effectsFrom(message.effects()), set.effects)) return refuse(bad);
  return set;
}

Result<Operation> operationFrom(const v1::Operation& message) {
  const auto in = [](const std::string& prefix, Result<Operation> operation) {
    return std::move(operation).map_error([&](Error error) { return std::move(error).within(prefix); });
  };
  switch (message.op_case()) {
    case v1::Operation::kAdd:
      return in("add.", addFrom(message.add()));
    case v1::Operation::kRemove:
      return in("remove.", removeFrom(message.remove()));
    case v1::Operation::kRemesh:
      return in("remesh.", remeshFrom(message.remesh()));
    case v1::Operation::kSetPose:
      return in("set_pose.", setPoseFrom(message.set_pose()));
    case v1::Operation::kSetMaterial:
      return in("set_material.", setMaterialFrom(message.set_material()));
    case v1::Operation::kSetMotion:
      return in("set_motion.", setMotionFrom(message.set_motion()));
    case v1::Operation::kSetDeformation:
      return in("set_deformation.", setDeformationFrom(message.set_deformation()));
    case v1::Operation::kSetEffects:
      return in("set_effects.", setEffectsFrom(message.set_effects()));
    case v1::Operation::OP_NOT_SET:
      break;
  }
  return refused(
      "op", "is missing; give add, remove, remesh, set_pose, set_material, set_motion, set_deformation or set_effects");
}

Result<Precondition> preconditionFrom(const v1::Precondition& message) {
  Precondition precondition;
  precondition.expectedRevision = message.expected_revision();
  if (auto bad = take(refFrom(message.object()), precondition.object)) return refuse(bad);
  if (message.expected_hash().empty()) return precondition;
  const auto hash = hashFromWire(message.expected_hash(), "expected_hash");
  if (auto bad = take(hash, precondition.expectedHash)) return refuse(bad);
  return precondition;
}

Refusal checkCount(int count, const char* field) {
  if (static_cast<std::size_t>(count) <= kMaxOperations) return std::nullopt;
  return Error{field, "has " + std::to_string(count) + " entries; at most " + std::to_string(kMaxOperations) +
                          " go into one transaction"};
}

}  // namespace

Result<Transaction> fromWire(const v1::Transaction& message) {
  if (message.operations().empty()) return refused("operations", "is empty; give at least one");
  if (auto bad = checkCount(message.operations_size(), "operations")) return refuse(bad);
  if (auto bad = checkCount(message.preconditions_size(), "preconditions")) return refuse(bad);
  if (auto bad = checkKnown(message, "")) return refuse(bad);

  Transaction transaction;
  for (int i = 0; i < message.preconditions_size(); ++i) {
    Precondition& precondition = transaction.preconditions.emplace_back();
    const std::string at = indexed("preconditions", i) + ".";
    if (auto bad = take(preconditionFrom(message.preconditions(i)), precondition, at)) return refuse(bad);
  }
  for (int i = 0; i < message.operations_size(); ++i) {
    Operation& operation = transaction.operations.emplace_back();
    const std::string at = indexed("operations", i) + ".";
    if (auto bad = take(operationFrom(message.operations(i)), operation, at)) return refuse(bad);
  }
  return transaction;
}

}  // namespace haptics
