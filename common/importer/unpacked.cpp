#include "common/importer/unpacked.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

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
  const auto bad = [] { return refused("", "is a gzip file that is cut off or damaged"); };
  constexpr std::size_t kMinSize = 18;  // of an empty file
  if (file.size() < kMinSize) return bad();
  std::uint32_t last = 0;  // bytes of the last part, little-endian, at the end
  std::memcpy(&last, file.data() + file.size() - sizeof last, sizeof last);
  const std::size_t most =
      std::min<std::size_t>(kMaxFileSize, std::max(kMaxUnpackedOfFew_bytes, kMaxTimesPacked * file.size()));
  const auto tooLarge = [&] {
    return refused("", "unpacks to more than " + std::to_string(most) + " bytes, which is the most that is taken of " +
                           std::to_string(file.size()) + " packed ones");
  };
  const Inflater inflater = makeInflater();
  const bool mayHold = last <= most && last / kMaxInflation <= file.size();  // unless something follows the last part
  std::string bytes(mayHold ? last : std::min(most, 4 * file.size()), '\0');
  std::size_t used = 0;
  for (std::string_view rest = file; used == 0 || rest.starts_with("\x1f\x8b");) {  // what else follows is none of it
    std::size_t read = 0, written = 0;
    const auto result = libdeflate_gzip_decompress_ex(inflater.get(), rest.data(), rest.size(), bytes.data() + used,
                                                      bytes.size() - used, &read, &written);
    if (result == LIBDEFLATE_INSUFFICIENT_SPACE) {
      if (bytes.size() == most) return tooLarge();
      bytes.resize(std::min(most, 2 * bytes.size() + file.size()));
    } else if (result == LIBDEFLATE_SUCCESS) {
      used += written;
      rest.remove_prefix(read);
    } else {
      return bad();
    }
  }
  if (used == 0) return bad();
  bytes.resize(used);
  return bytes;
}

}  // namespace haptics
