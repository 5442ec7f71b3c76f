#include "tests/graphics_client/editing/random_edits.h"

#include <cstdio>
#include <memory>
#include <string_view>
#include <utility>

#include "common/surface/sampled_field.h"
#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::test {
namespace {

std::string text(double number) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.17g", number);
  return digits;
}

/// As text format takes bytes.
std::string bytes(const ContentHash& hash) {
  std::string escaped;
  for (const unsigned byte : hash.bytes) {
    char digits[8];
    std::snprintf(digits, sizeof digits, "\\%03o", byte);
    escaped += digits;
  }
  return "'" + escaped + "'";
}

}  // namespace

std::string RandomEdits::vector(double most) {
  return "{ x: " + text(number(-most, most)) + " y: " + text(number(-most, most)) + " z: " + text(number(-most, most)) +
         " }";
}

std::string RandomEdits::unit() {
  const Vec3 v = glm::normalize(Vec3(number(0.1, 1), number(-1, 1), number(-1, 1)));
  return "{ x: " + text(v.x) + " y: " + text(v.y) + " z: " + text(v.z) + " }";
}

/// Of a length that is off by up to 1e-4.
std::string RandomEdits::rotation() {
  const Quat q =
      glm::normalize(Quat(number(0.1, 1), number(-1, 1), number(-1, 1), number(-1, 1))) * number(0.9999, 1.0001);
  return "{ w: " + text(q.w) + " x: " + text(q.x) + " y: " + text(q.y) + " z: " + text(q.z) + " }";
}

std::string RandomEdits::mesh() {
  const std::string size = text(number(0.05, 0.1));
  switch (below(3)) {
    case 0:
      return "{ box { size_m { x: " + size + " y: 0.1 z: 0.1 } segments: " + std::to_string(1 + below(2)) + " } }";
    case 1:
      return "{ sphere { radius_m: " + size + " segments: 3 } }";
    default:
      return "{ torus { major_radius_m: 0.1 minor_radius_m: " + text(number(0.02, 0.05)) +
             " major_segments: 8 minor_segments: 6 } }";
  }
}

std::string RandomEdits::field(RandomEdit& edit) {
  switch (below(4)) {
    case 0:
      return "{ grain { grain_m: 0.002 seed: " + std::to_string(below(100)) + " } }";
    case 1:
      return "{ fourier { terms { direction " + unit() + " wavelength_m: " + text(number(0.001, 0.01)) + " } } }";
    case 2:
      return "{ layers { layer { field { noise { wavelength_m: 0.01 } } } layer { weight: " + text(number(1, 2)) +
             " field { cellular { cell_m: 0.01 } } } } }";
    default: {
      const auto image = std::make_shared<const SampledField>(
          SampledField::make(2, 2, {0, static_cast<float>(number(0, 1)), 1, 0.5F}).value());
      edit.uploads.emplace_back(image);
      return "{ mapped { asset: " + bytes(canonicalBytes(edit.uploads.back()).hash()) +
             " mapping { shape: MAPPING_SHAPE_CUBE rotation " + rotation() + " tile_m: 0.02 } } }";
    }
  }
}

std::string RandomEdits::texture(RandomEdit& edit) {
  return "{ law: TEXTURE_LAW_HO1999 amplitude_m: " + text(number(1e-5, 1e-4)) + " field " + field(edit) + " }";
}

std::string RandomEdits::friction(RandomEdit& edit) {
  const double mu_static = number(0.2, 1);
  const std::string both = "mu_static: " + text(mu_static) + " mu_dynamic: " + text(mu_static * number(0.1, 1));
  switch (below(3)) {
    case 0:
      return "{ " + both + " }";
    case 1:
      return "{ " + both + " variation: 0.5 field " + field(edit) + " }";
    default: {  // fits a box of one segment
      std::vector<float> values(8, static_cast<float>(number(0.1, 1)));
      edit.uploads.emplace_back(std::make_shared<const std::vector<float>>(std::move(values)));
      return "{ " + both + " per_vertex { asset: " + bytes(canonicalBytes(edit.uploads.back()).hash()) + " } }";
    }
  }
}

/// Some of the numbers that every surface has.
std::string RandomEdits::scalars() {
  std::string all;
  const auto add = [&](std::string_view name, double /*none*/) {
    if (below(2) == 0) all += " " + std::string(name) + ": " + text(number(0, 1));
  };
  const SurfaceScalars<double> none;
  forEachScalar(add, none);
  return all;
}

