#include "tests/sim/editor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "common/mesh/moved_vertices.h"
#include "common/surface/field_asset.h"
#include "tests/sim/sim_server.h"

namespace haptics::sim {
namespace {

void refer(Random& random, const ObjectRecord& record, v1::ObjectRef& ref) {
  if (random.chance(0.5)) {
    ref.set_id(record.id);
  } else {
    ref.set_name(record.name);
  }
}

/// Of a box.
void setSides(Random& random, v1::Vector3& size_m) {
  const double side_m = 0.01 * static_cast<double>(1 + random.below(3));
  size_m.set_x(side_m);
  size_m.set_y(side_m);
  size_m.set_z(side_m);
}

}  // namespace

Editor::Editor(Stage& stage, SimClient& client, const Habits& habits)
    : stage_(stage), client_(client), habits_(habits) {
  editLater();
  if (habits.flood == 0) return;
  stage_.time.after(stage_.random.milliseconds(500, 3000), alive_, [this] { flood(); });
}

void Editor::editLater() {
  const double pause_ms = -std::log(1 - stage_.random.uniform(0, 0.999)) * habits_.pause_ms;
  stage_.time.after(stage_.random.milliseconds(pause_ms, pause_ms), alive_, [this] {
    edit();
    editLater();
  });
}

void Editor::edit() {
  const double dice = stage_.random.uniform(0, 1);
  if (dice < 0.50) return increment();
  if (dice < 0.58) return changeSurface();
  if (dice < 0.62) return uploadTexture();
  if (dice < 0.65) return changeMotion();
  if (dice < 0.69) return changeDeformation();
  if (dice < 0.71) return uploadResidue();
  if (dice < 0.75) return paint(false);
  if (dice < 0.80) return paint(true);
  if (dice < 0.87) return addBox();
  if (dice < 0.91) return addUpload();
  if (dice < 0.94) return removeOwn();
  if (dice < 0.98) return moveMany(stage_.random.chance(0.3));
  client_.requestStatus();
}

/// Read, add one, write if nobody wrote in between: one counter or two together.
void Editor::increment() {
  const SceneVersion& scene = client_.mirror().scene();
  const auto& names = SimServer::counters();
  const std::size_t first = stage_.random.below(names.size());
  const std::size_t count = stage_.random.chance(0.25) ? 2 : 1;
  v1::Transaction transaction;
  Intent intent{Intent::Kind::kIncrement, {}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    const auto object = scene.find(names[(first + i) % names.size()]);
    if (!object) return;  // not joined yet
    v1::Precondition& precondition = *transaction.add_preconditions();
    refer(stage_.random, *object, *precondition.mutable_object());
    precondition.set_expected_revision(object->revision);
    if (habits_.checksHashes || stage_.random.chance(0.2)) {
      precondition.set_expected_hash(object->hash().asBytes());
    }
    v1::SetPose& set = *transaction.add_operations()->mutable_set_pose();
    refer(stage_.random, *object, *set.mutable_object());
    set.mutable_pose()->mutable_position()->set_x(object->pose.position.x + 1);
    set.mutable_pose()->mutable_position()->set_y(object->pose.position.y);
    set.mutable_pose()->mutable_position()->set_z(object->pose.position.z);
    intent.counters.push_back(object->name);
    if (!stage_.random.chance(0.2)) continue;
    v1::RemeshObject& remesh = *transaction.add_operations()->mutable_remesh();  // which may have to be prepared
    refer(stage_.random, *object, *remesh.mutable_object());
    setSides(stage_.random, *remesh.mutable_mesh()->mutable_box()->mutable_size_m());
  }
  client_.submit(std::move(transaction), std::move(intent));
}

/// An edit of an object's material, still without a change.
struct Editor::MaterialEdit {
  std::string object;
  v1::Transaction transaction;
  [[nodiscard]] v1::Material& material() {
    return *transaction.mutable_operations(0)->mutable_set_material()->mutable_material();
  }
};

/// Of any object; none before the client has joined.
std::optional<Editor::MaterialEdit> Editor::someMaterial() {
  const auto& objects = client_.mirror().scene().objects();
  if (objects.empty()) return std::nullopt;
  const ObjectRecord& object = *objects[stage_.random.below(objects.size())];
  v1::Transaction transaction;
  v1::SetMaterial& set = *transaction.add_operations()->mutable_set_material();
  refer(stage_.random, object, *set.mutable_object());
  return MaterialEdit{object.name, std::move(transaction)};
}

/// An absolute value, whatever was there before; if doomed, with an operation behind it that cannot be.
void Editor::paint(bool doomed) {
  auto edit = someMaterial();
  if (!edit) return;
  edit->material().mutable_color()->set_red(static_cast<float>(stage_.random.uniform(0, 1)));
  if (doomed) edit->transaction.add_operations()->mutable_remove()->mutable_object()->set_name("nowhere");
  client_.submit(std::move(edit->transaction),
                 {doomed ? Intent::Kind::kDoomed : Intent::Kind::kBlind, {}, edit->object});
}

void Editor::addBox() {
  v1::Transaction transaction;
  v1::AddObject& add = *transaction.add_operations()->mutable_add();
  add.set_name(freshName());
  setSides(stage_.random, *add.mutable_mesh()->mutable_box()->mutable_size_m());
  client_.submit(std::move(transaction), {Intent::Kind::kBlind, {}, {}});
}

/// The edit that names the upload may be refused: the server holds a mesh for the connection that brought it only.
void Editor::addUpload() {
  const TriMesh mesh = makeBox(Vec3(stage_.random.uniform(0.01, 0.1)), 1).value();
  client_.upload(AssetKind::kMesh, encodeMesh(mesh),
                 [this, hash = hashOf(mesh), alive = std::weak_ptr(alive_)](bool accepted) {
                   if (!accepted || alive.expired()) return;
                   v1::Transaction transaction;
                   v1::AddObject& add = *transaction.add_operations()->mutable_add();
                   add.set_name(freshName());
                   add.mutable_mesh()->set_asset(hash.asBytes());
                   client_.submit(std::move(transaction), {Intent::Kind::kBlind, {}, {}});
                 });
}

/// Gives an object a property of its surface, or takes it away.
void Editor::changeSurface() {
  auto edit = someMaterial();
  if (!edit) return;
  v1::Material& material = edit->material();
  switch (stage_.random.below(4)) {
    case 0:
      material.mutable_shading()->set_crease_rad(stage_.random.uniform(0.1, 3));
      break;
    case 1: {
      v1::Friction& friction = *material.mutable_friction();
      friction.set_mu_static(stage_.random.uniform(0.5, 1));
      friction.set_mu_dynamic(stage_.random.uniform(0, 0.5));
      constexpr int kBoxVertices = 8;
      for (int i = 0; i < kBoxVertices; ++i) {
        friction.mutable_per_vertex()->mutable_values()->add_value(static_cast<float>(stage_.random.below(3)));
      }
      break;
    }
    case 2: {
      v1::Texture& texture = *material.mutable_texture();
      texture.set_amplitude_m(stage_.random.uniform(1e-4, 1e-3));
      texture.mutable_field()->mutable_grain()->set_grain_m(stage_.random.uniform(1e-3, 1e-2));
      break;
    }
    default:
      material.mutable_friction();
      material.mutable_texture();
  }
  client_.submit(std::move(edit->transaction), {Intent::Kind::kBlind, {}, edit->object});
}

/// Lets an object move, differently, or no longer.
void Editor::changeMotion() {
  auto edit = someMaterial();
  if (!edit) return;
  v1::Operation& operation = *edit->transaction.mutable_operations(0);
  const v1::ObjectRef object = operation.set_material().object();
  v1::SetMotion& set = *operation.mutable_set_motion();
  *set.mutable_object() = object;
  const std::uint64_t kind = stage_.random.below(6);
  if (kind == 5) set.mutable_motion()->mutable_tool()->set_spacing_m(stage_.random.uniform(0.01, 0.1));
  if (kind > 1 && kind < 5) set.mutable_motion()->set_mass_kg(stage_.random.uniform(0.01, 1));
  if (kind == 1) set.mutable_motion()->set_fixed(true);
  if (kind == 1 || kind == 2) set.mutable_motion()->mutable_collision()->set_friction(stage_.random.uniform(0, 1));
  if (kind == 3) set.mutable_motion()->mutable_hinge()->mutable_axis()->set_z(1);
  client_.submit(std::move(edit->transaction), {Intent::Kind::kBlind, {}, edit->object});
}

/// An edit of how an object's shape gives, still without one.
struct Editor::DeformationEdit {
  std::string object;
  v1::Transaction transaction;
  [[nodiscard]] v1::Deformation& deformation() {
    return *transaction.mutable_operations(0)->mutable_set_deformation()->mutable_deformation();
  }
};

/// Of any object; none before the client has joined.
std::optional<Editor::DeformationEdit> Editor::someDeformation() {
  const auto& objects = client_.mirror().scene().objects();
  if (objects.empty()) return std::nullopt;
  const ObjectRecord& object = *objects[stage_.random.below(objects.size())];
  v1::Transaction transaction;
  refer(stage_.random, object, *transaction.add_operations()->mutable_set_deformation()->mutable_object());
  return DeformationEdit{object.name, std::move(transaction)};
}

/// Lets an object give, differently, or no longer.
void Editor::changeDeformation() {
  auto edit = someDeformation();
  if (!edit) return;
  v1::Deformation& deformation = edit->deformation();
  switch (stage_.random.below(5)) {
    case 0: {
      v1::Lattice& lattice = *deformation.mutable_lattice();
      lattice.set_points_x(2);
      lattice.set_points_y(2);
      lattice.set_points_z(2);
      constexpr int kNumbers = 24;
      for (int i = 0; i < kNumbers; ++i) lattice.add_control_m(static_cast<float>(stage_.random.uniform(-0.1, 0.1)));
      break;
    }
    case 1:
      deformation.mutable_softness();
      deformation.mutable_lattice();
      break;
    case 2:
      deformation.mutable_residue();
      break;
    default: {
      v1::Softness& softness = *deformation.mutable_softness();
      softness.set_stiffness_n_per_m(stage_.random.uniform(100, 500));
      softness.set_radius_m(stage_.random.uniform(0.005, 0.01));
      if (stage_.random.chance(0.7)) softness.set_plastic(stage_.random.uniform(0.1, 1));
    }
  }
  client_.submit(std::move(edit->transaction), {Intent::Kind::kBlind, {}, edit->object});
}

/// The edit that names it may be refused: no server but this connection's holds it, and the mesh may lack such vertices.
void Editor::uploadResidue() {
  MovedVertices moved;
  for (std::uint32_t vertex = 0; vertex < 10; ++vertex) {
    if (stage_.random.chance(0.5)) moved.vertex.push_back(vertex);
  }
  moved.vertex.push_back(10);
  if (stage_.random.chance(0.8)) moved.vertex.back() = 7;
  std::ranges::sort(moved.vertex);
  moved.vertex.erase(std::ranges::unique(moved.vertex).begin(), moved.vertex.end());
  for (std::size_t i = 0; i < moved.vertex.size(); ++i) {
    moved.place.emplace_back(static_cast<float>(stage_.random.uniform(-0.1, 0.1)));
  }
  client_.upload(AssetKind::kMovedVertices, encodeMovedVertices(moved),
                 [this, hash = hashOf(moved), alive = std::weak_ptr(alive_)](bool accepted) {
                   if (!accepted || alive.expired()) return;
                   auto edit = someDeformation();
                   if (!edit) return;
                   edit->deformation().mutable_residue()->set_asset(hash.asBytes());
                   client_.submit(std::move(edit->transaction), {Intent::Kind::kBlind, {}, edit->object});
                 });
}

/// As with a mesh, the edit that names the upload may be refused.
void Editor::uploadTexture() {
  std::vector<float> samples(4);
  for (float& sample : samples) sample = static_cast<float>(stage_.random.below(8)) / 8;
  const SampledField field = SampledField::make(2, 2, std::move(samples)).value();
  const auto named = [this, hash = hashOf(field), alive = std::weak_ptr(alive_)](bool accepted) {
    if (!accepted || alive.expired()) return;
    auto edit = someMaterial();
    if (!edit) return;
    v1::Texture& texture = *edit->material().mutable_texture();
    texture.set_amplitude_m(1e-3);
    v1::MappedField& mapped = *texture.mutable_field()->mutable_mapped();
    mapped.set_asset(hash.asBytes());
    mapped.mutable_mapping()->set_shape(v1::MAPPING_SHAPE_CUBE);
    mapped.mutable_mapping()->set_tile_m(0.01);
    client_.submit(std::move(edit->transaction), {Intent::Kind::kBlind, {}, edit->object});
  };
  client_.upload(AssetKind::kScalarField, encodeField(field), named);
}

void Editor::removeOwn() {
  if (own_.empty()) return;
  v1::Transaction transaction;
  transaction.add_operations()->mutable_remove()->mutable_object()->set_name(own_.front());
  own_.pop_front();
  client_.submit(std::move(transaction), {Intent::Kind::kBlind, {}, {}});
}

/// Of the start scene's; if doomed, each at a revision that it never had.
void Editor::moveMany(bool doomed) {
  const std::size_t all = stage_.limits.startObjects;
  if (all == 0) return client_.requestStatus();
  v1::Transaction transaction;
  const std::size_t count = 1 + stage_.random.below(2 * all);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = SimServer::startObject(stage_.random.below(all));
    v1::SetPose& set = *transaction.add_operations()->mutable_set_pose();
    set.mutable_object()->set_name(name);
    set.mutable_pose()->mutable_position()->set_y(stage_.random.uniform(-1, 1));
    if (!doomed) continue;
    v1::Precondition& never = *transaction.add_preconditions();
    never.mutable_object()->set_name(name);
    never.set_expected_revision(std::numeric_limits<std::uint32_t>::max());
  }
  client_.submit(std::move(transaction), {doomed ? Intent::Kind::kDoomed : Intent::Kind::kBlind, {}, {}});
}

void Editor::flood() {
  for (std::size_t i = 0; i < habits_.flood; ++i) paint(false);
}

std::string Editor::freshName() {
  own_.push_back("of" + std::to_string(client_.id() % 1000) + "." + std::to_string(++made_));
  return own_.back();
}

}  // namespace haptics::sim
