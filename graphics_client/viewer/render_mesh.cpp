#include "graphics_client/viewer/render_mesh.h"

#include <vtkNew.h>
#include <vtkPolyDataNormals.h>
#include <vtkQuadricClustering.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "graphics_client/viewer/dented_points.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// At most about this many vertices of an object decide on the camera and the floor, besides the extreme ones.
constexpr std::size_t kOutlinePoints = 4096;

std::vector<Vec3> outlineOf(const TriMesh& mesh) {
  std::vector<Vec3> points;
  const std::size_t step = mesh.vertices.size() / kOutlinePoints + 1;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) points.emplace_back(mesh.vertices[i]);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::ranges::minmax_element(mesh.vertices, {}, [&](Vec3f v) { return v[axis]; });
    points.emplace_back(*low);
    points.emplace_back(*high);
  }
  return points;
}

/// A piece that is drawn anew costs by its triangles, one that is drawn by its being one.
constexpr std::size_t kTrianglesOfPiece = 1024, kMaxPieces = 256;

std::vector<RenderMesh::Piece> piecesOf(const DisplayedSurface& surface) {
  const std::size_t most = std::max(kTrianglesOfPiece, surface.triangles.size() / kMaxPieces);
  std::vector<RenderMesh::Piece> pieces;
  for (Patch& patch : cutIntoPatches(surface.points, surface.triangles, most)) {
    const auto gathered = [&](const std::vector<Vec3f>& all) {
      std::vector<Vec3f> own;
      if (all.empty()) return own;
      own.reserve(patch.points.size());
      for (const std::uint32_t p : patch.points) own.push_back(all[p]);
      return own;
    };
    const auto drawn = trianglesOf(gathered(surface.points), patch.triangles, gathered(surface.normals));
    addRises(drawn, gathered(surface.rises));
    patch.triangles = {};
    pieces.push_back({drawn, std::move(patch)});
  }
  return pieces;
}

/// A shadow needs an outline only. What has more triangles than this is made coarser, in cells of so many along its longest
/// side.
constexpr std::size_t kTrianglesOfShadow = 10'000;
constexpr double kShadowCells = 48;

vtkSmartPointer<vtkPolyData> coarserOf(vtkPolyData* shape, Vec3 extent_m, double cellsAlong) {
  const double cell_m = std::max({extent_m.x, extent_m.y, extent_m.z}) / cellsAlong;
  const auto cells = [&](double side_m) { return std::max(1, static_cast<int>(std::ceil(side_m / cell_m))); };
  vtkNew<vtkQuadricClustering> coarser;
  coarser->SetInputData(shape);
  coarser->AutoAdjustNumberOfDivisionsOff();
  coarser->SetNumberOfDivisions(cells(extent_m.x), cells(extent_m.y), cells(extent_m.z));
  coarser->UseInputPointsOn();
  coarser->CopyCellDataOff();
  coarser->Update();
  return coarser->GetOutput();
}

vtkSmartPointer<vtkPolyData> shadowOf(const TriMesh& mesh, Vec3 extent_m) {
  vtkSmartPointer<vtkPolyData> shadow = trianglesOf(mesh.vertices, mesh.triangles);
  return mesh.triangles.size() <= kTrianglesOfShadow ? shadow : coarserOf(shadow, extent_m, kShadowCells);
}

/// What software draws some 30 times a second. What has more is drawn in cells of so many along its longest side while the
/// camera moves: a cell is some pixels then.
constexpr std::size_t kTrianglesInMotion = 100'000;
constexpr double kCellsInMotion = 72;

vtkSmartPointer<vtkPolyData> inMotion(const DisplayedSurface& surface, Vec3 extent_m) {
  if (surface.triangles.size() <= kTrianglesInMotion) return nullptr;
  const auto coarse = coarserOf(trianglesOf(surface.points, surface.triangles), extent_m, kCellsInMotion);
  if (surface.normals.empty()) return coarse;
  vtkNew<vtkPolyDataNormals> shaded;
  shaded->SetInputData(coarse);
  shaded->SplittingOff();
  shaded->ConsistencyOff();
  shaded->Update();
  return shaded->GetOutput();
}

}  // namespace

bool facesAway(const RenderMesh& renderMesh, const RenderMesh::Piece& piece, Vec3 eye) {
  return renderMesh.closed && facesAway(piece.patch, eye);
}

RenderMesh buildRenderMesh(const SurfaceRequest& request) {
  const std::shared_ptr<const TriMesh> shape = shapeAtRest(request);
  const TriMesh& mesh = *shape;
  DisplayedSurface surface = displaySurface(request, mesh);
  RenderMesh renderMesh{.pieces = piecesOf(surface),
                        .shadow = {},
                        .coarse = {},
                        .rims = {},
                        .heights = std::move(surface.heights),
                        .friction = std::move(surface.friction),
                        .faceted = surface.normals.empty(),
                        .closed = surface.closed,
                        .triangles = surface.triangles.size(),
                        .finestDetail_m = surface.finestDetail_m,
                        .longestEdge_m = surface.longestEdge_m,
                        .filtered = surface.filtered,
                        .pitsAreFeltAsBumps = surface.pitsAreFeltAsBumps,
                        .outline = outlineOf(mesh)};
  if (!surface.rims.empty()) {
    renderMesh.rims = segmentsOf(surface.points, surface.rims);
    addRises(renderMesh.rims, surface.rises);
  }
  renderMesh.low = renderMesh.high = renderMesh.outline.front();
  for (const Vec3& p : renderMesh.outline) {
    renderMesh.low = glm::min(renderMesh.low, p);
    renderMesh.high = glm::max(renderMesh.high, p);
  }
  renderMesh.shadow = shadowOf(mesh, renderMesh.high - renderMesh.low);
  renderMesh.coarse = inMotion(surface, renderMesh.high - renderMesh.low);
  if (!renderMesh.friction.empty()) {
    const auto [least, most] = std::ranges::minmax(renderMesh.friction);
    renderMesh.minFriction = least;
    renderMesh.maxFriction = most;
  }
  return renderMesh;
}

}  // namespace haptics
