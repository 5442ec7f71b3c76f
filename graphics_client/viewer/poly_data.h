#pragma once

#include <vtkFloatArray.h>
#include <vtkMatrix4x4.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cstdint>
#include <span>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// As VTK's mappers want vectors: three floats to each.
[[nodiscard]] vtkSmartPointer<vtkFloatArray> floatsOf(std::span<const Vec3f> vectors);

/// Triangles naming points; `normals` is empty or has one for each point.
[[nodiscard]] vtkSmartPointer<vtkPolyData> trianglesOf(std::span<const Vec3f> points,
                                                       std::span<const TriangleIndices> triangles,
                                                       std::span<const Vec3f> normals = {});

/// Unconnected segments between points.
[[nodiscard]] vtkSmartPointer<vtkPolyData> segmentsOf(std::span<const Vec3f> points,
                                                      std::span<const std::array<std::uint32_t, 2>> ends);

/// Unconnected segments: points 2i and 2i + 1.
[[nodiscard]] vtkSmartPointer<vtkPolyData> segments(std::span<const Vec3> points);

/// One polygon through the points.
[[nodiscard]] vtkSmartPointer<vtkPolyData> polygon(std::span<const Vec3> points);

/// A vertex at each of the points.
[[nodiscard]] vtkSmartPointer<vtkPolyData> vertices(std::span<const Vec3> points);

/// Radius 1, about the origin.
[[nodiscard]] vtkSmartPointer<vtkPolyData> unitSphere();
/// Along +x from 0 to 1, radius 1.
[[nodiscard]] vtkSmartPointer<vtkPolyData> unitCylinder();
/// Along +x from 0 to 1, radius 1 at the base.
[[nodiscard]] vtkSmartPointer<vtkPolyData> unitCone();

[[nodiscard]] vtkSmartPointer<vtkMatrix4x4> matrixOf(const Pose& pose);

/// Turns +x into `axis` (unit), scales by `length` along it and by `radius` across it, and moves the origin to `start`.
[[nodiscard]] vtkSmartPointer<vtkMatrix4x4> alongAxis(Vec3 start, Vec3 axis, double length, double radius);

/// A unit vector across `axis` (unit).
[[nodiscard]] Vec3 anyAcross(Vec3 axis);

}  // namespace haptics
