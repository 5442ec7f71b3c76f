#include "tests/eval/fuzz/random_edits.h"

#include <google/protobuf/descriptor.h>

#include <cmath>
#include <numbers>
#include <string_view>

#include "common/wire/convert.h"
#include "haptics/v1/options.pb.h"

namespace haptics::eval {
namespace {

constexpr std::size_t kMostObjects = 8;
constexpr double kReach_m = 0.04;  // of the objects' places

}  // namespace

double RandomEdits::spread(double low, double high) { return std::exp(random_.between(std::log(low), std::log(high))); }

void RandomEdits::set(v1::Vector3& to, Vec3 from) {
  to.set_x(from.x);
  to.set_y(from.y);
  to.set_z(from.z);
}

void RandomEdits::setWithin(v1::Vector3& to, double most) {
  const double x = random_.between(-most, most);
  const double y = random_.between(-most, most);
  set(to, {x, y, random_.between(-most, most)});
}

void RandomEdits::setDirection(v1::Vector3& to) {
  set(to, chance(0.5) ? one({Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) : random_.direction());
}

void RandomEdits::addMesh(v1::MeshSource& mesh) {
  switch (random_.below(4)) {
    case 0:
      set(*mesh.mutable_box()->mutable_size_m(), {spread(0.005, 0.1), spread(0.005, 0.1), spread(0.005, 0.1)});
      mesh.mutable_box()->set_segments(one({1U, 1U, 4U, 12U}));
      break;
    case 1:
      mesh.mutable_sphere()->set_radius_m(spread(0.005, 0.05));
      mesh.mutable_sphere()->set_segments(one({1U, 2U, 8U, 16U}));
      break;
    case 2:
      mesh.mutable_cylinder()->set_radius_m(spread(0.005, 0.04));
      mesh.mutable_cylinder()->set_height_m(spread(0.005, 0.1));
      mesh.mutable_cylinder()->set_segments(one({3U, 16U, 48U}));
      break;
    default:
      mesh.mutable_torus()->set_major_radius_m(spread(0.02, 0.05));
      mesh.mutable_torus()->set_minor_radius_m(spread(0.002, 0.018));
      mesh.mutable_torus()->set_major_segments(one({3U, 24U}));
      mesh.mutable_torus()->set_minor_segments(one({3U, 12U}));
  }
}

void RandomEdits::addPose(v1::Pose& pose) {
  if (chance(0.85)) setWithin(*pose.mutable_position(), kReach_m);
  if (!chance(0.5)) return;
  const Quat q = random_.rotation();
  v1::Quaternion& rotation = *pose.mutable_rotation();
  rotation.set_w(q.w);
  rotation.set_x(q.x);
  rotation.set_y(q.y);
  rotation.set_z(q.z);
}

void RandomEdits::addMapped(v1::MappedField& mapped) {
  if (chance(0.5)) {
    v1::ReactionDiffusion& source = *mapped.mutable_reaction_diffusion();
    source.set_cells(2);
    source.set_resolution(32);
    source.set_pattern(one({v1::REACTION_DIFFUSION_PATTERN_SPOTS, v1::REACTION_DIFFUSION_PATTERN_STRIPES}));
    source.set_seed(static_cast<std::uint32_t>(random_.below(3)));
  } else {
    v1::SpotNoise& source = *mapped.mutable_spot_noise();
    source.set_cells(2);
    source.set_resolution(32);
    source.set_elongation(one({1.0, 8.0}));
  }
  v1::Mapping& mapping = *mapped.mutable_mapping();
  mapping.set_shape(
      one({v1::MAPPING_SHAPE_PLANE, v1::MAPPING_SHAPE_CUBE, v1::MAPPING_SHAPE_CYLINDER, v1::MAPPING_SHAPE_SPHERE}));
  mapping.set_tile_m(spread(1e-3, 0.2));
  if (chance(0.4)) setWithin(*mapping.mutable_centre(), 0.02);
  if (chance(0.4)) set(*mapping.mutable_size_m(), Vec3(spread(0.01, 0.2)));
}

void RandomEdits::addField(v1::ScalarField& field, bool layered) {
  switch (random_.below(layered ? 5 : 7)) {
    case 0:
      for (int i = one({1, 2, 16}); i > 0; --i) {
        v1::FourierTerm& term = *field.mutable_fourier()->add_terms();
        setDirection(*term.mutable_direction());
        term.set_amplitude(one({1.0, 0.5, -1000.0, 1e-9}));
        term.set_wavelength_m(spread(2e-4, 0.5));
        term.set_phase_rad(random_.between(-10, 10));
      }
      break;
    case 1:
      field.mutable_noise()->set_wavelength_m(spread(5e-4, 0.5));
      field.mutable_noise()->set_octaves(one({1U, 4U, 12U}));
      field.mutable_noise()->set_persistence(one({1.0, 0.5, 1e-3}));
      field.mutable_noise()->set_seed(static_cast<std::uint32_t>(random_.below(5)));
      break;
    case 2:
      field.mutable_cellular()->set_cell_m(spread(5e-4, 0.2));
      field.mutable_cellular()->set_smoothness(one({1.0, 0.1, 1e-6}));
      break;
    case 3:
      field.mutable_grain()->set_grain_m(spread(5e-4, 0.2));
      break;
    case 4:
      addMapped(*field.mutable_mapped());
      break;
    case 5:
      field.mutable_layers()->set_combination(one({v1::LAYER_COMBINATION_SUM, v1::LAYER_COMBINATION_PRODUCT}));
      for (int i = one({2, 3, 4}); i > 0; --i) {
        v1::FieldLayer& layer = *field.mutable_layers()->add_layer();
        layer.set_weight(one({1.0, -2.0, 0.5}));
        addField(*layer.mutable_field(), true);
      }
      break;
    default:
      field.mutable_grown()->mutable_reaction_diffusion()->set_wavelength_m(spread(0.02, 0.05));
  }
}

void RandomEdits::addMap(v1::SurfaceMap& map) {
  if (chance(0.1)) return;  // takes it away
  map.set_variation(one({10.0, -10.0, 0.5, -0.5, 1e-4}));
  addField(*map.mutable_field(), false);
}

void RandomEdits::addFriction(v1::Friction& friction) {
  if (chance(0.1)) return;
  friction.set_mu_static(one({10.0, 0.5, 0.3, 1e-6}));
  friction.set_mu_dynamic(friction.mu_static() * one({1.0, 0.5, 0.0}));
  if (!chance(0.4)) return;
  friction.set_variation(one({10.0, -10.0, 0.5}));
  addField(*friction.mutable_field(), false);
  if (!chance(0.4)) return;
  friction.set_dynamic_variation(one({10.0, -1.0, 0.5}));
  addField(*friction.mutable_dynamic_field(), false);
}

void RandomEdits::addMaterial(v1::Material& material) {
  if (chance(0.7)) material.set_stiffness_n_per_m(spread(5, 1e5));
  if (chance(0.5)) material.set_damping_ns_per_m(spread(0.01, 1e3));
  if (chance(0.25)) {
    v1::Shading& shading = *material.mutable_shading();
    if (chance(0.85)) shading.set_crease_rad(one({std::numbers::pi, 0.5, 1e-6}));
  }
  if (chance(0.35)) addFriction(*material.mutable_friction());
  if (chance(0.3)) {
    v1::Texture& texture = *material.mutable_texture();
    if (chance(0.9)) {
      texture.set_law(one({v1::TEXTURE_LAW_HO1999, v1::TEXTURE_LAW_BUMP}));
      texture.set_amplitude_m(spread(1e-5, 3e-3));
      texture.set_literal(chance(0.3));
      addField(*texture.mutable_field(), false);
      if (chance(0.5)) texture.set_gain_k(one({2.0, 1.0, 1e-6}));
    }
  }
  if (chance(0.25)) addMap(*material.mutable_stiffness_over());
  if (chance(0.2)) addMap(*material.mutable_softness_over());
  const auto setScalar = [&](std::string_view name, double /*none*/) {
    const auto& field = materialScalar(name);
    const double most = field.options().GetExtension(v1::scalar).most();
    if (chance(0.3)) material.GetReflection()->SetDouble(&material, &field, one({most, most / 4, 0.0}));
  };
  const SurfaceScalars<double> none;
  forEachScalar(setScalar, none);
}

void RandomEdits::addJoint(v1::Joint& joint) {
  setWithin(*joint.mutable_anchor_m(), 0.05);
  setDirection(*joint.mutable_axis());
  if (chance(0.6)) joint.set_lowest(one({0.0, -0.02, -1.0}));
  if (chance(0.6)) joint.set_highest(one({0.0, 0.02, 1.0}));
}

void RandomEdits::addMotion(v1::Motion& motion) {
  if (chance(0.15)) return;
  const int kind = random_.below(7);
  if (chance(0.5)) {
    v1::Collision& collision = *motion.mutable_collision();
    if (chance(0.5)) collision.set_friction(one({0.0, 0.5, 10.0}));
    if (chance(0.5)) collision.set_rolling_m(one({0.0, 0.1}));
  }
  if (kind == 5) {
    motion.set_fixed(true);
    return;
  }
  if (kind == 6) {
    motion.clear_collision();
    motion.mutable_tool()->set_spacing_m(one({0.002, 0.005, 0.02}));
    if (chance(0.5)) motion.mutable_tool()->set_torsion_nm_per_rad(one({1000.0, 1.0, 0.05}));
    return;
  }
  motion.set_mass_kg(one({0.1, 0.01, 1.0, 1e-4, 10.0, 1e-9}));
  if (chance(0.6)) setWithin(*motion.mutable_gravity_m_per_s2(), one({0.0, 0.5, 10.0}));
  if (chance(0.5)) motion.set_linear_damping_per_s(spread(0.1, 100));
  if (chance(0.5)) motion.set_angular_damping_per_s(spread(0.1, 100));
  if (chance(0.3)) {
    setWithin(*motion.mutable_inertia()->mutable_centre_m(), 0.01);
    set(*motion.mutable_inertia()->mutable_moments(), Vec3(spread(1e-7, 1e-3)));
  }
  if (chance(0.6)) {
    v1::PoseSpring& spring = *motion.mutable_spring();
    spring.set_stiffness_n_per_m(spread(1, 1e4));
    spring.set_damping_ns_per_m(spread(0.1, 100));
    spring.set_stiffness_nm_per_rad(spread(0.01, 10));
    spring.set_damping_nms_per_rad(spread(1e-3, 1));
  }
  if (kind == 3) addJoint(*motion.mutable_hinge());
  if (kind == 4) addJoint(*motion.mutable_slider());
  for (int i = kind < 3 ? one({0, 0, 1, 2, 4}) : 0; i > 0; --i) {
    v1::Plane& plane = *motion.add_planes();
    setDirection(*plane.mutable_normal());
    plane.set_offset_m(random_.between(-0.08, -0.02));
    if (chance(0.5)) plane.set_friction(one({0.0, 0.5, 10.0}));
    if (chance(0.5)) plane.set_rolling_m(one({0.0, 0.1}));
  }
}

/// @param object  Null: it is new.
void RandomEdits::addDeformation(v1::Deformation& deformation, const ObjectRecord* object) {
  if (chance(0.7)) {
    v1::Softness& softness = *deformation.mutable_softness();
    if (chance(0.85)) {
      softness.set_stiffness_n_per_m(spread(5, 1e4));
      softness.set_radius_m(spread(1e-3, 0.03));
      softness.set_degree(one({2U, 3U, 8U}));
      softness.set_return_s(one({0.0, 0.1, 60.0}));
      softness.set_plastic(one({0.0, 0.5, 1.0}));
    }
  }
  if (object != nullptr && object->deformation.residue && chance(0.2)) deformation.mutable_residue();
  if (!chance(0.3)) return;
  v1::Lattice& lattice = *deformation.mutable_lattice();
  if (!chance(0.2)) addBends(lattice);
}

void RandomEdits::addBends(v1::Lattice& lattice) {
  const std::uint32_t side = one({2U, 3U, 5U});
  constexpr double kHalf_m = 0.12;
  lattice.set_points_x(side);
  lattice.set_points_y(side);
  lattice.set_points_z(side);
  set(*lattice.mutable_low_m(), Vec3(-kHalf_m));
  set(*lattice.mutable_size_m(), Vec3(2 * kHalf_m));
  const double bend_m = one({0.0, 1e-6, 0.005, 0.03});
  for (std::uint32_t i = 0; i < side * side * side; ++i) {
    for (const std::uint32_t k : {i % side, i / side % side, i / side / side}) {
      const double rest_m = kHalf_m * (2.0 * k / (side - 1) - 1);
      lattice.add_control_m(static_cast<float>(rest_m + random_.between(-bend_m, bend_m)));
    }
  }
}

void RandomEdits::setTexture(v1::Effect& effect) {
  effect.set_amplitude_n(spread(0.01, 5));
  if (chance(0.3)) effect.set_limit_n(spread(0.1, 10));
  effect.set_sample_rate_hz(spread(10, 1e5));
  const int speeds = one({1, 2, 4}), forces = one({1, 3}), order = one({1, 8, 32});
  for (int i = 1; i <= speeds; ++i) effect.add_speeds_m_per_s(i * spread(1e-3, 1.2e-3));
  for (int i = 1; i <= forces; ++i) effect.add_forces_n(i * spread(0.1, 0.12));
  for (int i = 0; i < speeds * forces; ++i) {
    effect.add_models(random_.between(0, 1));
    for (int k = 0; k < order; ++k) effect.add_models(random_.between(-1, 1) * one({0.9, 0.99999}));
  }
}

void RandomEdits::addEffect(v1::Effect& effect) {
  const int kind = 1 + random_.below(16);
  effect.set_kind(static_cast<v1::EffectKind>(kind));
  if (kind == v1::EFFECT_KIND_RECORDED_TEXTURE) return setTexture(effect);
  const bool isOfMesh = kind == v1::EFFECT_KIND_MAGNET || kind == v1::EFFECT_KIND_SPRING_TO_VERTEX ||
                        kind == v1::EFFECT_KIND_SPRING_TO_EDGE;
  if (!isOfMesh && chance(0.4)) effect.set_frame(v1::EFFECT_FRAME_WORLD);
  if (chance(0.3)) effect.set_trigger(chance(0.5) ? v1::EFFECT_TRIGGER_TOUCH : v1::EFFECT_TRIGGER_BUTTON);
  const bool isTube = kind == v1::EFFECT_KIND_TUBE;
  const bool isOnPath = kind == v1::EFFECT_KIND_SPRING_TO_PATH || kind == v1::EFFECT_KIND_GUIDE || isTube;
  const bool isForce =
      kind == v1::EFFECT_KIND_CONSTANT || kind == v1::EFFECT_KIND_VIBRATION || kind == v1::EFFECT_KIND_SAMPLES;
  const bool isInertia = kind == v1::EFFECT_KIND_INERTIA;
  const bool isInRegion = isForce || isInertia || kind == v1::EFFECT_KIND_VISCOSITY;
  const bool isDirected = isForce || kind == v1::EFFECT_KIND_SPRING_TO_LINE ||
                          kind == v1::EFFECT_KIND_SPRING_TO_PLANE || kind == v1::EFFECT_KIND_FORBIDDEN_SIDE;
  if (isDirected) setDirection(*effect.mutable_direction());
  if (isOnPath) {
    for (int i = 3 * one({2, 3, 40}); i > 0; --i) effect.add_path_m(random_.between(-0.05, 0.05));
  }
  if (!isInRegion || isInertia) effect.set_stiffness_n_per_m(spread(1, 1e4));
  if (isInertia) effect.set_mass_kg(spread(1e-3, 10));
  if (!isInRegion) {
    if (chance(0.5)) effect.set_limit_n(spread(0.1, 10));
    if (!isOnPath && !isOfMesh) setWithin(*effect.mutable_point_m(), 0.05);
    if (isTube) effect.mutable_size_m()->set_x(spread(1e-3, 0.1));
    if (kind != v1::EFFECT_KIND_FORBIDDEN_SIDE && !isTube && (isOfMesh || chance(0.6))) {
      effect.set_reach_m(spread(1e-3, 0.1));
      if (chance(0.5)) effect.set_release_m(2 * effect.reach_m());
      if (chance(0.5)) effect.set_fade_m(effect.reach_m() * random_.between(0, 1));
    }
  }
  if (!isForce) effect.set_damping_ns_per_m(spread(0.01, 10));
  if (isForce) effect.set_amplitude_n(spread(0.01, 5));
  if (kind == v1::EFFECT_KIND_VIBRATION) effect.set_frequency_hz(spread(1, 400));
  if (kind == v1::EFFECT_KIND_SAMPLES) {
    effect.set_sample_rate_hz(spread(10, 1e5));
    for (int i = one({2, 3, 400}); i > 0; --i) effect.add_samples(static_cast<float>(random_.between(-1, 1)));
  }
  if (!isInRegion || chance(0.4)) return;
  if (effect.frame() != v1::EFFECT_FRAME_WORLD && chance(0.3)) {  // refused of an open mesh
    effect.set_region(v1::EFFECT_REGION_INSIDE);
    if (chance(0.6)) effect.set_fade_m(spread(1e-4, 0.05));
    return;
  }
  effect.set_region(chance(0.5) ? v1::EFFECT_REGION_BOX : v1::EFFECT_REGION_SPHERE);
  setWithin(*effect.mutable_point_m(), 0.05);
  effect.mutable_size_m()->set_x(spread(0.01, 0.2));
  if (effect.region() == v1::EFFECT_REGION_BOX) {
    effect.mutable_size_m()->set_y(spread(0.01, 0.2));
    effect.mutable_size_m()->set_z(spread(0.01, 0.2));
  }
  if (chance(0.6)) effect.set_fade_m(spread(1e-4, 0.05));
}

void RandomEdits::addObject(v1::AddObject& add) {
  add.set_name("object" + std::to_string(++named_));
  addMesh(*add.mutable_mesh());
  addPose(*add.mutable_pose());
  if (chance(0.8)) addMaterial(*add.mutable_material());
  if (chance(0.5)) addMotion(*add.mutable_motion());
  if (chance(0.4)) addDeformation(*add.mutable_deformation(), nullptr);
  for (int i = chance(0.2) ? 1 + random_.below(3) : 0; i > 0; --i) addEffect(*add.add_effects());
}

void RandomEdits::addOperation(v1::Operation& operation, const SceneVersion& scene) {
  const std::size_t count = scene.objects().size();
  const int kind = count == 0 ? 0 : random_.below(20);
  if (kind < 3 && count < kMostObjects) return addObject(*operation.mutable_add());
  const ObjectRecord& object = *scene.objects()[static_cast<std::size_t>(random_.below(static_cast<int>(count)))];
  if (kind < 5) {
    operation.mutable_remove()->mutable_object()->set_id(object.id);
  } else if (kind < 7) {
    operation.mutable_remesh()->mutable_object()->set_id(object.id);
    addMesh(*operation.mutable_remesh()->mutable_mesh());
  } else if (kind < 11) {
    operation.mutable_set_pose()->mutable_object()->set_id(object.id);
    addPose(*operation.mutable_set_pose()->mutable_pose());
  } else if (kind < 15) {
    operation.mutable_set_material()->mutable_object()->set_id(object.id);
    addMaterial(*operation.mutable_set_material()->mutable_material());
  } else if (kind < 17) {
    operation.mutable_set_motion()->mutable_object()->set_id(object.id);
    addMotion(*operation.mutable_set_motion()->mutable_motion());
  } else if (kind < 18) {
    operation.mutable_set_effects()->mutable_object()->set_id(object.id);
    for (int i = random_.below(4); i > 0; --i) addEffect(*operation.mutable_set_effects()->add_effects());
  } else {
    operation.mutable_set_deformation()->mutable_object()->set_id(object.id);
    addDeformation(*operation.mutable_set_deformation()->mutable_deformation(), &object);
  }
}

void RandomEdits::addSample(v1::Operation& operation) {
  if (streamsShape_) {
    v1::SetDeformation& sample = *operation.mutable_set_deformation();
    sample.mutable_object()->set_id(streamed_);
    sample.set_kinematic(true);
    return addBends(*sample.mutable_deformation()->mutable_lattice());
  }
  v1::SetPose& sample = *operation.mutable_set_pose();
  place_m_ += step_m_;
  sample.mutable_object()->set_id(streamed_);
  sample.set_kinematic(true);
  if (chance(0.3)) addPose(*sample.mutable_pose());
  set(*sample.mutable_pose()->mutable_position(), place_m_);
}

v1::Transaction RandomEdits::next(const SceneVersion& scene) {
  v1::Transaction transaction;
  if (samplesLeft_ > 0) {
    --samplesLeft_;
    addSample(*transaction.add_operations());
    return transaction;
  }
  const int count = static_cast<int>(scene.objects().size());
  if (count > 0 && chance(0.15)) {
    samplesLeft_ = one({2, 20, 60});
    streamed_ = scene.objects()[static_cast<std::size_t>(random_.below(count))]->id;
    streamsShape_ = chance(0.4);
    step_m_ = random_.direction() * spread(1e-5, 0.01);
    place_m_ = -0.5 * samplesLeft_ * step_m_;
  }
  for (int i = one({1, 1, 1, 2, 4}); i > 0; --i) addOperation(*transaction.add_operations(), scene);
  return transaction;
}

}  // namespace haptics::eval
