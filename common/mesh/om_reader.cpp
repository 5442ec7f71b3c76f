#include <bit>
#include <cstring>
#include <optional>
#include <vector>

#include "common/mesh/face_list.h"
#include "common/mesh/mesh_readers.h"

namespace haptics {
namespace {

// OpenMesh's own binary format, as OpenMesh/Core/IO/OMFormat.hh of version 9.0 describes it.
struct OmHeader {
  char meshKind = 0;  // 'T'riangles, 'Q'uads, 'P'olygons
  std::uint8_t version = 0;
  std::uint64_t vertices = 0, faces = 0, edges = 0;
};
constexpr std::size_t kOmHeaderSize = 16;

constexpr std::uint8_t versionNumber(unsigned major, unsigned minor) {
  return static_cast<std::uint8_t>(major << 5 | minor);
}
constexpr std::uint8_t kHalfedgeVersion = versionNumber(2, 0);   // topology as half-edges from here on
constexpr std::uint8_t kNamedTypeVersion = versionNumber(2, 2);  // named properties give their type
constexpr std::uint8_t kNewestVersion = versionNumber(2, 2);

enum Entity : unsigned { kVertex = 0, kMesh = 1, kFace = 2, kEdge = 4, kHalfedge = 6, kSentinel = 7 };
enum Type : unsigned { kPosition = 0, kStatus = 3, kCustom = 6, kTopology = 7 };

constexpr std::uint64_t kStatusSize = 4;

struct Chunk {
  bool named, isFloat;
  unsigned entity, type, dimension, bits;

  explicit Chunk(unsigned word)
      : named(word >> 1 & 1),
        isFloat(word >> 10 & 1),
        entity(word >> 2 & 7),
        type(word >> 5 & 15),
        dimension((word >> 11 & 7) + 1),
        bits(word >> 14 & 3) {}

  [[nodiscard]] std::uint64_t integerSize() const { return std::uint64_t{1} << bits; }
  [[nodiscard]] std::uint64_t vectorSize() const {
    if (type == kStatus) return kStatusSize;  // whatever the chunk's own bits say
    return dimension * (isFloat ? 4U << bits : 1U << bits);
  }
};

template <class T>
std::optional<T> take(std::string_view& rest) {
  static_assert(std::endian::native == std::endian::little);
  if (rest.size() < sizeof(T)) return std::nullopt;
  T value;
  std::memcpy(&value, rest.data(), sizeof value);
  rest.remove_prefix(sizeof value);
  return value;
}

tl::unexpected<Error> cutOff() { return refused("", "is cut off: the OM file ends inside a chunk"); }

Result<OmHeader> readOmHeader(std::string_view& rest) {
  if (rest.size() < kOmHeaderSize || !rest.starts_with("OM")) return refused("", "does not begin with \"OM\"");
  OmHeader header;
  header.meshKind = rest[2];
  header.version = static_cast<std::uint8_t>(rest[3]);
  rest.remove_prefix(4);
  header.vertices = *take<std::uint32_t>(rest);
  header.faces = *take<std::uint32_t>(rest);
  header.edges = *take<std::uint32_t>(rest);
  if (std::string_view("TQP").find(header.meshKind) == std::string_view::npos) {
    return refused("", "its header gives a mesh kind that is none of T, Q and P");
  }
  if (header.version > kNewestVersion) return refused("", "has a version of the OM format newer than 2.2");
  return header;
}

/// Bytes of the chunk's data; nothing when that cannot be told.
std::optional<std::uint64_t> dataSize(const Chunk& chunk, const OmHeader& header, std::string_view data) {
  if (chunk.type == kCustom) {
    const auto size = take<std::uint32_t>(data);
    return size ? std::optional<std::uint64_t>(sizeof *size + *size) : std::nullopt;
  }
  const std::uint64_t n = chunk.integerSize();
  switch (chunk.entity) {
    case kVertex:
      return header.vertices * (chunk.type == kTopology ? n : chunk.vectorSize());
    case kHalfedge:
      return chunk.type == kTopology ? header.edges * 6 * n : 2 * header.edges * chunk.vectorSize();
    case kEdge:
      return header.edges * chunk.vectorSize();
    case kMesh:
      return chunk.vectorSize();
    case kFace:
      break;
    default:
      return std::nullopt;
  }
  if (chunk.type != kTopology) return header.faces * chunk.vectorSize();
  if (header.version >= kHalfedgeVersion) return header.faces * n;
  if (header.meshKind != 'P') return header.faces * (header.meshKind == 'T' ? 3 : 4) * n;
  std::uint64_t size = 0;
  for (std::uint64_t f = 0; f < header.faces; ++f) {
    const auto corners = take<std::uint16_t>(data);
    if (!corners || data.size() < *corners * n) return std::nullopt;
    data.remove_prefix(*corners * n);
    size += sizeof *corners + *corners * n;
  }
  return size;
}

bool skipName(std::string_view& rest) {
  const auto length = take<std::uint8_t>(rest);
  if (!length || rest.size() < *length) return false;
  rest.remove_prefix(*length);
  return true;
}

Result<void> readPositions(const Chunk& chunk, const OmHeader& header, std::string_view data, PolygonSoup& soup) {
  if (!chunk.isFloat || chunk.dimension != 3 || chunk.bits > 1) {
    return refused("", "its vertices should be three float32 or float64 each");
  }
  soup.isFloat32 = chunk.bits == 0;
  for (std::uint64_t i = 0; i < header.vertices; ++i) {
    Vec3& point = soup.vertices.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = soup.isFloat32 ? static_cast<double>(*take<float>(data)) : *take<double>(data);
    }
  }
  return {};
}

/// Of 1, 2 or 4 bytes.
struct Numbers {
  std::string_view rest;
  unsigned bits = 0;

