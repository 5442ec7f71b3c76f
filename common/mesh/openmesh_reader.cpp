#include "common/mesh/openmesh_reader.h"

#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <locale>
#include <mutex>
#include <sstream>
#include <utility>

namespace haptics {
namespace {

namespace om = OpenMesh;

/// Takes what OpenMesh's readers find as it is. Vertices come before faces: plain files are written so.
class SoupImporter final : public om::IO::BaseImporter {
 public:
  PolygonSoup soup;
  std::uint64_t polygons = 0;

  /// For OM files, whose faces are rings of half-edges. False when they are not rings.
  [[nodiscard]] bool closeRings();

  om::VertexHandle add_vertex(const om::Vec3f& p) override {
    soup.vertices.emplace_back(p[0], p[1], p[2]);
    return om::VertexHandle(static_cast<int>(soup.vertices.size() - 1));
  }
  om::VertexHandle add_vertex() override { return add_vertex(om::Vec3f(0, 0, 0)); }
  void set_point(om::VertexHandle v, const om::Vec3f& p) override {
    soup.vertices.at(static_cast<std::size_t>(v.idx())) = Vec3(p[0], p[1], p[2]);
  }
  om::FaceHandle add_face(const VHandles& corners) override {
    corners_.clear();
    for (const om::VertexHandle v : corners) corners_.push_back(static_cast<std::uint32_t>(v.idx()));
    soup.addPolygon(corners_);
    return om::FaceHandle(static_cast<int>(polygons++));
  }

  om::FaceHandle add_face(om::HalfedgeHandle h) override {
    ringStart_.push_back(static_cast<std::uint32_t>(h.idx()));
    return om::FaceHandle(static_cast<int>(polygons++));
  }
  om::HalfedgeHandle add_edge(om::VertexHandle from, om::VertexHandle to) override {
    halfedges_.push_back({static_cast<std::uint32_t>(to.idx()), 0});
    halfedges_.push_back({static_cast<std::uint32_t>(from.idx()), 0});
    return om::HalfedgeHandle(static_cast<int>(halfedges_.size() - 2));
  }
  void set_next(om::HalfedgeHandle h, om::HalfedgeHandle next) override {
    halfedges_.at(static_cast<std::size_t>(h.idx())).next = static_cast<std::uint32_t>(next.idx());
  }

  om::BaseKernel* kernel() override { return &noProperties_; }
  [[nodiscard]] std::size_t n_vertices() const override { return soup.vertices.size(); }
  [[nodiscard]] std::size_t n_faces() const override { return polygons; }
  [[nodiscard]] std::size_t n_edges() const override { return halfedges_.size() / 2; }

  // Attributes, which plain files do not hold.
  void set_halfedge(om::VertexHandle, om::HalfedgeHandle) override {}
  void set_face(om::HalfedgeHandle, om::FaceHandle) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec2f>&) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec3f>&) override {}
  void set_face_texindex(om::FaceHandle, int) override {}
  void set_normal(om::VertexHandle, const om::Vec3f&) override {}
  void set_normal(om::VertexHandle, const om::Vec3d&) override {}
  void set_normal(om::FaceHandle, const om::Vec3f&) override {}
  void set_normal(om::FaceHandle, const om::Vec3d&) override {}
  void set_color(om::VertexHandle, const om::Vec3uc&) override {}
  void set_color(om::VertexHandle, const om::Vec4uc&) override {}
  void set_color(om::VertexHandle, const om::Vec3f&) override {}
  void set_color(om::VertexHandle, const om::Vec4f&) override {}
  void set_color(om::EdgeHandle, const om::Vec3uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec4uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec3f&) override {}
  void set_color(om::EdgeHandle, const om::Vec4f&) override {}
  void set_color(om::FaceHandle, const om::Vec3uc&) override {}
  void set_color(om::FaceHandle, const om::Vec4uc&) override {}
  void set_color(om::FaceHandle, const om::Vec3f&) override {}
  void set_color(om::FaceHandle, const om::Vec4f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec2f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec3f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec2f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec3f&) override {}
  void set_status(om::VertexHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::HalfedgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::EdgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::FaceHandle, const om::Attributes::StatusInfo&) override {}
  void request_face_texcoords2D() override {}
  void add_texture_information(int, std::string) override {}

 private:
  struct Halfedge {
    std::uint32_t to, next;
  };

  std::vector<std::uint32_t> corners_;
  std::vector<Halfedge> halfedges_;
  std::vector<std::uint32_t> ringStart_;  // one a face
  om::BaseKernel noProperties_;
};

bool SoupImporter::closeRings() {
  std::size_t sides = 0;  // over all faces: in a mesh, each half-edge belongs to one ring at most
  for (const std::uint32_t start : ringStart_) {
    corners_.clear();
    std::uint32_t h = start;
    do {
      if (h >= halfedges_.size() || ++sides > halfedges_.size()) return false;
      corners_.push_back(halfedges_[h].to);
      h = halfedges_[h].next;
    } while (h != start);
    soup.addPolygon(corners_);
  }
  return true;
}

tl::unexpected<Error> disagreement(const char* what, std::uint64_t expected, std::uint64_t found) {
  return refused("", "is not read as it is written: OpenMesh finds " + std::to_string(found) + " of " +
                         std::to_string(expected) + ' ' + what);
}

}  // namespace

Result<PolygonSoup> readWithOpenMesh(PlainFile plain, const std::string& format) {
  static std::mutex oneAtATime;
  const std::lock_guard lock(oneAtATime);
  ::omerr().disable();
  ::omlog().disable();
  SoupImporter importer;
  om::IO::Options options = plain.binary ? om::IO::Options::Binary : om::IO::Options::Default;
  std::istringstream stream(std::move(plain.bytes));
  stream.imbue(std::locale::classic());
  if (!om::IO::IOManager().read(stream, format, importer, options)) {
    return refused("", "cannot be read by OpenMesh as ." + format);
  }
  if (!importer.closeRings()) return refused("", "has faces whose half-edges do not close");

  PolygonSoup& soup = importer.soup;
  const std::uint64_t cut = soup.triangles.size() + soup.outOfRange + soup.degenerate;
  if (plain.readerDropsDegenerate) {
    // STL vertices are joined by the reader, in the same way as canonicalise() does.
    if (cut > plain.triangles) return disagreement("triangles", plain.triangles, cut);
    soup.degenerate += plain.triangles - cut;
  } else if (importer.polygons != plain.polygons) {
    return disagreement("faces", plain.polygons, importer.polygons);
  }
  if (format != "stl" && soup.vertices.size() != plain.vertices) {
    return disagreement("vertices", plain.vertices, soup.vertices.size());
  }
  soup.verticesInFile = plain.vertices;
  soup.degenerate += plain.degenerate;
  soup.outOfRange += plain.outOfRange;
  soup.headerLinesSkipped = plain.headerLinesSkipped;
  soup.bytesAtEnd = plain.bytesAtEnd;
  return std::move(soup);
}

}  // namespace haptics
