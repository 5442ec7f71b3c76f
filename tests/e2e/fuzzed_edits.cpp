#include "tests/e2e/fuzzed_edits.h"

#include <algorithm>
#include <optional>

#include "common/mesh/mesh_asset.h"
#include "tests/eval/fuzz/edit_scene.h"

namespace haptics::e2e {
namespace {

using eval::FuzzObject;

constexpr double kSliding = 0.7;  // of the static friction, as the fuzzer has it

eval::EditRun drawnFrom(std::uint64_t seed) {
  eval::EditScene scene(seed);
  for (int i = 0; i < eval::EditScene::kEdits; ++i) static_cast<void>(scene.next());
  eval::EditRun run = scene.run();
  for (eval::FuzzScene& step : run.scenes) {
    for (FuzzObject& object : step.objects) {
      object.mass_kg = 0;
      if (object.tissue) object.tissue->returnTime_s = object.tissue->plastic = 0;
    }
  }
  return run;
}

/// Without the vertices that only what is missing from a scan has.
TriMesh meshOf(const eval::FuzzMesh& from) {
  TriMesh mesh{{}, from.triangles};
  std::vector<std::optional<std::uint32_t>> numbers(from.vertices.size());
  for (TriangleIndices& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) {
      std::optional<std::uint32_t>& number = numbers[vertex];
      if (!number) {
        number = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(from.vertices[vertex]);
      }
      vertex = *number;
    }
  }
  return mesh;
}

void set(Vec3 from, v1::Vector3& to) {
  to.set_x(from.x);
  to.set_y(from.y);
  to.set_z(from.z);
}

void set(const Pose& from, v1::Pose& to) {
  set(from.position, *to.mutable_position());
  v1::Quaternion& rotation = *to.mutable_rotation();
  rotation.set_w(from.rotation.w);
  rotation.set_x(from.rotation.x);
  rotation.set_y(from.rotation.y);
  rotation.set_z(from.rotation.z);
}

bool sameTexture(const FuzzObject& a, const FuzzObject& b) {
  return a.textureAmplitude_m == b.textureAmplitude_m && a.textureWavelength_m == b.textureWavelength_m &&
         a.bumpMapped == b.bumpMapped;
}

void setShading(const FuzzObject& object, v1::Shading& shading) {
  if (object.crease_rad > 0) shading.set_crease_rad(object.crease_rad);
}

void setFriction(const FuzzObject& object, v1::Friction& friction) {
  if (object.friction == 0) return;
  friction.set_mu_static(object.friction);
  friction.set_mu_dynamic(kSliding * object.friction);
}

void setTexture(const FuzzObject& object, v1::Texture& texture) {
  if (object.textureAmplitude_m == 0) return;
  texture.set_law(object.bumpMapped ? v1::TEXTURE_LAW_BUMP : v1::TEXTURE_LAW_HO1999);
  texture.mutable_field()->mutable_noise()->set_wavelength_m(object.textureWavelength_m);
  texture.set_amplitude_m(object.textureAmplitude_m);
}

void setSoftness(const FuzzObject& object, v1::Softness& softness) {
  if (!object.tissue) return;
  softness.set_stiffness_n_per_m(object.tissue->stiffness_N_per_m);
  softness.set_radius_m(object.tissue->falloff.radius_m());
  softness.set_degree(object.tissue->falloff.degree());
}

}  // namespace

FuzzedEdits::FuzzedEdits(std::uint64_t seed) : seed_(seed), run_(drawnFrom(seed)) {
  for (const eval::EditRun::Mesh& from : run_.meshes) {
    const TriMesh mesh = meshOf(from.mesh);
    assets_.push_back(encodeMesh(mesh));
    hashes_.push_back(hashOf(mesh).asBytes());
  }
  scene_ = change({}, run_.scenes.front().objects);
  std::size_t next = 1;
  for (const eval::EditWindow& from : run_.windows) {
    Window window{from.edit, run_.hips[from.begin], {}, {}};
    for (; next < run_.scenes.size() && run_.scenes[next].tick < from.end; ++next) {
      const eval::FuzzScene& step = run_.scenes[next];
      v1::Transaction transaction = change(run_.scenes[next - 1].objects, step.objects);
      const double after_s = static_cast<double>(step.tick - from.begin) * run_.period_s();
      if (transaction.operations_size() > 0) window.edits.push_back({after_s, std::move(transaction)});
    }
    window.objects = run_.scenes[next - 1].objects;
    windows_.push_back(std::move(window));
  }
}

