#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace haptics::eval {

struct AdviseOptions {
  std::string scene;                          ///< Scene file, protobuf text format.
  std::vector<std::filesystem::path> assets;  ///< Folders of the meshes that it names, besides its own.
  std::string devicePreset;
  double tolerance = 0.01;  ///< How far a copy may stray from the scene's own mesh, of the object's longest side.
  std::filesystem::path out = ".";
  std::filesystem::path apply;  ///< Folder for the advised scene; empty: it is not written.
};

/// What a scene needs: for each object the cheapest copy of its mesh whose force a hand cannot tell from that of the mesh
/// itself and on which no contact is lost; for all the lowest rate, and for each object the stiffness and damping nearest
/// to its own, at which a device rests steadily on it, with no hand and with a light one, and which are felt as the scene
/// as it is. With the price of a step up and a step down of each. Where the hand holds a tool, the widest spacing of its
/// points that a hand cannot tell from the scene's, and what a tick takes. Prints it, writes DIR/advise.json, advise.csv
/// (the meshes), advise_tool.csv (the spacings), advise.png, advise.svg and
/// advise_objects.csv (a line for each object). With `apply`, writes the advised scene too (scene_writer.h).
/// @return False where the written scene is felt to differ on other strokes than it was advised by.
/// Throws std::runtime_error naming the file or field that is wrong.
bool runAdvise(const AdviseOptions& options);

}  // namespace haptics::eval
