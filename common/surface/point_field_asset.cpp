#include "common/surface/point_field_asset.h"

#include <array>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace haptics {
namespace {

constexpr std::uint32_t kPointFieldVersion = 1;

struct PointFieldHeader {
  std::array<char, 4> magic{'H', 'P', 'T', 'F'};
  std::uint32_t version = kPointFieldVersion;
  std::uint32_t count = 0;
  float reach_m = 0;
};
static_assert(sizeof(PointFieldHeader) == 16, "the header is copied as it lies");

}  // namespace

CanonicalBytes canonicalBytes(const PointField& field) {
  PointFieldHeader header;
  header.count = static_cast<std::uint32_t>(field.samples().size());
  header.reach_m = field.reach_m();
  std::string bytes;
  append(bytes, header);
  return {std::move(bytes), {std::as_bytes(field.samples())}};
}

std::string encodePointField(const PointField& field) { return canonicalBytes(field).copy(); }

Result<PointField> decodePointField(std::string_view bytes) {
  PointFieldHeader header;
  if (bytes.size() < sizeof header) {
    return refused("header", "the asset has " + std::to_string(bytes.size()) + " bytes; its header alone takes " +
                                 std::to_string(sizeof header));
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != PointFieldHeader{}.magic)
    return refused("magic", "is not \"HPTF\": the asset is not a point field");
  if (header.version != kPointFieldVersion) {
    return refused("version", "is " + std::to_string(header.version) + "; this program reads " +
                                  std::to_string(kPointFieldVersion));
  }
  if (header.count == 0 || header.count > PointField::kMaxSamples) {
    return refused("count",
                   "is " + std::to_string(header.count) + "; give 1 to " + std::to_string(PointField::kMaxSamples));
  }
  const std::size_t size = sizeof header + sizeof(PointSample) * std::size_t{header.count};
  if (bytes.size() != size) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; " + std::to_string(header.count) +
                               " samples take " + std::to_string(size));
  }
  std::vector<PointSample> samples(header.count);
  std::memcpy(static_cast<void*>(samples.data()), bytes.data() + sizeof header, bytes.size() - sizeof header);
  return PointField::make(header.reach_m, std::move(samples));
}

ContentHash hashOf(const PointField& field) { return canonicalBytes(field).hash(); }

}  // namespace haptics