v1::Transaction FuzzedEdits::removal(std::size_t window) const { return change(windows_[window].objects, {}); }

/// An object that leaves is removed; the server keeps it as long as it is felt.
v1::Transaction FuzzedEdits::change(const std::vector<FuzzObject>& from, const std::vector<FuzzObject>& to) const {
  v1::Transaction transaction;
  for (const FuzzObject& before : from) {
    const auto after = std::ranges::find(to, before.id, &FuzzObject::id);
    if (before.pendingRemoval) continue;
    if (after == to.end() || after->pendingRemoval) {
      transaction.add_operations()->mutable_remove()->mutable_object()->set_name(nameOf(before));
    } else {
      edit(before, *after, transaction);
    }
  }
  for (const FuzzObject& object : to) {
    if (std::ranges::find(from, object.id, &FuzzObject::id) == from.end()) add(object, transaction);
  }
  return transaction;
}

void FuzzedEdits::add(const FuzzObject& object, v1::Transaction& transaction) const {
  v1::AddObject& add = *transaction.add_operations()->mutable_add();
  add.set_name(nameOf(object));
  setMesh(object, *add.mutable_mesh());
  set(object.pose, *add.mutable_pose());
  v1::Material& material = *add.mutable_material();
  material.set_stiffness_n_per_m(object.stiffness_N_per_m);
  material.set_damping_ns_per_m(object.damping_Ns_per_m);
  if (object.crease_rad > 0) setShading(object, *material.mutable_shading());
  if (object.friction > 0) setFriction(object, *material.mutable_friction());
  if (object.textureAmplitude_m > 0) setTexture(object, *material.mutable_texture());
  if (object.tissue) setSoftness(object, *add.mutable_deformation()->mutable_softness());
}

void FuzzedEdits::edit(const FuzzObject& from, const FuzzObject& to, v1::Transaction& transaction) const {
  if (from.mesh != to.mesh) {
    v1::RemeshObject& remesh = *transaction.add_operations()->mutable_remesh();
    remesh.mutable_object()->set_name(nameOf(to));
    setMesh(to, *remesh.mutable_mesh());
  }
  if (from.poseRevision != to.poseRevision) {
    v1::SetPose& setPose = *transaction.add_operations()->mutable_set_pose();
    setPose.mutable_object()->set_name(nameOf(to));
    set(to.pose, *setPose.mutable_pose());
  }
  v1::Material material;
  if (from.stiffness_N_per_m != to.stiffness_N_per_m) material.set_stiffness_n_per_m(to.stiffness_N_per_m);
  if (from.damping_Ns_per_m != to.damping_Ns_per_m) material.set_damping_ns_per_m(to.damping_Ns_per_m);
  if (from.crease_rad != to.crease_rad) setShading(to, *material.mutable_shading());
  if (from.friction != to.friction) setFriction(to, *material.mutable_friction());
  if (!sameTexture(from, to)) setTexture(to, *material.mutable_texture());
  if (material.ByteSizeLong() > 0) {
    v1::SetMaterial& setMaterial = *transaction.add_operations()->mutable_set_material();
    setMaterial.mutable_object()->set_name(nameOf(to));
    *setMaterial.mutable_material() = std::move(material);
  }
  if (from.tissue != to.tissue) {
    v1::SetDeformation& setDeformation = *transaction.add_operations()->mutable_set_deformation();
    setDeformation.mutable_object()->set_name(nameOf(to));
    setSoftness(to, *setDeformation.mutable_deformation()->mutable_softness());
  }
}

std::string FuzzedEdits::nameOf(const FuzzObject& object) const {
  return std::to_string(seed_) + '-' + std::to_string(object.id);
}

void FuzzedEdits::setMesh(const FuzzObject& object, v1::MeshSource& mesh) const {
  mesh.set_asset(hashes_[object.mesh]);
}

}  // namespace haptics::e2e
