#include "haptic_server/scene/asset_folders.h"

#include <algorithm>
#include <cstddef>
#include <system_error>
#include <utility>

namespace haptics {
namespace fs = std::filesystem;
namespace {

bool isBelow(const fs::path& folder, const fs::path& file) {
  return std::ranges::mismatch(folder, file).in1 == folder.end();
}

}  // namespace

Result<LocatedFile> AssetFolders::locate(const std::string& path, const std::string& field) const {
  const fs::path relative(path);
  const bool climbs = std::ranges::find(relative, fs::path("..")) != relative.end();
  if (path.empty() || path.find('\0') != std::string::npos || relative.is_absolute() || climbs) {
    return refused(field,
                   "\"" + path + "\" is not a path below an asset folder: give one without a leading / and without ..");
  }
  for (const fs::path& folder : folders_) {
    std::error_code error;
    fs::path root = fs::canonical(folder, error);
    if (error) continue;
    fs::path file = fs::canonical(root / relative, error);
    if (error) continue;
    if (!isBelow(root, file)) {
      return refused(field, "\"" + path + "\" leads out of its asset folder by a symbolic link");
    }
    if (!fs::is_regular_file(file, error)) return refused(field, "\"" + path + "\" is not a regular file");
    return LocatedFile{std::move(file), std::move(root)};
  }
  if (folders_.empty()) return refused(field, "there is no \"" + path + "\": the server has no asset folder");
  return refused(field, "there is no \"" + path + "\" in the server's asset folders");
}

std::string seenFromOutside(std::string text, const fs::path& file, const std::string& nameForClients) {
  for (std::size_t at = 0; (at = text.find(file.string(), at)) != std::string::npos; at += nameForClients.size()) {
    text.replace(at, file.string().size(), nameForClients);
  }
  return text;
}

}  // namespace haptics