std::string RandomEdits::material(RandomEdit& edit) {
  const bool goes = below(4) == 0;
  switch (below(6)) {
    case 0:
      return "{ stiffness_N_per_m: " + text(number(100, 900)) + " }";
    case 1:
      return "{ damping_Ns_per_m: " + text(number(0, 1)) + " color { red: " + text(number(0, 1)) + " }" + scalars() +
             " }";
    case 2:
      return "{ shading { " + (goes ? std::string() : "crease_rad: " + text(number(0.1, 1))) + " } }";
    case 3:
      return "{ friction " + (goes ? std::string("{ }") : friction(edit)) + " }";
    case 4:
      return "{ texture " + (goes ? std::string("{ }") : texture(edit)) + " }";
    default:
      return "{ stiffness_over " + (goes ? std::string("{ }") : "{ variation: 0.3 field " + field(edit) + " }") + " }";
  }
}

std::string RandomEdits::motion() {
  switch (below(5)) {
    case 0:
      return "{ }";
    case 1:
      return "{ fixed: true collision { friction: " + text(number(0, 1)) + " } }";
    case 2:
      return "{ mass_kg: " + text(number(0.1, 1)) + " collision { } }";
    case 3:
      return "{ mass_kg: " + text(number(0.1, 1)) + " planes { normal " + unit() + " offset_m: -1 } }";
    default:
      return "{ mass_kg: " + text(number(0.1, 1)) + " hinge { axis " + unit() + " lowest: -1 highest: 1 } }";
  }
}

std::string RandomEdits::deformation() {
  switch (below(4)) {
    case 0:
      return "{ softness { } }";
    case 1:
      return "{ softness { stiffness_N_per_m: " + text(number(200, 400)) + " radius_m: 0.02 } }";
    case 2:
      return "{ lattice { } }";
    default: {
      std::string control;
      for (int i = 0; i < 8; ++i) {
        for (int d = 0; d < 3; ++d) {
          control += " control_m: " + text(((i >> d & 1) == 0 ? -0.05 : 0.05) + number(-0.01, 0.01));
        }
      }
      return "{ lattice { points_x: 2 points_y: 2 points_z: 2" + control + " } }";
    }
  }
}

std::string RandomEdits::effects() {
  std::string all;
  for (unsigned i = below(3); i > 0; --i) {
    const std::string spring = "stiffness_N_per_m: " + text(number(100, 400)) + " reach_m: " + text(number(0.01, 0.1));
    all += below(2) == 0 ? "effects { kind: EFFECT_KIND_SPRING_TO_LINE point_m " + vector(1) + " direction " + unit() +
                               " " + spring + " } "
                         : "effects { kind: EFFECT_KIND_GUIDE path_m: [0, 0, 0, 1, 1, " + text(number(0, 1)) + "] " +
                               spring + " frame: EFFECT_FRAME_WORLD } ";
  }
  return all;
}

std::string RandomEdits::operation(const std::string& name, RandomEdit& edit) {
  const std::string object = "{ object { name: '" + name + "' } ";
  switch (below(11)) {
    case 0:
      return "add { name: 'added" + std::to_string(++added_) + "' mesh " + mesh() + " pose { position " + vector(1) +
             " } material " + material(edit) + " }";
    case 1:
      return "remove " + object + "}";
    case 2:
      return "remesh " + object + "mesh " + mesh() + " }";
    case 3:
      return "set_pose " + object + "pose { position " + vector(1) + " } }";
    case 4:
      return "set_pose " + object + "pose { rotation " + rotation() + " } }";
    case 5:
      return "set_motion " + object + "motion " + motion() + " }";
    case 6:
      return "set_deformation " + object + "deformation " + deformation() + " }";
    case 7:
      return "set_effects " + object + effects() + "}";
    default:
      return "set_material " + object + "material " + material(edit) + " }";
  }
}

RandomEdit RandomEdits::next(const SceneVersion& scene) {
  RandomEdit edit;
  const auto& objects = scene.objects();
  std::string all;
  for (unsigned i = 1 + below(3); i > 0; --i) {
    const std::string name = objects.empty() ? "none" : objects[below(static_cast<unsigned>(objects.size()))]->name;
    all += "operations { " + operation(name, edit) + " } ";
  }
  edit.transaction = parsed(all);
  return edit;
}

}  // namespace haptics::test
