#include "common/credentials/credentials.h"

#include <cstdio>
#include <iostream>

#include "common/json/json.h"
#include "graphics_client/script/verbs.h"

namespace haptics {

int credentials(const CommonOptions& common, const std::filesystem::path& folder) {
  if (const auto made = makeCredentials(folder); !made) return fail(kRefused, made.error());
  const std::string viewer = (folder / kViewerFile).string(), editor = (folder / kEditorFile).string();
  if (common.json) {
    std::cout << Json{{"server", folder.string()}, {"view", viewer}, {"edit", editor}}.line() << '\n';
    return kDone;
  }
  std::printf("%s: for haptic_server --credentials; keep it on the server's machine\n", folder.c_str());
  std::printf("%s: for clients that may watch\n", viewer.c_str());
  std::printf("%s: for clients that may also edit\n", editor.c_str());
  return kDone;
}

}  // namespace haptics
