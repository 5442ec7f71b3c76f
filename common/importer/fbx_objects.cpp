#include "common/importer/fbx_objects.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/fbx_records.h"
#include "common/maths/vec.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

using Id = std::int64_t;

struct Geometry {
  std::string_view name, kind;
  std::uint64_t vertices = 0;
  std::string fault = {};
};

/// How a model is scaled and turned within its parent: InheritType.
constexpr std::int64_t kScaledLast = 0, kAsTransform = 1;  // RrSs; RSrs, which is what Assimp does. 2: Rrs

/// A model, or a layer of the display.
struct Shower {
  std::string_view name = {};
  bool shows = true, isVisible = true, inherits = true, isLayer = false;
  std::int64_t inheritType = kScaledLast;
  Vec3 scale{1};
  bool isTurned = false;
};

struct Connection {
  std::size_t at;  ///< Of its kind, of two letters.
  Id below, above;
};

/// "part" of "Model::part" or of "part\0\1Model".
std::string_view plainName(std::string_view name) {
  if (const std::size_t end = name.find('\0'); end != name.npos) return name.substr(0, end);
  const std::size_t colons = name.find("::");
  return colons != name.npos ? name.substr(colons + 2) : name;
}

class Objects {
 public:
  explicit Objects(std::string_view file) : file_(file) {}

  Result<void> read() {
    const auto damage = eachFbxRecord(file_, [&](const FbxRecord& record) { take(record); });
    constexpr std::int64_t kOldest = 7100;
    if (version_ > 0 && version_ < kOldest) {
      return refused("", "is FBX of version " + std::to_string(version_) + " (FBXVersion); " + std::to_string(kOldest) +
                             ", of 2011, and later ones are read: save it anew");
    }
    if (damage) return refused("", std::string(*damage));
    if (!unended_.empty()) return refused("", unended_);
    return {};
  }

  /// Where connections of geometries to hidden models have their kinds.
  Result<std::vector<std::size_t>> hide(FbxFile& found) const {
    std::vector<std::size_t> kinds;
    std::string misplaced;
    std::set<Id> placed;
    for (const Connection& connection : connections_) {
      const auto geometry = geometries_.find(connection.below);
      if (geometry == geometries_.end() || !showers_.contains(connection.above)) continue;
      if (!leadsToScene(connection.above)) continue;
      placed.insert(connection.below);
      const bool isMesh = geometry->second.kind == "Mesh";
      if (isHidden(connection.above)) {
        kinds.push_back(connection.at);
        found.leftOut.unshown += isMesh ? 1 : 0;
        continue;
      }
      found.skipped += isMesh ? 0 : 1;
      if (found.fault.empty()) found.fault = geometry->second.fault;
      if (misplaced.empty()) misplaced = misplacedBy(connection.above);
    }
    for (const auto& [id, geometry] : geometries_)
      found.leftOut.unshown += geometry.kind == "Mesh" && !placed.contains(id) ? 1 : 0;
    if (!misplaced.empty()) return refused("", misplaced);
    return kinds;
  }

 private:
  const std::string_view file_;
  std::vector<std::string_view> path_;
  std::int64_t version_ = 0;
  Id object_ = 0;
  std::map<Id, Geometry> geometries_;
  std::map<Id, Shower> showers_;
  std::vector<Connection> connections_;
  std::multimap<Id, Id> above_;
  std::string unended_;

  void take(const FbxRecord& record) {
    const auto depth = static_cast<std::size_t>(std::max(record.depth, 0));
    path_.resize(std::min(depth, path_.size()));
    path_.push_back(record.name);
    if (path_.size() != depth + 1) return;  // within braces that no record has
    const std::string_view top = path_.front();
    if (record.name == "FBXVersion" && version_ == 0) version_ = record.numberAt(0);
    if (top == "Connections" && depth == 1 && record.name == "C") takeConnection(record);
    if (top != "Objects" || depth == 0) return;
    if (depth == 1) {
      takeObject(record);
    } else if (path_[1] == "Geometry") {
      takeOfGeometry(record);
    } else if (record.name == "P") {
      takeProperty(record);
    }
  }

