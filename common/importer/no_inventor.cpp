#include "common/importer/inventor_gather.h"

// For the importer without Coin, which is never asked for such files.
namespace haptics {

void startInventor() {}

Result<PolygonSoup> gatherInventor(std::string_view /*file*/, const IncludeReader& /*readIncluded*/) {
  return refused("", "is read by inventor_importer only");
}

}  // namespace haptics
