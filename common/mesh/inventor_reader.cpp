#include "common/mesh/inventor_reader.h"

#include <chrono>
#include <cstring>
#include <string>
#include <string_view>

#include "common/mesh/child_process.h"
#include "common/mesh/inventor_pipe.h"

namespace haptics {
namespace {

/// Longest time that a file may take to read. The largest model known takes 0.3 s; a file can be made to take for ever.
constexpr std::chrono::seconds kPatience{60};

constexpr std::size_t kMostOutput = sizeof(InventorPipeHeader) + kMaxTriangles * 3 * sizeof(Vec3f);

}  // namespace

Result<PolygonSoup> readInventor(const std::filesystem::path& file) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "inventor_reader";
  const auto output = outputOf(program, file, kPatience, kMostOutput);
  if (!output) return tl::unexpected(output.error());

  InventorPipeHeader header;
  if (output->size() < sizeof header) return refused("", "could not be read: inventor_reader said nothing");
  std::memcpy(&header, output->data(), sizeof header);
  const std::string_view body = std::string_view(*output).substr(sizeof header);
  if (header.refused != 0) return refused("", std::string(body));
  if (header.triangles > kMaxTriangles || body.size() != header.triangles * 3 * sizeof(Vec3f)) {
    return refused("", "could not be read: inventor_reader was cut off");
  }

  PolygonSoup soup;
  soup.shapesSkipped = header.skipped;
  soup.verticesInFile = 3 * header.triangles;
  soup.vertices.reserve(soup.verticesInFile);
  soup.triangles.reserve(header.triangles);
  for (std::uint32_t v = 0; v < soup.verticesInFile; ++v) {
    Vec3f point;
    std::memcpy(&point, body.data() + v * sizeof point, sizeof point);
    soup.vertices.emplace_back(point);
    if (v % 3 == 2) soup.triangles.push_back({v - 2, v - 1, v});
  }
  return soup;
}

}  // namespace haptics
