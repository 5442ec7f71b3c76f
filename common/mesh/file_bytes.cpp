#include "common/mesh/file_bytes.h"

#include <fstream>
#include <system_error>

namespace haptics {

Result<std::string> readFile(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return refused("", "there is no such file");
  if (!std::filesystem::is_regular_file(status)) return refused("", "is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return refused("", "cannot be read: " + error.message());
  if (size == 0) return refused("", "is empty");
  if (size > kMaxFileSize) {
    return refused("",
                   "has " + std::to_string(size) + " bytes; at most " + std::to_string(kMaxFileSize) + " are taken");
  }
  std::string bytes(size, '\0');
  std::ifstream stream(path, std::ios::binary);
  if (!stream || !stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    return refused("", "cannot be read; check its permissions");
  }
  return bytes;
}

}  // namespace haptics