  void takeConnection(const FbxRecord& record) {
    if (record.textAt(0) != "OO") return;
    const Id below = record.numberAt(1), above = record.numberAt(2);
    connections_.push_back({static_cast<std::size_t>(record.textAt(0).data() - file_.data()), below, above});
    above_.emplace(below, above);
  }

  void takeObject(const FbxRecord& record) {
    object_ = record.numberAt(0);
    constexpr std::string_view kNoShapes[] = {"Shape", "Boundary", "Line"};  // Assimp has lines
    const std::string_view kind = record.textAt(2);
    if (record.name == "Geometry" && std::ranges::find(kNoShapes, kind) == std::end(kNoShapes))
      geometries_[object_] = {plainName(record.textAt(1)), kind};
    if (record.name == "Model") showers_[object_] = {.name = plainName(record.textAt(1))};
    if (record.name == "CollectionExclusive") showers_[object_] = {.isLayer = true};
  }

  void takeProperty(const FbxRecord& record) {
    const auto at = showers_.find(object_);
    if (at == showers_.end() || record.values.size() < 5) return;
    const bool is = record.numberAt(4) != 0;
    if (record.textAt(0) == "Show") at->second.shows = is;
    if (record.textAt(0) == "Visibility") at->second.isVisible = is;
    if (record.textAt(0) == "Visibility Inheritance") at->second.inherits = is;
    if (record.textAt(0) == "InheritType") at->second.inheritType = record.numberAt(4);
    const Vec3 vector(record.realAt(4), record.realAt(5), record.realAt(6));
    if (record.textAt(0) == "Lcl Scaling") at->second.scale = vector;
    const bool turns = record.textAt(0) == "Lcl Rotation" || record.textAt(0) == "PreRotation";
    at->second.isTurned = at->second.isTurned || (turns && vector != Vec3(0));
  }

  /// Arrays are in the record, or in a text in the record "a" within it.
  void takeOfGeometry(const FbxRecord& record) {
    const auto at = geometries_.find(object_);
    if (at == geometries_.end() || at->second.kind != "Mesh") return;
    const bool isWithin = record.depth == 3 && record.name == "a";
    const std::string_view name = isWithin ? path_[2] : record.name;
    if (!isWithin && record.depth != 2) return;
    if (name == "Vertices") {
      if (!record.values.empty() && record.values[0].count > 0) at->second.vertices = record.values[0].count / 3;
      if (record.values.size() == 1 && record.values[0].bytes.starts_with('*')) {
        at->second.vertices = static_cast<std::uint64_t>(countIn(record.values[0].bytes)) / 3;
      } else if (record.values.size() > 1 && !isWithin) {
        at->second.vertices = (static_cast<std::uint64_t>(std::ranges::count(record.list, ',')) + 1) / 3;
      }
    }
    if (name == "PolygonVertexIndex") check(at->second, wholeNumbersOf(record));
  }

  static std::int64_t countIn(std::string_view word) {
    std::int64_t count = 0;
    for (const char c : word.substr(1))
      count = c >= '0' && c <= '9' && count < 1'000'000'000 ? 10 * count + c - '0' : count;
    return count;
  }

  /// The last corner of a polygon has the vertex's number as -1 less it.
  void check(Geometry& geometry, const std::vector<std::int64_t>& corners) {
    if (corners.empty()) return;
    const std::string name = "the geometry " + inQuotes(geometry.name);
    if (corners.back() >= 0 && unended_.empty()) {
      unended_ = "has " + name + " whose last polygon does not end: the last number of PolygonVertexIndex is " +
                 std::to_string(corners.back()) + "; a polygon's last is below 0";
    }
    for (const std::int64_t corner : corners) {
      const std::int64_t vertex = corner < 0 ? -1 - corner : corner;
      if (static_cast<std::uint64_t>(vertex) < geometry.vertices) continue;
      geometry.fault = name + " names vertex " + std::to_string(vertex) + " (from 0) of " +
                       std::to_string(geometry.vertices) + " in PolygonVertexIndex";
      return;
    }
  }