  std::uint32_t next() {
    return bits == 0 ? *take<std::uint8_t>(rest) : bits == 1 ? *take<std::uint16_t>(rest) : *take<std::uint32_t>(rest);
  }
};

/// Before version 2.0: the corners of each face.
Result<void> readCorners(Numbers faces, const OmHeader& header, PolygonSoup& soup) {
  std::vector<std::uint32_t> corners;
  for (std::uint64_t f = 0; f < header.faces; ++f) {
    corners.resize(header.meshKind == 'P' ? *take<std::uint16_t>(faces.rest) : header.meshKind == 'T' ? 3 : 4);
    for (std::uint32_t& corner : corners) corner = faces.next();
    if (auto ok = addFace(corners, 0, soup); !ok) return ok;
  }
  return {};
}

/// Then a half-edge of each face, and of each half-edge the next one round the face, the vertex that it leads to, and the face.
Result<void> readRings(Numbers faces, Numbers halfedges, const OmHeader& header, PolygonSoup& soup) {
  std::vector<std::uint32_t> next(2 * header.edges), to(next.size()), corners;
  for (std::size_t h = 0; h < next.size(); ++h) {
    next[h] = halfedges.next();
    to[h] = halfedges.next();
    (void)halfedges.next();
  }
  std::size_t sides = 0;  // over all faces: in a mesh, each half-edge belongs to one ring at most
  for (std::uint64_t f = 0; f < header.faces; ++f) {
    corners.clear();
    const std::uint32_t start = faces.next();
    std::uint32_t h = start;
    do {
      if (h >= next.size() || ++sides > next.size()) return refused("", "has faces whose half-edges do not close");
      corners.push_back(to[h]);
      h = next[h];
    } while (h != start);
    if (auto ok = addFace(corners, 0, soup); !ok) return ok;
  }
  return {};
}

}  // namespace

Result<PolygonSoup> readOm(std::string_view file) {
  const auto header = readOmHeader(file);
  if (!header) return tl::unexpected(header.error());
  PolygonSoup soup;
  std::optional<Numbers> faces, halfedges;
  bool hasPositions = false;
  while (!file.empty()) {
    const auto word = take<std::uint16_t>(file);
    if (!word) return cutOff();
    const Chunk chunk(*word);
    if (chunk.entity == kSentinel) break;
    if (chunk.named && !(skipName(file) && (header->version < kNamedTypeVersion || skipName(file)))) return cutOff();
    const auto size = dataSize(chunk, *header, file);
    if (!size || *size > file.size()) return cutOff();
    const std::string_view data = file.substr(0, *size);
    file.remove_prefix(*size);
    const bool isPositions = chunk.entity == kVertex && chunk.type == kPosition;
    const bool isTopology = (chunk.entity == kFace || chunk.entity == kHalfedge) && chunk.type == kTopology;
    if (!isPositions && !isTopology) continue;
    std::optional<Numbers>& numbers = chunk.entity == kFace ? faces : halfedges;
    if (chunk.named || (isPositions ? hasPositions : numbers.has_value())) {
      return refused("", "gives the same part of the mesh twice");
    }
    if (isPositions) {
      hasPositions = true;
      if (auto ok = readPositions(chunk, *header, data, soup); !ok) return tl::unexpected(std::move(ok).error());
    } else if (chunk.bits > 2) {
      return refused("", "numbers its parts with 64 bits; 32 are taken");
    } else {
      numbers = Numbers{data, chunk.bits};
    }
  }
  const bool hasRings = header->version >= kHalfedgeVersion;
  if (!hasPositions || !faces || halfedges.has_value() != hasRings) {
    return refused("", "is cut off or incomplete: vertices, faces or half-edges are missing");
  }
  const auto read = hasRings ? readRings(*faces, *halfedges, *header, soup) : readCorners(*faces, *header, soup);
  if (!read) return tl::unexpected(read.error());
  return soup;
}

}  // namespace haptics
