#include <cmath>
#include <string>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/driven_shapes.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

constexpr Range kTissue{1e-3, 1e6, " N/m"};
constexpr Range kDegree{2, 8};
constexpr Range kReturn{0, 60, " s"};
constexpr Range kPlastic{0, 1};
constexpr Range kLatticePoints{2, 8};

Result<Softness> softnessFrom(const v1::Softness& message) {
  Softness softness{.stiffness_N_per_m = message.stiffness_n_per_m(),
                    .radius_m = message.radius_m(),
                    .degree = message.has_degree() ? message.degree() : Softness{}.degree,
                    .return_s = message.return_s(),
                    .plastic = message.plastic()};
  if (auto bad = checkAbove0(softness.stiffness_N_per_m, kTissue, "stiffness_N_per_m")) {
    return refuse(bad);
  }
  if (auto bad = checkLength(softness.radius_m, "radius_m")) return refuse(bad);
  if (auto bad = checkRange(softness.degree, kDegree, "degree")) return refuse(bad);
  if (auto bad = checkRange(softness.return_s, kReturn, "return_s")) return refuse(bad);
  if (auto bad = checkRange(softness.plastic, kPlastic, "plastic")) return refuse(bad);
  return softness;
}

Refusal addControl(const v1::Lattice& message, Lattice& lattice) {
  const std::size_t points = std::size_t{lattice.points[0]} * lattice.points[1] * lattice.points[2];
  const auto count = static_cast<std::size_t>(message.control_m_size());
  if (count != 3 * points) {
    return Error{"control_m", "has " + std::to_string(count) + " numbers; " + std::to_string(lattice.points[0]) +
                                  " x " + std::to_string(lattice.points[1]) + " x " +
                                  std::to_string(lattice.points[2]) + " points have " + std::to_string(3 * points)};
  }
  lattice.control_m.reserve(points);
  for (int i = 0; i < message.control_m_size(); i += 3) {
    for (int d = 0; d < 3; ++d) {
      const Range range{-kMaxCoordinate_m, kMaxCoordinate_m, " m"};
      const std::string field = "control_m[" + std::to_string(i + d) + "]";
      if (auto bad = checkRange(message.control_m(i + d), range, field)) return bad;
    }
    lattice.control_m.emplace_back(message.control_m(i), message.control_m(i + 1), message.control_m(i + 2));
  }
  return std::nullopt;
}

Result<Lattice> latticeFrom(const v1::Lattice& message, bool boxOfMesh) {
  Lattice lattice;
  lattice.points = {message.points_x(), message.points_y(), message.points_z()};
  if (auto bad = checkRange(lattice.points[0], kLatticePoints, "points_x")) return refuse(bad);
  if (auto bad = checkRange(lattice.points[1], kLatticePoints, "points_y")) return refuse(bad);
  if (auto bad = checkRange(lattice.points[2], kLatticePoints, "points_z")) return refuse(bad);
  if (!boxOfMesh) {
    if (auto bad = checkPosition(message.low_m(), "low_m")) return refuse(bad);
    if (auto bad = checkSize(message.size_m(), "size_m")) return refuse(bad);
    lattice.low_m = vectorFrom(message.low_m());
    lattice.size_m = vectorFrom(message.size_m());
  }
  if (auto bad = addControl(message, lattice)) return refuse(bad);
  return lattice;
}

/// In an edit, no box stands for that of the mesh.
Result<Lattice> givenLatticeFrom(const v1::Lattice& message) {
  if (message.has_low_m() != message.has_size_m()) {
    return refused("low_m", "goes with size_m; give both, or neither for the box of the mesh");
  }
  return latticeFrom(message, !message.has_size_m());
}

Result<ResidueSource> residueFrom(const v1::Residue& message) {
  if (message.has_file()) {
    if (auto bad = checkFilePath(message.file(), "file")) return refuse(bad);
    return FileSource{message.file()};
  }
  return hashFromWire(message.asset(), "asset").map([](const ContentHash& hash) { return AssetSource{hash}; });
}

}  // namespace

Result<DeformationEdit> deformationFrom(const v1::Deformation& message) {
  DeformationEdit edit;
  const bool softness = message.has_softness(), lattice = message.has_lattice(), residue = message.has_residue();
  if (auto bad = takeEdit(softness, message.softness(), softnessFrom, edit.softness, "softness.")) return refuse(bad);
  if (auto bad = takeEdit(lattice, message.lattice(), givenLatticeFrom, edit.lattice, "lattice.")) return refuse(bad);
  if (auto bad = takeEdit(residue, message.residue(), residueFrom, edit.residue, "residue.")) return refuse(bad);
  edit.latticeOfMesh = edit.lattice && *edit.lattice && !message.lattice().has_size_m();
  return edit;
}

Result<DeformationProperties> announcedDeformationFrom(const v1::Deformation& message) {
  DeformationProperties to;
  if (message.has_softness()) {
    if (auto bad = take(softnessFrom(message.softness()), to.softness, "softness.")) return refuse(bad);
  }
  if (message.has_lattice()) {
    if (auto bad = take(latticeFrom(message.lattice(), false), to.lattice, "lattice.")) return refuse(bad);
  }
  if (message.has_residue()) {
    const std::string& hash = message.residue().asset();
    if (auto bad = take(hashFromWire(hash, "asset"), to.residue, "residue.")) return refuse(bad);
  }
  return to;
}

Result<std::optional<Lattice>> announcedLatticeFrom(const v1::Lattice& message) {
  std::optional<Lattice> lattice;
  if (message.ByteSizeLong() == 0) return lattice;
  if (auto bad = take(latticeFrom(message, false), lattice, "lattice.")) return refuse(bad);
  return lattice;
}

std::vector<ShapeState> shapesFromWire(const v1::Telemetry& message) {
  std::vector<ShapeState> shapes;
  for (const v1::DrivenShape& shape : message.shape()) {
    if (auto lattice = announcedLatticeFrom(shape.lattice())) shapes.push_back({shape.object(), *std::move(lattice)});
  }
  return shapes;
}

void toWire(const Lattice& from, v1::Lattice& lattice) {
  toWire(from.low_m, *lattice.mutable_low_m());
  toWire(from.size_m, *lattice.mutable_size_m());
  lattice.set_points_x(from.points[0]);
  lattice.set_points_y(from.points[1]);
  lattice.set_points_z(from.points[2]);
  for (const Vec3f point : from.control_m) {
    for (int d = 0; d < 3; ++d) lattice.add_control_m(point[d]);
  }
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
  if (properties.lattice) toWire(*properties.lattice, *message.mutable_lattice());
  if (properties.residue) message.mutable_residue()->set_asset(properties.residue->asBytes());
}

}  // namespace haptics
