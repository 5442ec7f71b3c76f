// The bytes of a mesh or of moved vertices, as a client uploads them: refused, or what is its bytes.

#include <string_view>

#include "common/mesh/mesh_asset.h"
#include "common/mesh/moved_vertices.h"
#include "tests/fuzz/pieces.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (const auto mesh = haptics::decodeMesh(bytes)) {
    haptics::fuzz::require(haptics::encodeMesh(*mesh) == bytes, "bytes that are taken are canonical");
  }
  if (const auto moved = haptics::decodeMovedVertices(bytes)) {
    haptics::fuzz::require(haptics::encodeMovedVertices(*moved) == bytes, "bytes that are taken are canonical");
  }
  return 0;
}
