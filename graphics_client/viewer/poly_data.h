#pragma once

#include <vtkMatrix4x4.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <span>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"
#include "graphics_client/viewer/mesh_normals.h"

namespace haptics {

/// The mesh with normals for smooth shading; triangle i is the mesh's triangle i. Object frame, metres.
[[nodiscard]] vtkSmartPointer<vtkPolyData> polyDataOf(const TriMesh& mesh, const ShadedMesh& shaded);

/// Unconnected segments: points 2i and 2i + 1.
[[nodiscard]] vtkSmartPointer<vtkPolyData> segments(std::span<const Vec3> points);

/// One polygon through the points.
[[nodiscard]] vtkSmartPointer<vtkPolyData> polygon(std::span<const Vec3> points);

[[nodiscard]] vtkSmartPointer<vtkPolyData> vertexAt(Vec3 point);

[[nodiscard]] vtkSmartPointer<vtkMatrix4x4> matrixOf(const Pose& pose);

/// Turns +x into `axis` (unit), scales by `length` along it and by `radius` across it, and moves the origin to `start`.
[[nodiscard]] vtkSmartPointer<vtkMatrix4x4> alongAxis(Vec3 start, Vec3 axis, double length, double radius);

/// A unit vector across `axis` (unit).
[[nodiscard]] Vec3 anyAcross(Vec3 axis);

}  // namespace haptics
