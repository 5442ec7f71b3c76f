#include "common/importer/zip_archive.h"

#include <cstddef>
#include <utility>

#include "common/importer/inflater.h"

namespace haptics {
namespace {

constexpr std::string_view kEnd = "PK\x05\x06", kListed = "PK\x01\x02", kHead = "PK\x03\x04";
constexpr std::string_view kLargeEnd = "PK\x06\x06", kLargeEndLocator = "PK\x06\x07";
constexpr std::size_t kEndSize = 22, kListedSize = 46, kHeadSize = 30, kLargeEndSize = 56, kLargeEndLocatorSize = 20;
constexpr std::uint64_t kIsElsewhere = 0xFFFFFFFF;  // in place of a number that has more than 32 bits, or may have

/// Little-endian; `at + size` is within `bytes`.
std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

void append(std::string& bytes, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFF);
}

tl::unexpected<Error> damaged() { return refused("", "is a ZIP archive that is cut off or damaged"); }

/// Where the large kind (ZIP64) keeps the numbers of its end, before the end at `end`; the file's size if nowhere.
std::size_t largeEndOf(std::string_view file, std::size_t end) {
  if (end < kLargeEndLocatorSize) return file.size();
  const std::size_t locator = end - kLargeEndLocatorSize;
  if (!file.substr(locator).starts_with(kLargeEndLocator)) return file.size();
  const std::uint64_t at = number(file, locator + 8, 8);
  const bool isThere = at <= locator && locator - at >= kLargeEndSize && file.substr(at).starts_with(kLargeEnd);
  return isThere ? at : file.size();
}

/// Takes those of the entry's numbers that are elsewhere from what stands behind its name; false: they are not there.
bool takeLarge(std::string_view extra, ZipArchive::Entry& entry) {
  constexpr std::uint64_t kLarge = 1;
  std::string_view large;
  for (std::size_t at = 0, size = 0; extra.size() - at >= 4; at += 4 + size) {
    size = number(extra, at + 2, 2);
    if (size > extra.size() - at - 4) break;
    if (number(extra, at, 2) == kLarge) large = extra.substr(at + 4, size);
  }
  for (std::uint64_t* const field : {&entry.size_bytes, &entry.packed_bytes, &entry.at}) {
    if (*field != kIsElsewhere) continue;
    if (large.size() < 8) return false;
    *field = number(large, 0, 8);
    large.remove_prefix(8);
  }
  return true;
}

}  // namespace

// The layout is that of PKWARE's APPNOTE.TXT 6.3, sections 4.3.7, 4.3.12 and 4.3.14 to 16, and 4.5.3.
Result<ZipArchive> ZipArchive::open(std::string_view file) {
  const std::size_t end = file.rfind(kEnd);
  if (end == std::string_view::npos || file.size() - end < kEndSize) return damaged();
  std::uint64_t count = number(file, end + 10, 2), at = number(file, end + 16, 4);
  if (count == 0xFFFF || at == kIsElsewhere) {
    const std::size_t largeEnd = largeEndOf(file, end);
    if (largeEnd == file.size()) return damaged();
    count = number(file, largeEnd + 32, 8);
    at = number(file, largeEnd + 48, 8);
  }
  ZipArchive archive;
  archive.file_ = file;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (at > end || end - at < kListedSize || file.substr(at, kListed.size()) != kListed) return damaged();
    const std::uint64_t flags = number(file, at + 8, 2), method = number(file, at + 10, 2);
    const std::uint64_t nameSize = number(file, at + 28, 2), extraSize = number(file, at + 30, 2);
    Entry entry{.name = {},
                .packed_bytes = number(file, at + 20, 4),
                .size_bytes = number(file, at + 24, 4),
                .at = number(file, at + 42, 4),
                .isDeflated = method == 8};
    if (end - at - kListedSize < nameSize + extraSize) return damaged();
    entry.name = file.substr(at + kListedSize, nameSize);
    if (!takeLarge(file.substr(at + kListedSize + nameSize, extraSize), entry)) return damaged();
    if ((flags & 1) != 0) return refused("", "is a ZIP archive that is encrypted");
    if (method != 0 && method != 8) return refused("", "is a ZIP archive that is not packed by deflate");
    if (entry.packed_bytes > file.size() || entry.size_bytes > kMaxInflation * entry.packed_bytes) return damaged();
    archive.entries_.push_back(std::move(entry));
    at += kListedSize + nameSize + extraSize + number(file, at + 32, 2);
  }
  return archive;
}

std::uint64_t ZipArchive::size_bytes() const {
  std::uint64_t sum = 0;
  for (const Entry& entry : entries_) sum += entry.size_bytes;
  return sum;
}

Result<std::string> ZipArchive::unpacked(const Entry& entry) const {
  if (entry.at > file_.size() || file_.size() - entry.at < kHeadSize || file_.substr(entry.at, kHead.size()) != kHead) {
    return damaged();
  }
  const std::uint64_t from = entry.at + kHeadSize + number(file_, entry.at + 26, 2) + number(file_, entry.at + 28, 2);
  if (from > file_.size() || file_.size() - from < entry.packed_bytes) return damaged();
  const std::string_view packed = file_.substr(from, entry.packed_bytes);
  if (!entry.isDeflated) return std::string(packed);
  const Inflater inflater = makeInflater();
  std::string bytes(entry.size_bytes, '\0');
  const auto result =
      libdeflate_deflate_decompress(inflater.get(), packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr);
  if (result != LIBDEFLATE_SUCCESS) return damaged();
  return bytes;
}

std::string ZipArchive::of(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string archive, list;
  for (const auto& [name, bytes] : files) {
    std::string head;  // as both places have it, from the version that is needed on
    append(head, 10, 2);
    append(head, 0, 8);  // flags, not packed, time
    append(head, libdeflate_crc32(0, bytes.data(), bytes.size()), 4);
    append(head, bytes.size(), 4);
    append(head, bytes.size(), 4);
    append(head, name.size(), 2);
    append(head, 0, 2);
    list.append(kListed).append(2, '\0').append(head).append(10, '\0');
    append(list, archive.size(), 4);
    list += name;
    archive.append(kHead).append(head).append(name).append(bytes);
  }
  const std::size_t at = archive.size();
  archive.append(list).append(kEnd).append(4, '\0');
  append(archive, files.size(), 2);
  append(archive, files.size(), 2);
  append(archive, list.size(), 4);
  append(archive, at, 4);
  append(archive, 0, 2);
  return archive;
}

}  // namespace haptics
