#include "common/wire/convert_deformation.h"

#include <cmath>
#include <string>
#include <utility>

#include "common/wire/checks.h"
#include "common/wire/convert.h"

namespace haptics {
namespace {

constexpr double kMaxTissue_N_per_m = 1e6;
constexpr Range kDegree{2, 8};
constexpr Range kReturn{0, 60, " s"};
constexpr Range kPlastic{0, 1};
constexpr Range kLatticePoints{2, 8};

auto refuse(Refusal bad) { return tl::unexpected<Error>(std::move(*bad)); }

void write(Vec3 v, v1::Vector3& message) {
  message.set_x(v.x);
  message.set_y(v.y);
  message.set_z(v.z);
}

Result<Softness> softnessFrom(const v1::Softness& message) {
  Softness softness{.stiffness_N_per_m = message.stiffness_n_per_m(),
                    .radius_m = message.radius_m(),
                    .degree = message.has_degree() ? message.degree() : Softness{}.degree,
                    .return_s = message.return_s(),
                    .plastic = message.plastic()};
  if (auto bad = checkAbove0(softness.stiffness_N_per_m, kMaxTissue_N_per_m, " N/m", "stiffness_N_per_m")) {
    return refuse(bad);
  }
  if (auto bad = checkLength(softness.radius_m, "radius_m")) return refuse(bad);
  if (auto bad = checkRange(softness.degree, kDegree, "degree")) return refuse(bad);
  if (auto bad = checkRange(softness.return_s, kReturn, "return_s")) return refuse(bad);
  if (auto bad = checkRange(softness.plastic, kPlastic, "plastic")) return refuse(bad);
  return softness;
}

Result<void> addControl(const v1::Lattice& message, Lattice& lattice) {
  const std::size_t points = std::size_t{lattice.points[0]} * lattice.points[1] * lattice.points[2];
  const auto given = static_cast<std::size_t>(message.control_m_size());
  if (given != 3 * points) {
    return refused("control_m", "has " + std::to_string(given) + " numbers; " + std::to_string(lattice.points[0]) +
                                    " x " + std::to_string(lattice.points[1]) + " x " +
                                    std::to_string(lattice.points[2]) + " points have " + std::to_string(3 * points));
  }
  lattice.control_m.reserve(points);
  for (int i = 0; i < message.control_m_size(); i += 3) {
    for (int d = 0; d < 3; ++d) {
      const Range range{-kMaxCoordinate_m, kMaxCoordinate_m, " m"};
      const std::string field = "control_m[" + std::to_string(i + d) + "]";
      if (auto bad = checkRange(message.control_m(i + d), range, field)) return refuse(bad);
    }
    lattice.control_m.emplace_back(message.control_m(i), message.control_m(i + 1), message.control_m(i + 2));
  }
  return {};
}

Result<Lattice> latticeFrom(const v1::Lattice& message, bool boxOfMesh) {
  Lattice lattice;
  lattice.points = {message.points_x(), message.points_y(), message.points_z()};
  if (auto bad = checkRange(lattice.points[0], kLatticePoints, "points_x")) return refuse(bad);
  if (auto bad = checkRange(lattice.points[1], kLatticePoints, "points_y")) return refuse(bad);
  if (auto bad = checkRange(lattice.points[2], kLatticePoints, "points_z")) return refuse(bad);
  if (!boxOfMesh) {
    if (auto bad = checkPosition(message.low_m(), "low_m")) return refuse(bad);
    const v1::Vector3& size = message.size_m();
    for (const auto& [side, field] :
         {std::pair{size.x(), "size_m.x"}, {size.y(), "size_m.y"}, {size.z(), "size_m.z"}}) {
      if (auto bad = checkLength(side, field)) return refuse(bad);
    }
    lattice.low_m = {message.low_m().x(), message.low_m().y(), message.low_m().z()};
    lattice.size_m = {size.x(), size.y(), size.z()};
  }
  if (auto control = addControl(message, lattice); !control) return tl::unexpected<Error>(std::move(control.error()));
  return lattice;
}

template <class T>
tl::unexpected<Error> errorOf(Result<T>& result, const std::string& prefix) {
  return tl::unexpected<Error>(std::move(result.error()).within(prefix));
}

}  // namespace

Result<DeformationEdit> deformationFrom(const v1::Deformation& message) {
  DeformationEdit edit;
  if (message.has_softness()) {
    edit.softness.emplace();
    if (message.softness().ByteSizeLong() > 0) {
      auto softness = softnessFrom(message.softness());
      if (!softness) return errorOf(softness, "softness.");
      *edit.softness = *softness;
    }
  }
  if (message.has_lattice()) {
    edit.lattice.emplace();
    if (message.lattice().ByteSizeLong() > 0) {
      if (message.lattice().has_low_m() != message.lattice().has_size_m()) {
        return refused("lattice.low_m", "goes with size_m; give both, or neither for the box of the mesh");
      }
      edit.latticeOfMesh = !message.lattice().has_size_m();
      auto lattice = latticeFrom(message.lattice(), edit.latticeOfMesh);
      if (!lattice) return errorOf(lattice, "lattice.");
      *edit.lattice = *std::move(lattice);
    }
  }
  if (message.has_residue()) {
    edit.residue.emplace();
    if (message.residue().ByteSizeLong() > 0) {
      const auto asset = hashFromWire(message.residue().asset(), "residue.asset");
      if (!asset) return tl::unexpected<Error>(asset.error());
      *edit.residue = *asset;
    }
  }
  return edit;
}

Result<DeformationProperties> announcedDeformationFrom(const v1::Deformation& message) {
  DeformationProperties properties;
  if (message.has_softness()) {
    auto softness = softnessFrom(message.softness());
    if (!softness) return errorOf(softness, "softness.");
    properties.softness = *softness;
  }
  if (message.has_lattice()) {
    auto lattice = latticeFrom(message.lattice(), false);
    if (!lattice) return errorOf(lattice, "lattice.");
    properties.lattice = *std::move(lattice);
  }
  if (message.has_residue()) {
    const auto asset = hashFromWire(message.residue().asset(), "residue.asset");
    if (!asset) return tl::unexpected<Error>(asset.error());
    properties.residue = *asset;
  }
  return properties;
}

void toWire(const DeformationProperties& properties, v1::Deformation& message) {
  message.Clear();
  if (const auto& from = properties.softness) {
    v1::Softness& softness = *message.mutable_softness();
    softness.set_stiffness_n_per_m(from->stiffness_N_per_m);
    softness.set_radius_m(from->radius_m);
    softness.set_degree(from->degree);
    softness.set_return_s(from->return_s);
    if (from->plastic > 0) softness.set_plastic(from->plastic);
  }
  if (const auto& from = properties.lattice) {
    v1::Lattice& lattice = *message.mutable_lattice();
    write(from->low_m, *lattice.mutable_low_m());
    write(from->size_m, *lattice.mutable_size_m());
    lattice.set_points_x(from->points[0]);
    lattice.set_points_y(from->points[1]);
    lattice.set_points_z(from->points[2]);
    for (const Vec3f point : from->control_m) {
      for (int d = 0; d < 3; ++d) lattice.add_control_m(point[d]);
    }
  }
  if (properties.residue) message.mutable_residue()->set_asset(properties.residue->asBytes());
}

}  // namespace haptics
