#include "haptic_server/device/plugin/vendors/vendor_library.h"

#include <glob.h>

#include <algorithm>

namespace haptics {
namespace {

/// Newest version first, as far as names tell; a name alone is looked for by the loader.
[[nodiscard]] std::vector<std::string> filesOf(const std::string& pattern) {
  if (pattern.find('/') == std::string::npos) return {pattern};
  glob_t found{};
  std::vector<std::string> files;
  if (::glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  std::ranges::reverse(files);
  return files;
}

}  // namespace

VendorLibrary::VendorLibrary(std::span<const std::string> patterns, std::span<const std::string> needed) {
  for (const std::string& pattern : needed) {
    for (const std::string& file : filesOf(pattern)) {
      if (dlopen(file.c_str(), RTLD_LAZY | RTLD_GLOBAL) != nullptr) break;
    }
  }
  for (const std::string& pattern : patterns) {
    for (const std::string& file : filesOf(pattern)) {
      library_ = dlopen(file.c_str(), RTLD_LAZY | RTLD_GLOBAL);
      file_ = file;
      if (library_ != nullptr) return;
      refusals_ += (refusals_.empty() ? "" : "; ") + std::string(dlerror());
    }
    if (refusals_.empty()) file_ += (file_.empty() ? "" : ", ") + pattern;
  }
}

std::string VendorLibrary::reason() const {
  if (!missing_.empty())
    return file_ + " has no function " + missing_ + "(): it is of a version that is not known here";
  if (!refusals_.empty()) return refusals_;
  return "there is none of " + file_;
}

}  // namespace haptics
