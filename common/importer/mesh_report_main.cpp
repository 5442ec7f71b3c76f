#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "common/command_line/command_line.h"
#include "common/importer/importer.h"
#include "common/importer/mesh_picture.h"
#include "common/mesh/mesh_asset.h"
#include "common/text/printable.h"

// Exit code: 0 when every file was there, whether it was loaded or refused; 1 when a file does not exist or the picture cannot
// be written; CLI11's codes
// (above 100) for wrong usage.
namespace {

using haptics::EncodedMesh;
using haptics::MeshReport;

nlohmann::ordered_json flat(const std::string& file, const haptics::Result<EncodedMesh>& imported) {
  nlohmann::ordered_json row{{"file", file}, {"loaded", imported.has_value()}};
  if (!imported) {
    row["field"] = imported.error().field;
    row["reason"] = imported.error().reason;
    return row;
  }
  const auto mesh = haptics::decodeMesh(imported->bytes);
  if (!mesh) {
    row["loaded"] = false;
    row["reason"] = mesh.error().text();
    return row;
  }
  const MeshReport& r = imported->report;
  row.update({{"hash", hashOf(*mesh).hex()},
              {"triangles_in_file", r.trianglesInFile},
              {"kept", r.kept},
              {"polygons_triangulated", r.polygonsTriangulated},
              {"polygons_crossing", r.polygonsCrossing},
              {"dropped_degenerate", r.droppedDegenerate},
              {"dropped_out_of_range", r.droppedOutOfRange},
              {"duplicate_faces", r.duplicateFaces},
              {"vertices_in_file", r.verticesInFile},
              {"vertices", mesh->vertices.size()},
              {"vertices_welded", r.verticesWelded},
              {"vertices_joined", r.verticesJoined},
              {"vertices_unused", r.verticesUnused},
              {"meshes_taken", r.meshesTaken},
              {"meshes_left", r.meshesLeft},
              {"points_left_out", r.leftOut.points},
              {"lines_left_out", r.leftOut.lines},
              {"skins_left_out", r.leftOut.skins},
              {"morphs_left_out", r.leftOut.morphs},
              {"animations_left_out", r.leftOut.animations},
              {"unshown_left_out", r.leftOut.unshown},
              {"instances_left_out", r.leftOut.instances},
              {"shapes_skipped", r.shapesSkipped},
              {"header_lines_skipped", r.headerLinesSkipped},
              {"lines_skipped", r.linesSkipped},
              {"bytes_at_end", r.bytesAtEnd},
              {"counts_ignored", r.countsIgnored},
              {"boundary_edges", r.boundaryEdges},
              {"t_junctions", r.tJunctions},
              {"t_junctions_searched", r.tJunctionsSearched},
              {"non_manifold_edges", r.nonManifoldEdges},
              {"inconsistent_edges", r.inconsistentEdges},
              {"closed_parts", r.closedParts},
              {"inside_out_parts", r.insideOutParts},
              {"closed", r.closed()},
              {"crossings", r.repair.selfIntersections},
              {"crossings_left", r.repair.selfIntersectionsLeft},
              {"crossings_searched", r.repair.searched},
              {"mending_finished", r.repair.finished},
              {"triangles_cut", r.repair.trianglesCut},
              {"triangles_filled", r.repair.trianglesFilled},
              {"farthest_mend_m", r.repair.farthest_m},
              {"slivers", r.slivers},
              {"crowded_vertices", r.crowdedVertices},
              {"max_valence", r.maxValence},
              {"mean_edge_m", r.meanEdge_m},
              {"box_min_m", {r.boxMin_m.x, r.boxMin_m.y, r.boxMin_m.z}},
              {"box_max_m", {r.boxMax_m.x, r.boxMax_m.y, r.boxMax_m.z}},
              {"scale_m", r.scale_m},
              {"unit_known", r.isUnitKnown},
              {"unit_doubt", r.doubtOfUnit()},
              {"rounding_m", r.rounding_m}});
  return row;
}

void printHeading() {
  std::cout << "| file | triangles | kept | degenerate | out of range | duplicate | skipped parts | boundary edges | "
               "T-junctions | non-manifold | flipped | crossings | left | filled | slivers | meshes | closed parts | "
               "inside out "
               "| closed | max valence | size m |\n"
               "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | "
               "---: | ---: "
               "| ---: | ---: | --- | ---: | --- |\n";
}

void printRow(const std::string& file, const haptics::Result<EncodedMesh>& imported) {
  if (!imported) {
    std::cout << "| " << file << " | refused: " << haptics::printable(imported.error().reason)
              << " | | | | | | | | | | | | | | | | | | | |\n";
    return;
  }
  const MeshReport& r = imported->report;
  const haptics::Vec3 size_m = r.boxMax_m - r.boxMin_m;
  char sizes[80];
  std::snprintf(sizes, sizeof sizes, "%.4g x %.4g x %.4g", size_m.x, size_m.y, size_m.z);
  std::cout << "| " << file;
  for (const std::uint64_t count :
       {r.trianglesInFile, r.kept, r.droppedDegenerate, r.droppedOutOfRange, r.duplicateFaces, r.shapesSkipped,
        r.boundaryEdges, r.tJunctions, r.nonManifoldEdges, r.inconsistentEdges, r.repair.selfIntersections,
        r.repair.selfIntersectionsLeft, r.repair.trianglesFilled, r.slivers, std::max(r.meshesTaken, std::uint64_t{1}),
        r.closedParts, r.insideOutParts}) {
    std::cout << " | " << count;
  }
  const std::string doubt = r.doubtOfUnit();
  std::cout << " | " << (r.closed() ? "yes" : "no") << " | " << r.maxValence << " | " << sizes
            << (doubt.empty() ? "" : " (" + doubt + ')') << " |\n";
}

bool draw(const haptics::Result<EncodedMesh>& imported, const std::string& picture) {
  if (!imported) return true;  // the row says why
  const auto drawn = haptics::decodeMesh(imported->bytes).and_then([&](const haptics::TriMesh& mesh) {
    return haptics::writePicture(mesh, picture);
  });
  if (!drawn) std::cerr << "mesh_report: " << haptics::printable(drawn.error().text()) << '\n';
  return drawn.has_value();
}

}  // namespace

