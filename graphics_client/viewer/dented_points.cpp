#include "graphics_client/viewer/dented_points.h"

#include <vtkPointData.h>

#include <algorithm>
#include <cstring>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

std::vector<Vec3f> vectorsOf(vtkFloatArray* array) {
  std::vector<Vec3f> vectors(static_cast<std::size_t>(array->GetNumberOfTuples()));
  std::memcpy(vectors.data(), array->GetPointer(0), vectors.size() * sizeof(Vec3f));
  return vectors;
}

constexpr const char* kRises = "Rises";

}  // namespace

void addRises(vtkPolyData* data, std::span<const Vec3f> rises) {
  if (rises.empty()) return;
  const vtkSmartPointer<vtkFloatArray> array = floatsOf(rises);
  array->SetName(kRises);
  data->GetPointData()->AddArray(array);
}

DentedPoints::DentedPoints(vtkPolyData* atRest) : points_(vtkSmartPointer<vtkPoints>::New()) {
  points_->DeepCopy(atRest->GetPoints());
  restPoints_ = vectorsOf(vtkFloatArray::SafeDownCast(points_->GetData()));
  if (auto* rises = vtkFloatArray::SafeDownCast(atRest->GetPointData()->GetArray(kRises))) rises_ = vectorsOf(rises);
  if (auto* normals = vtkFloatArray::SafeDownCast(atRest->GetPointData()->GetNormals())) {
    normals_ = vtkSmartPointer<vtkFloatArray>::New();
    normals_->DeepCopy(normals);
    restNormals_ = vectorsOf(normals_);
  }
}

void DentedPoints::drawIn(vtkPolyData* data) const {
  data->SetPoints(points_);
  if (normals_ && data->GetPointData()->GetNormals()) data->GetPointData()->SetNormals(normals_);
}

bool DentedPoints::follow(std::span<const Dent> dents, const Falloff& falloff) {
  if (std::ranges::equal(dents, dents_)) return false;
  std::vector<Dent> reached = std::move(dents_);
  reached.insert(reached.end(), dents.begin(), dents.end());
  dents_.assign(dents.begin(), dents.end());
  deepest_m_ = maxDentDepth_m(falloff);
  const auto radius2 = static_cast<float>(falloff.radius_m() * falloff.radius_m() * (1 + 1e-5));
  for (std::size_t i = 0; i < restPoints_.size(); ++i) {
    const bool isReached = std::ranges::any_of(reached, [&](const Dent& dent) {
      const Vec3f way = onSurface(i) - dent.centre;
      return glm::dot(way, way) < radius2;
    });
    if (isReached) move(i, falloff);
  }
  noteChange();
  return true;
}

bool DentedPoints::open(const JawProperties& jaws, double opening_rad) {
  if (opening_rad == opening_rad_) return false;
  opening_rad_ = opening_rad;
  for (std::size_t i = 0; i < restPoints_.size(); ++i) {
    const auto id = static_cast<vtkIdType>(i);
    const Pose opened = jawPose(jaws, Vec3(onSurface(i)), opening_rad);
    const Vec3 at = toWorld(opened, Vec3(restPoints_[i]));
    points_->SetPoint(id, at.x, at.y, at.z);
    if (!normals_) continue;
    const Vec3f normal(opened.rotation * Vec3(restNormals_[i]));
    normals_->SetTypedTuple(id, &normal.x);
  }
  noteChange();
  return true;
}

void DentedPoints::noteChange() {
  points_->GetData()->Modified();
  points_->Modified();
  if (normals_) normals_->Modified();
}

void DentedPoints::move(std::size_t point, const Falloff& falloff) {
  const auto id = static_cast<vtkIdType>(point);
  const Vec3f base = onSurface(point);
  const Vec3 rise = rises_.empty() ? Vec3(0) : Vec3(rises_[point]);
  const VertexWithNormal dentedBase = dented(VertexWithNormal{base, rise}, dents_, falloff);
  Vec3f at = dentedBase.place;
  if (rise != Vec3(0)) at += Vec3f(glm::normalize(dentedBase.normal) * glm::length(rise));
  points_->SetPoint(id, at.x, at.y, at.z);
  if (!normals_) return;
  const VertexWithNormal turned = dented(VertexWithNormal{base, Vec3(restNormals_[point])}, dents_, falloff);
  const Vec3f normal(glm::normalize(turned.normal));
  normals_->SetTypedTuple(id, &normal.x);
}

void DentedPoints::colorIn(vtkPolyData* data, palette::Shade own) {
  if (!colors_) {
    colors_ = vtkSmartPointer<vtkUnsignedCharArray>::New();
    colors_->SetNumberOfComponents(3);
    colors_->SetNumberOfTuples(points_->GetNumberOfPoints());
  }
  const std::vector<Vec3f> now = vectorsOf(vtkFloatArray::SafeDownCast(points_->GetData()));
  for (std::size_t i = 0; i < restPoints_.size(); ++i) {
    const double way = glm::distance(Vec3(now[i]), Vec3(restPoints_[i]));
    const auto color = palette::bytes(palette::displacementShade(own, deepest_m_ > 0 ? way / deepest_m_ : 0));
    colors_->SetTypedTuple(static_cast<vtkIdType>(i), color.data());
  }
  colors_->Modified();
  data->GetPointData()->SetScalars(colors_);
}

}  // namespace haptics
