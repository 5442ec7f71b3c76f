#include "common/mesh/canonical_bytes.h"

#include <algorithm>

namespace haptics {

std::size_t CanonicalBytes::size() const noexcept {
  std::size_t bytes = header_.size();
  for (const List list : lists_) bytes += list.size();
  return bytes;
}

std::string CanonicalBytes::copy(std::size_t offset, std::size_t most) const {
  std::string bytes;
  bytes.reserve(std::min(most, size() - std::min(offset, size())));
  const auto add = [&](std::string_view part) {
    const std::size_t skipped = std::min(offset, part.size());
    offset -= skipped;
    bytes += part.substr(skipped, most - bytes.size());
  };
  add(header_);
  for (const List list : lists_) add({reinterpret_cast<const char*>(list.data()), list.size()});
  return bytes;
}

ContentHash CanonicalBytes::hash() const {
  Hasher hasher;
  hasher.add(std::as_bytes(std::span(header_)));
  for (const List list : lists_) hasher.add(list);
  return hasher.finish();
}

}  // namespace haptics