int main(int argc, char** argv) {
  haptics::CommandLine app{
      "Reads mesh files as haptic_server does and prints a row for each: what was kept and dropped, or why the file "
      "was "
      "refused."};
  app.version("mesh_report " HAPTICS_VERSION);
  app.footer("Example: mesh_report --unit 0.001 part.stl bunny.off");
  std::vector<std::string> files;
  haptics::ImportOptions options;
  bool asJson = false;
  std::string part, picture;
  app.option("file", files,
             ".obj, .ply, .stl, .off, .om, .iv, .wrl, .gltf, .glb, .dae, .zae, .3mf, .3ds, .fbx, .x3d or .x3dv")
      .required();
  app.option("--unit", options.unit_m,
             "Metres per unit of the files (0.001 for millimetres); without it what the file says of it, else 1")
      .moreThanZero();
  app.option("--part", part,
             "Of files of several meshes: the one of this name, or of this number from 0 (default: all)");
  app.option("--picture", picture, "Draw the mesh of one file into this .png: backs of faces orange, open edges blue")
      .typeName("FILE")
      .ending(".png");
  app.flag("--json", asJson, "Print a list of flat records instead of a Markdown table");
  if (const auto code = app.parse(argc, argv)) return *code;

  if (!picture.empty() && files.size() != 1) {
    std::cerr << "mesh_report: --picture is of one file, not of " << files.size() << '\n';
    return 1;
  }
  options.part = haptics::PartName(part);
  bool allThere = true;
  auto records = nlohmann::ordered_json::array();
  if (!asJson) printHeading();
  for (const std::string& file : files) {
    std::error_code error;  // such as links without end
    allThere = std::filesystem::exists(file, error) && allThere;
    const auto imported = haptics::importMeshFile(file, options);
    allThere = (picture.empty() || draw(imported, picture)) && allThere;
    if (asJson) {
      records.push_back(flat(file, imported));
    } else {
      printRow(file, imported);
    }
  }
  if (asJson) std::cout << records.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  return allThere ? 0 : 1;
}