  [[nodiscard]] bool leadsToScene(Id model) const {
    std::set<Id> seen;
    for (std::vector<Id> left{model}; !left.empty();) {
      const Id id = left.back();
      left.pop_back();
      if (id == 0) return true;
      const auto own = showers_.find(id);
      if (own == showers_.end() || own->second.isLayer || !seen.insert(id).second) continue;
      for (auto [at, end] = above_.equal_range(id); at != end; ++at) left.push_back(at->second);
    }
    return false;
  }

  [[nodiscard]] bool isHidden(Id model) const {
    if (!showers_.at(model).shows || isOnHiddenLayer(model)) return true;
    std::set<Id> seen;
    for (std::optional<Id> id = model; id && seen.insert(*id).second; id = parentOf(*id)) {
      const Shower& own = showers_.at(*id);
      if (!own.isVisible) return true;
      if (!own.inherits) return false;
    }
    return false;
  }

  /// Another model.
  [[nodiscard]] std::optional<Id> parentOf(Id model) const {
    for (auto [at, end] = above_.equal_range(model); at != end; ++at) {
      const auto above = showers_.find(at->second);
      if (above != showers_.end() && !above->second.isLayer) return at->second;
    }
    return std::nullopt;
  }

  /// Why a model is not where a product of transforms puts it; empty: it is.
  [[nodiscard]] std::string misplacedBy(Id model) const {
    const auto scales = [](const Vec3& by) { return glm::length(by - Vec3(1)) > 1e-6; };
    const auto isUneven = [](const Vec3& by) { return glm::length(by - Vec3(by.x)) > 1e-6 * std::abs(by.x); };
    std::set<Id> seen;
    for (std::optional<Id> id = model; id && seen.insert(*id).second; id = parentOf(*id)) {
      const Shower& own = showers_.at(*id);
      if (own.inheritType == kAsTransform) continue;
      std::optional<Id> above = parentOf(*id);
      std::set<Id> passed;
      for (bool isFirst = true; above && passed.insert(*above).second; above = parentOf(*above), isFirst = false) {
        const Vec3& by = showers_.at(*above).scale;
        const bool isWrong = own.inheritType == kScaledLast ? own.isTurned && isUneven(by) : isFirst && scales(by);
        if (!isWrong) continue;
        return "has the model " + inQuotes(own.name) + " of InheritType " + std::to_string(own.inheritType) +
               " below " + inQuotes(showers_.at(*above).name) +
               ", which is scaled: where that puts it is not read; export it with InheritType 1, or apply the scale";
      }
    }
    return {};
  }

  [[nodiscard]] bool isOnHiddenLayer(Id model) const {
    const auto [first, last] = above_.equal_range(model);
    return std::any_of(first, last, [&](const auto& connection) {
      const auto above = showers_.find(connection.second);
      return above != showers_.end() && above->second.isLayer && !above->second.shows;
    });
  }
};

}  // namespace

Result<FbxFile> preparedFbx(std::string file) {
  if (file.starts_with("\xef\xbb\xbf")) file.erase(0, 3);
  FbxFile found;
  std::vector<std::size_t> kinds;
  {
    Objects objects(file);
    if (auto ok = objects.read(); !ok) return tl::unexpected(std::move(ok).error());
    auto hidden = objects.hide(found);
    if (!hidden) return tl::unexpected(std::move(hidden).error());
    kinds = *std::move(hidden);
  }
  for (const std::size_t at : kinds) file.replace(at, 2, "PP");  // which Assimp passes over
  found.file = std::move(file);
  return found;
}

}  // namespace haptics
