#include <assimp/scene.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkObject.h>
#include <vtkPLYReader.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <optional>

#include "mesh_files.h"
#include "spelling.h"

// Files in many spellings by readers of others beside ours: none of them may read one rightly that we refuse or read as
// another mesh. They may crash: each file is read in a process of its own. What came of it is printed as a table.
namespace haptics::peer_readers_test {
namespace {

using fixture::PlainSolid;
using fixture::Spelling;
using fixture::SpeltFile;

/// Of each format; more: HAPTICS_SPELLINGS.
int spellings() {
  const char* const more = std::getenv("HAPTICS_SPELLINGS");
  return more == nullptr ? 150 : std::atoi(more);
}

/// Transformations of a file: of more, the others read next to none.
constexpr int kMaxMade = 2;

/// Whether triangles are the solid: however its faces were cut, closed, of its size and its volume.
bool isTheSolid(const std::vector<Vec3>& vertices, std::vector<TriangleIndices> triangles) {
  const auto measured = [](const TriMesh& mesh) {
    double volume = 0;
    Vec3f low(1e30F), high(-1e30F);
    for (const auto& [a, b, c] : mesh.triangles) {
      volume += glm::dot(Vec3(mesh.vertices[a]), glm::cross(Vec3(mesh.vertices[b]), Vec3(mesh.vertices[c]))) / 6;
    }
    for (const Vec3f& v : mesh.vertices) {
      low = glm::min(low, v);
      high = glm::max(high, v);
    }
    return std::array{volume,         double{low.x},  double{low.y}, double{low.z},
                      double{high.x}, double{high.y}, double{high.z}};
  };
  static const auto wanted = measured(PlainSolid::mesh(false));
  const auto imported = canonicalise(vertices, std::move(triangles), {});
  if (!imported || !imported->report.closed()) return false;
  const auto is = measured(imported->mesh);
  return std::equal(is.begin(), is.end(), wanted.begin(), [](double a, double b) { return std::abs(a - b) < 1e-3; });
}

enum class Outcome { kRight, kWrong, kRefused, kCrashed };

Outcome byAssimp(const std::string& file, const std::string& ending) {
  Assimp::Importer importer;
  const aiScene* const scene = importer.ReadFileFromMemory(file.data(), file.size(), 0, ending.c_str());
  if (scene == nullptr) return Outcome::kRefused;
  PolygonSoup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      soup.vertices.emplace_back(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;  // points and lines that a file has beside faces
      std::vector<std::uint32_t> corners(face.mIndices, face.mIndices + face.mNumIndices);
      for (std::uint32_t& corner : corners) corner += first;
      soup.addPolygon(corners);
    }
  }
  return isTheSolid(soup.vertices, soup.triangles) ? Outcome::kRight : Outcome::kWrong;
}

template <class Reader>
Outcome byVtk(const std::string& file) {
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<Reader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkPolyData* const data = reader->GetOutput();
  if (data == nullptr || data->GetNumberOfPolys() + data->GetNumberOfStrips() == 0) return Outcome::kRefused;
  PolygonSoup soup;
  for (vtkIdType v = 0; v < data->GetNumberOfPoints(); ++v) {
    const double* const at = data->GetPoint(v);
    soup.vertices.emplace_back(at[0], at[1], at[2]);
  }
  vtkCellArray* const faces = data->GetPolys();
  vtkIdType count = 0;
  const vtkIdType* corners = nullptr;
  for (faces->InitTraversal(); faces->GetNextCell(count, corners);) {
    soup.addPolygon(std::vector<std::uint32_t>(corners, corners + count));
  }
  return isTheSolid(soup.vertices, soup.triangles) ? Outcome::kRight : Outcome::kWrong;
}

Outcome inAProcess(const std::function<Outcome()>& read) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) close(stream);
    _exit(static_cast<int>(read()));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) < 3 ? static_cast<Outcome>(WEXITSTATUS(status)) : Outcome::kCrashed;
}

class PeerReaders : public fixture::MeshFiles {
 protected:
  void compare(const std::string& format, const std::string& ending, const std::function<SpeltFile(Spelling&)>& spelt,
               const std::function<Outcome(const std::string&)>& byOther) const {
    std::map<std::string, std::map<Outcome, int>> counts;
    for (int seed = 1, compared = 0; compared < spellings(); ++seed) {
      Spelling spelling(static_cast<std::uint64_t>(seed));
      const SpeltFile file = spelt(spelling);
      if (std::count(spelling.made().begin(), spelling.made().end(), ' ') > kMaxMade) continue;
      ++compared;
      const std::string path = write("t." + ending, file.bytes);
      const Outcome assimp = inAProcess([&] { return byAssimp(file.bytes, ending); });
      const Outcome vtk = inAProcess([&] { return byOther(path); });
      const auto imported = import("t." + ending, file.bytes);
      const bool isRight = imported && imported->mesh == PlainSolid::mesh(file.areStrips);
      ++counts["Assimp"][assimp];
      ++counts["VTK"][vtk];
      ++counts["this one"][isRight ? Outcome::kRight : imported ? Outcome::kWrong : Outcome::kRefused];
      EXPECT_TRUE(isRight || (assimp != Outcome::kRight && vtk != Outcome::kRight))
          << "seed " << seed << ", " << spelling.made() << ": "
          << (imported ? "another mesh" : imported.error().text());
    }
    for (auto& [reader, outcomes] : counts) {
      std::cout << "| " << format << " | " << reader << " | " << outcomes[Outcome::kRight] << " | "
                << outcomes[Outcome::kWrong] << " | " << outcomes[Outcome::kRefused] << " | "
                << outcomes[Outcome::kCrashed] << " |\n";
    }
  }
};

TEST_F(PeerReaders, ReadNoSpellingThatIsRefusedHere) {
  std::cout << "| format | reader | right | wrong | refused | crashed |\n| --- | --- | ---: | ---: | ---: | ---: |\n";
  compare(
      "OBJ", "obj", [](Spelling& s) { return fixture::speltObj(s, false); }, byVtk<vtkOBJReader>);
  compare(
      "STL, text", "stl", [](Spelling& s) { return fixture::speltStl(s, false); }, byVtk<vtkSTLReader>);
  compare("STL, binary", "stl", fixture::speltBinaryStl, byVtk<vtkSTLReader>);
  compare(
      "PLY, text", "ply", [](Spelling& s) { return fixture::speltPly(s, false); }, byVtk<vtkPLYReader>);
  compare("PLY, binary", "ply", fixture::speltBinaryPly, byVtk<vtkPLYReader>);
}

}  // namespace
}  // namespace haptics::peer_readers_test
