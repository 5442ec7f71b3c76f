#include "common/surface/field_asset.h"

#include <array>
#include <cstring>
#include <span>
#include <utility>

namespace haptics {
namespace {

constexpr std::uint32_t kFieldVersion = 1;

struct FieldHeader {
  std::array<char, 4> magic{'H', 'S', 'F', 'D'};
  std::uint32_t version = kFieldVersion;
  std::uint32_t width = 0, height = 0;
};
static_assert(sizeof(FieldHeader) == 16, "the header is copied as it lies");

}  // namespace

CanonicalBytes canonicalBytes(const SampledField& field) {
  FieldHeader header;
  header.width = field.width();
  header.height = field.height();
  std::string bytes;
  append(bytes, header);
  return {std::move(bytes), {std::as_bytes(field.samples())}};
}

std::string encodeField(const SampledField& field) { return canonicalBytes(field).copy(); }

Result<SampledField> decodeField(std::string_view bytes) {
  FieldHeader header;
  if (bytes.size() < sizeof header) {
    return refused("header", "the asset has " + std::to_string(bytes.size()) + " bytes; its header alone takes " +
                                 std::to_string(sizeof header));
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != FieldHeader{}.magic) return refused("magic", "is not \"HSFD\": the asset is not a scalar field");
  if (header.version != kFieldVersion) {
    return refused("version",
                   "is " + std::to_string(header.version) + "; this program reads " + std::to_string(kFieldVersion));
  }
  if (auto ok = checkSides(header.width, header.height); !ok) return tl::unexpected(std::move(ok).error());
  const std::size_t count = std::size_t{header.width} * header.height;
  const std::size_t size = sizeof header + sizeof(float) * count;
  if (bytes.size() != size) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; " + std::to_string(header.width) + " * " +
                               std::to_string(header.height) + " samples take " + std::to_string(size));
  }
  std::vector<float> samples(count);
  bytes.substr(sizeof header).copy(reinterpret_cast<char*>(samples.data()), sizeof(float) * samples.size());
  return SampledField::make(header.width, header.height, std::move(samples));
}

ContentHash hashOf(const SampledField& field) { return canonicalBytes(field).hash(); }

}  // namespace haptics
