#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/error/error.h"
#include "common/hash/content_hash.h"

namespace haptics {

static_assert(std::endian::native == std::endian::little, "canonical bytes are little-endian");

/// An asset's canonical bytes where they lie: a header, then the lists of its content, which outlives this view.
class CanonicalBytes {
 public:
  using List = std::span<const std::byte>;

  CanonicalBytes(std::string header, std::vector<List> lists) : header_(std::move(header)), lists_(std::move(lists)) {}

  [[nodiscard]] std::size_t size() const noexcept;
  /// At most `most` of them, from `offset` on.
  [[nodiscard]] std::string copy(std::size_t offset = 0, std::size_t most = std::string::npos) const;
  /// SHA-256 of all of them.
  [[nodiscard]] ContentHash hash() const;

 private:
  std::string header_;
  std::vector<List> lists_;
};

/// How the bytes of a list begin: four letters, u32 version, u64 count.
inline constexpr std::size_t kListHeaderSize = 4 + sizeof(std::uint32_t) + sizeof(std::uint64_t);
inline constexpr std::uint32_t kListVersion = 1;

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

[[nodiscard]] inline std::string listHeader(std::string_view magic, std::uint64_t count) {
  std::string bytes(magic);
  append(bytes, kListVersion);
  append(bytes, count);
  return bytes;
}

/// The count of a list of `what` ("vertex values"), each of so many bytes. Refused: wrong magic or version, a count of 0 or
/// above `most`, a size that does not match the count.
[[nodiscard]] inline Result<std::size_t> listCount(std::string_view bytes, std::string_view magic,
                                                   const std::string& what, std::size_t each, std::size_t most) {
  if (bytes.size() < kListHeaderSize || !bytes.starts_with(magic)) {
    return refused("magic", "is not \"" + std::string(magic) + "\": the asset does not hold " + what);
  }
  std::uint32_t version = 0;
  std::uint64_t count = 0;
  std::memcpy(&version, bytes.data() + magic.size(), sizeof version);
  std::memcpy(&count, bytes.data() + magic.size() + sizeof version, sizeof count);
  if (version != kListVersion) {
    return refused("version", "is " + std::to_string(version) + "; this program reads " + std::to_string(kListVersion));
  }
  if (count == 0 || count > most) {
    return refused("count", "is " + std::to_string(count) + "; give 1 to " + std::to_string(most));
  }
  if (bytes.size() != kListHeaderSize + count * each) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; " + std::to_string(count) + " " + what +
                               " take " + std::to_string(kListHeaderSize + count * each));
  }
  return count;
}

}  // namespace haptics
