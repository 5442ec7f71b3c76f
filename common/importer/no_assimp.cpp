#include "common/importer/assimp_gather.h"

// For the importers without Assimp, which are never asked for such files.
namespace haptics {

Result<PolygonSoup> gatherByAssimp(std::string /*file*/, MeshFormat /*format*/, const PartName& /*part*/,
                                   const IncludeReader& /*readIncluded*/) {
  return refused("", "is read by assimp_importer only");
}

}  // namespace haptics
