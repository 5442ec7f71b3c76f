#include "graphics_client/viewer/poly_data.h"

#include <vtkCellArray.h>
#include <vtkConeSource.h>
#include <vtkLineSource.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSphereSource.h>
#include <vtkTubeFilter.h>
#include <vtkTypeInt32Array.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace haptics {
namespace {

constexpr int kRoundness = 20;  // facets around the markers

vtkSmartPointer<vtkPoints> pointsOf(std::span<const Vec3f> places) {
  vtkNew<vtkPoints> points;
  points->SetData(floatsOf(places));
  return points;
}

vtkSmartPointer<vtkPoints> pointsOf(std::span<const Vec3> places) {
  return pointsOf(std::vector<Vec3f>(places.begin(), places.end()));
}

static_assert(sizeof(Vec3f) == 3 * sizeof(float) && sizeof(TriangleIndices) == 3 * sizeof(vtkTypeInt32),
              "copied as arrays of numbers");

vtkSmartPointer<vtkCellArray> cellsOf(std::span<const TriangleIndices> triangles) {
  vtkNew<vtkTypeInt32Array> corners;
  corners->SetNumberOfValues(3 * static_cast<vtkIdType>(triangles.size()));
  if (!triangles.empty()) std::copy_n(triangles.front().data(), 3 * triangles.size(), corners->GetPointer(0));
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(3, corners);
  return cells;
}

vtkSmartPointer<vtkMatrix4x4> matrixOf(const glm::dmat3& axes, Vec3 origin) {
  vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix->SetElement(row, column, axes[column][row]);
    matrix->SetElement(row, 3, origin[row]);
  }
  return matrix;
}

}  // namespace

vtkSmartPointer<vtkFloatArray> floatsOf(std::span<const Vec3f> vectors) {
  auto array = vtkSmartPointer<vtkFloatArray>::New();
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(static_cast<vtkIdType>(vectors.size()));
  if (!vectors.empty()) std::copy_n(&vectors.front().x, 3 * vectors.size(), array->GetPointer(0));
  return array;
}

vtkSmartPointer<vtkPolyData> trianglesOf(std::span<const Vec3f> points, std::span<const TriangleIndices> triangles,
                                         std::span<const Vec3f> normals) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(pointsOf(points));
  data->SetPolys(cellsOf(triangles));
  if (!normals.empty()) {
    const vtkSmartPointer<vtkFloatArray> array = floatsOf(normals);
    array->SetName("Normals");
    data->GetPointData()->SetNormals(array);
  }
  return data;
}

vtkSmartPointer<vtkPolyData> segmentsOf(std::span<const Vec3f> points,
                                        std::span<const std::array<std::uint32_t, 2>> ends) {
  vtkNew<vtkCellArray> cells;
  for (const auto& [a, b] : ends) cells->InsertNextCell({vtkIdType{a}, vtkIdType{b}});
  vtkNew<vtkPolyData> segments;
  segments->SetPoints(pointsOf(points));
  segments->SetLines(cells);
  return segments;
}

vtkSmartPointer<vtkPolyData> segments(std::span<const Vec3> points) {
  std::vector<std::array<std::uint32_t, 2>> ends;
  for (std::uint32_t i = 0; i + 1 < points.size(); i += 2) ends.push_back({i, i + 1});
  return segmentsOf(std::vector<Vec3f>(points.begin(), points.end()), ends);
}

vtkSmartPointer<vtkPolyData> polygon(std::span<const Vec3> points) {
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(static_cast<int>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) cells->InsertCellPoint(static_cast<vtkIdType>(i));
  vtkNew<vtkPolyData> data;
  data->SetPoints(pointsOf(points));
  data->SetPolys(cells);
  return data;
}

vtkSmartPointer<vtkPolyData> vertices(std::span<const Vec3> points) {
  vtkNew<vtkCellArray> cells;
  for (std::size_t i = 0; i < points.size(); ++i) cells->InsertNextCell({static_cast<vtkIdType>(i)});
  vtkNew<vtkPolyData> data;
  data->SetPoints(pointsOf(points));
  data->SetVerts(cells);
  return data;
}

vtkSmartPointer<vtkPolyData> unitSphere() {
  vtkNew<vtkSphereSource> source;
  source->SetRadius(1);
  source->SetThetaResolution(kRoundness);
  source->SetPhiResolution(kRoundness);
  source->Update();
  return source->GetOutput();
}

vtkSmartPointer<vtkPolyData> unitCylinder() {
  vtkNew<vtkLineSource> axis;
  axis->SetPoint1(0, 0, 0);
  axis->SetPoint2(1, 0, 0);
  vtkNew<vtkTubeFilter> tube;
  tube->SetInputConnection(axis->GetOutputPort());
  tube->SetRadius(1);
  tube->SetNumberOfSides(kRoundness);
  tube->Update();
  return tube->GetOutput();
}

vtkSmartPointer<vtkPolyData> unitCone() {
  vtkNew<vtkConeSource> source;
  source->SetHeight(1);
  source->SetRadius(1);
  source->SetCenter(0.5, 0, 0);
  source->SetResolution(kRoundness);
  source->Update();
  return source->GetOutput();
}

vtkSmartPointer<vtkMatrix4x4> matrixOf(const Pose& pose) {
  return matrixOf(glm::mat3_cast(pose.rotation), pose.position);
}

vtkSmartPointer<vtkMatrix4x4> alongAxis(Vec3 start, Vec3 axis, double length, double radius) {
  const Vec3 across = anyAcross(axis);
  return matrixOf(glm::dmat3(axis * length, across * radius, glm::cross(axis, across) * radius), start);
}

Vec3 anyAcross(Vec3 axis) {
  const Vec3 other = std::abs(axis.z) < std::abs(axis.x) ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
  return glm::normalize(glm::cross(axis, other));
}

}  // namespace haptics
