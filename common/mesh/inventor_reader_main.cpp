#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <string>

#include "common/mesh/file_bytes.h"
#include "common/mesh/inventor_gather.h"
#include "common/mesh/inventor_pipe.h"

// Started by readInventor() only. Writes an InventorPipeHeader and what belongs to it to standard output.
namespace {

using haptics::InventorPipeHeader;
using haptics::InventorTriangles;

void write(const InventorPipeHeader& header, const void* body, std::size_t size) {
  std::fwrite(&header, sizeof header, 1, stdout);
  if (size > 0) std::fwrite(body, 1, size, stdout);
  std::fflush(stdout);
}

haptics::Result<InventorTriangles> gather(const std::filesystem::path& file) {
  try {
    return haptics::readFile(file).and_then(
        [&file](const std::string& bytes) { return haptics::gatherInventor(bytes, file.parent_path()); });
  } catch (const std::bad_alloc&) {
    return haptics::refused("", "needs more memory than there is");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("inventor_reader is started by the programs that import meshes; use mesh_report\n", stderr);
    return EXIT_FAILURE;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // When memory runs out, this process is what should end, not the server.
  std::ofstream("/proc/self/oom_score_adj") << "1000";

  const auto gathered = gather(argv[1]);
  if (gathered) {
    const auto& corners = gathered->corners;
    write({0, gathered->skipped, corners.size() / 3}, corners.data(), corners.size() * sizeof corners[0]);
  } else {
    write({1, 0, 0}, gathered.error().reason.data(), gathered.error().reason.size());
  }
  // Without destructors: Coin's, and those of the font libraries that it loads, are slow and leak.
  _exit(EXIT_SUCCESS);
}
