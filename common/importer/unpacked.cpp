#include "common/importer/unpacked.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "common/importer/inflater.h"
#include "common/mesh/file_bytes.h"

namespace haptics {
namespace {

/// A file's bytes are unpacked to no more than this and so many for each. Meshes as text are packed to a tenth; 200 MB of
/// them are imported within 1 GB.
constexpr std::size_t kMaxUnpackedOfFew_bytes = 200'000'000, kMaxTimesPacked = 50;

}  // namespace

Result<std::string> unpacked(std::string file) {
  if (!file.starts_with("\x1f\x8b")) return file;
  const auto bad = [] {
    return refused("", "is a gzip file that is cut off, damaged, or of several parts; unpack it by gunzip");
  };
  std::uint32_t size = 0;               // little-endian, at the end
  constexpr std::size_t kMinSize = 18;  // of an empty file
  if (file.size() < kMinSize) return bad();
  std::memcpy(&size, file.data() + file.size() - sizeof size, sizeof size);
  if (size / kMaxInflation > file.size()) return bad();
  if (size > std::max(kMaxUnpackedOfFew_bytes, kMaxTimesPacked * file.size())) {
    return refused("", "unpacks to " + std::to_string(size) + " bytes, more than " + std::to_string(kMaxTimesPacked) +
                           " times its own; at most " + std::to_string(kMaxUnpackedOfFew_bytes) +
                           " are taken of such a file");
  }
  if (size > kMaxFileSize) {
    return refused("", "unpacks to more than the " + std::to_string(kMaxFileSize) + " bytes that are taken");
  }
  const Inflater inflater = makeInflater();
  std::string bytes(size, '\0');
  const auto result =
      libdeflate_gzip_decompress(inflater.get(), file.data(), file.size(), bytes.data(), bytes.size(), nullptr);
  if (result != LIBDEFLATE_SUCCESS || bytes.empty()) return bad();
  return bytes;
}

}  // namespace haptics
