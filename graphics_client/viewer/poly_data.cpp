#include "graphics_client/viewer/poly_data.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt32Array.h>

#include <cmath>

namespace haptics {
namespace {

vtkSmartPointer<vtkPoints> pointsOf(std::span<const Vec3> places) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  for (const Vec3& p : places) points->InsertNextPoint(p.x, p.y, p.z);
  return points;
}

}  // namespace

vtkSmartPointer<vtkPolyData> polyDataOf(const TriMesh& mesh, const ShadedMesh& shaded) {
  const auto vertices = static_cast<vtkIdType>(shaded.source.size());
  const auto triangles = static_cast<vtkIdType>(shaded.triangles.size());
  vtkNew<vtkFloatArray> places, normals;
  for (vtkFloatArray* array : {places.Get(), normals.Get()}) {
    array->SetNumberOfComponents(3);
    array->SetNumberOfTuples(vertices);
  }
  normals->SetName("Normals");
  for (vtkIdType i = 0; i < vertices; ++i) {
    const auto v = static_cast<std::size_t>(i);
    places->SetTypedTuple(i, &mesh.vertices[shaded.source[v]].x);
    normals->SetTypedTuple(i, &shaded.normals[v].x);
  }
  vtkNew<vtkTypeInt32Array> corners;
  corners->SetNumberOfValues(3 * triangles);
  for (vtkIdType c = 0; c < 3 * triangles; ++c) {
    const auto corner = static_cast<std::size_t>(c);
    corners->SetValue(c, static_cast<vtkTypeInt32>(shaded.triangles[corner / 3][corner % 3]));
  }
  vtkNew<vtkPoints> points;
  points->SetData(places);
  vtkNew<vtkCellArray> cells;
  cells->SetData(3, corners);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  data->GetPointData()->SetNormals(normals);
  return data;
}

vtkSmartPointer<vtkPolyData> segments(std::span<const Vec3> points) {
  vtkNew<vtkCellArray> cells;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    const auto first = static_cast<vtkIdType>(i);
    cells->InsertNextCell({first, first + 1});
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(pointsOf(points));
  data->SetLines(cells);
  return data;
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

vtkSmartPointer<vtkPolyData> vertexAt(Vec3 point) {
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell({vtkIdType{0}});
  vtkNew<vtkPolyData> data;
  data->SetPoints(pointsOf({&point, 1}));
  data->SetVerts(cells);
  return data;
}

vtkSmartPointer<vtkMatrix4x4> matrixOf(const Pose& pose) {
  const glm::dmat3 rotation = glm::mat3_cast(pose.rotation);
  vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix->SetElement(row, column, rotation[column][row]);
    matrix->SetElement(row, 3, pose.position[row]);
  }
  return matrix;
}

vtkSmartPointer<vtkMatrix4x4> alongAxis(Vec3 start, Vec3 axis, double length, double radius) {
  const Vec3 across = anyAcross(axis);
  const Vec3 columns[3] = {axis * length, across * radius, glm::cross(axis, across) * radius};
  vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix->SetElement(row, column, columns[column][row]);
    matrix->SetElement(row, 3, start[row]);
  }
  return matrix;
}

Vec3 anyAcross(Vec3 axis) {
  const Vec3 other = std::abs(axis.z) < std::abs(axis.x) ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
  return glm::normalize(glm::cross(axis, other));
}

}  // namespace haptics
