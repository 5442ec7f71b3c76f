#include "common/importer/x3d_text.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/importer/x3d_nodes.h"
#include "common/importer/x3d_shapes.h"
#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

// By their names for Assimp.
constexpr std::string_view kGroups[] = {"Group", "Transform"};

// Left to Assimp, for the names that their points have, and not felt.
constexpr std::string_view kSkipped[] = {"PointSet", "IndexedLineSet", "LineSet", "Inline"};

// What may stand among the nodes of a group.
constexpr std::string_view kNoNodes[] = {"ROUTE", "IS", "IMPORT", "EXPORT", "ProtoDeclare", "ExternProtoDeclare"};

constexpr std::string_view kOfPoints[] = {"Coordinate", "CoordinateDouble", "GeoCoordinate"};

/// Fields of numbers: so many, or so many to each point of a list.
struct NumbersField {
  std::string_view node, field;
  std::size_t count;
  bool isList;
};
constexpr NumbersField kNumbers[] = {{"Coordinate", "point", 3, true},  {"Transform", "translation", 3, false},
                                     {"Transform", "scale", 3, false},  {"Transform", "center", 3, false},
                                     {"Box", "size", 3, false},         {"Sphere", "radius", 1, false},
                                     {"Rectangle2D", "size", 2, false}, {"TriangleSet2D", "vertices", 2, true}};

// Without which they have no face, and Assimp refuses the file.
constexpr std::pair<std::string_view, std::string_view> kFaceLists[] = {
    {"IndexedFaceSet", "coordIndex"},   {"IndexedTriangleSet", "index"}, {"IndexedTriangleStripSet", "index"},
    {"IndexedTriangleFanSet", "index"}, {"TriangleFanSet", "fanCount"},  {"TriangleStripSet", "stripCount"}};

// The numbers of points, and of some -1 after each face.
constexpr std::string_view kIndexed[] = {"IndexedTriangleSet", "IndexedTriangleStripSet", "IndexedTriangleFanSet"};

/// Indices without faces of no corner.
std::string withoutEmpty(std::string_view indices) {
  std::string text;
  std::string_view before = "-1";
  eachWord(indices, [&](std::string_view word) {
    if (word != "-1" || before != "-1") text.append(word).append(1, ' ');
    before = word;
  });
  return text;
}

/// Faces' indices, and with them the corners of each, the other way round.
std::string reversed(std::string_view indices) {
  const std::string plain = withoutEmpty(indices);
  std::vector<std::string_view> words = wordsIn(plain);
  if (!words.empty() && words.back() == "-1") words.pop_back();
  std::string text;
  for (auto word = words.rbegin(); word != words.rend(); ++word) text.append(*word).append(" ");
  return text;
}

class X3dPreparing {
 public:
  explicit X3dPreparing(std::string_view file) : rewriting_(file) {}

  Result<X3dText> run() {
    countPoints();
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (rewriting_.isReplaced(tag)) return true;
      if (tag.ends) {
        end(tag);
      } else {
        begin(tag);
      }
      return fault_.empty();
    });
    if (!fault_.empty()) return refused("", fault_);
    prepared_.text = rewriting_.end();
    return std::move(prepared_);
  }

 private:
  /// An element that has not ended.
  struct Open {
    std::string_view endName = {};  ///< Instead of its own; empty: its own.
    std::string_view after = {};    ///< Goes after its end.
    std::string_view definition = {};
    std::optional<long> chosen = {};  ///< Of a choice: the child that is shown.
    long children = 0;
    bool isEmpty = true;     ///< For Assimp.
    bool isLeftOut = false;  ///< Of a choice, at which Assimp takes other children for it than there are.
    bool isHidden = false;
  };

  XmlRewriting rewriting_;
  X3dText prepared_;
  std::string fault_;
  std::vector<Open> open_;
  std::map<std::size_t, std::size_t> points_;  ///< Of clockwise TriangleSets, by where each begins.
  std::set<std::string_view> names_;           ///< Of DEF.
  std::set<std::string_view> openNames_;       ///< Of those that have not ended.
  std::size_t mostOfStrips_ = rewriting_.text().size();

  [[nodiscard]] static bool endsItself(const XmlTag& tag) { return tag.inside.ends_with('/'); }

  static bool isClockwise(const XmlTag& tag) { return isFalse(tag.inside, "ccw"); }

  void countPoints() {
    std::vector<std::size_t*> open;  // what counts the points of each
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (tag.ends) {
        if (!open.empty()) open.pop_back();
        return true;
      }
      if (const std::string_view name = attributeIn(tag.inside, "DEF"); !name.empty()) names_.insert(name);
      if (!open.empty() && open.back() != nullptr && *open.back() == 0 && isOneOf(kOfPoints, tag.name)) {
        eachWord(attributeIn(tag.inside, "point"), [&](std::string_view) { ++*open.back(); });
        *open.back() /= 3;
      }
      if (endsItself(tag)) return true;
      open.push_back(tag.name == "TriangleSet" && isClockwise(tag) ? &points_[tag.begin] : nullptr);
      return true;
    });
  }

  void begin(const XmlTag& tag) {
    const bool isKept = isFeltX3dNode(tag.name);
    const bool isProxy = attributeIn(tag.inside, "containerField") == "proxy";
    prepared_.skipped += isOneOf(kSkipped, tag.name) || (!isKept && !isUnfeltX3dNode(tag.name)) ? 1 : 0;
    prepared_.unshown += isProxy ? 1 : 0;
    Open own;
    if (!open_.empty() && !isProxy) {
      Open& parent = open_.back();
      const bool isNode = !isOneOf(kNoNodes, tag.name) && !tag.name.starts_with("Metadata");
      own.isLeftOut = isNode && parent.chosen && *parent.chosen != parent.children;
      own.isHidden = parent.isHidden || own.isLeftOut;
      parent.children += isNode ? 1 : 0;
      parent.isEmpty = parent.isEmpty && !isKept;
    }
    if (isProxy || !isKept) {
      rewriting_.replaceElement(tag, "");
      return;
    }
    take(tag, own);
    open_.push_back(own);
    if (endsItself(tag)) end(tag);
  }

  void end(const XmlTag& tag) {
    if (open_.empty()) return;
    const Open own = open_.back();
    open_.pop_back();
    if (!own.definition.empty()) openNames_.erase(own.definition);
    if (own.isEmpty) fill(tag, own.endName.empty() ? tag.name : own.endName);
    if (tag.ends && !own.endName.empty()) rewriting_.replace(tag.name, own.endName);
    if (!own.after.empty()) rewriting_.insertAfter(tag, own.after);
  }

  /// Assimp leaves a group without nodes twice, and puts what follows it into another one, or none.
  void fill(const XmlTag& tag, std::string_view name) {
    if (!isOneOf(kGroups, name)) return;
    if (tag.ends) {
      rewriting_.insertBefore(tag, "<Shape/>");
    } else {
      rewriting_.replace(tag.inside.substr(tag.inside.size() - 1), "><Shape/></" + std::string(name));
    }
  }

  /// Assimp takes some words for 0.
  void checkNumbers(const XmlTag& tag) {
    const auto as = x3dNodesReadAs().find(tag.name);
    const std::string_view name = as != x3dNodesReadAs().end()  ? as->second
                                  : tag.name == "GeoCoordinate" ? std::string_view("Coordinate")
                                                                : tag.name;
    for (const auto& [node, field, count, isList] : kNumbers) {
      if (node != name) continue;
      const std::string_view text = attributeIn(tag.inside, field);
      std::size_t words = 0;
      std::string_view wrong;
      eachWord(text, [&](std::string_view word) {
        ++words;
        if (wrong.empty() && !numberOf<double>(word)) wrong = word;
      });
      const bool comesOut = isList ? words % count == 0 : words == count || text.empty();
      if ((wrong.empty() && comesOut) || !fault_.empty()) continue;
      fault_ = "has a " + std::string(tag.name) + " whose " + std::string(field) + " has " +
               (wrong.empty() ? std::to_string(words) + " numbers" : inQuotes(wrong)) + "; it has " +
               std::to_string(count) + " numbers" + (isList ? " for each point" : "");
    }
    if (!isOneOf(kIndexed, name)) return;
    eachWord(attributeIn(tag.inside, "index"), [&](std::string_view word) {
      if (word == "-1" || numberOf<std::uint32_t>(word) || !fault_.empty()) return;
      fault_ = "has an " + std::string(name) + " whose index has " + inQuotes(word) +
               "; it has the numbers of points, from 0";
    });
  }

  void take(const XmlTag& tag, Open& own) {
    const auto attribute = [&](std::string_view name) { return attributeIn(tag.inside, name); };
    checkNumbers(tag);
    if (const std::string_view used = attribute("USE"); !used.empty() && fault_.empty()) {
      const bool isOpen = openNames_.contains(used);
      if (isOpen || !names_.contains(used))
        fault_ = "uses a " + std::string(tag.name) + " of the name " + inQuotes(used) + " (USE), which is " +
                 (isOpen ? "what it is in" : "not there (DEF)");
    }
    if (openNames_.insert(attribute("DEF")).second) own.definition = attribute("DEF");
    if (tag.name == "unit" && attribute("category") == "length") prepared_.unit = attribute("conversionFactor");
    const bool isUsed = !attribute("USE").empty();
    own.isEmpty = !isUsed;
    if ((isFalse(tag.inside, "visible") && !isUsed) || own.isLeftOut) {
      rewriting_.insertBefore(tag, "<Switch whichChoice=\"-1\">");
      own.after = "</Switch>";
      own.isHidden = true;
    }
    if (tag.name == "LOD") own.chosen = 0;
    if (tag.name == "Switch") {
      const auto words = wordsIn(attribute("whichChoice"));
      own.chosen = words.empty() ? -1 : numberOf<long>(words.front()).value_or(-1);
    }
    prepared_.unshown += tag.name == "Shape" && own.isHidden ? 1 : 0;
    if (tag.name == "GeoCoordinate") {
      takeGeo(tag, own);
    } else if (isMadeOfFaces(tag.name)) {
      takeMade(tag, own);
    } else if (const auto as = x3dNodesReadAs().find(tag.name); as != x3dNodesReadAs().end()) {
      rewriting_.replace(tag.name, as->second);
      own.endName = as->second;
      if (own.endName == "Transform") takeRotations(tag);
    } else if (tag.name == "Transform") {
      takeRotations(tag);
    } else if (!isUsed && hasNoFace(tag)) {
      own.endName = "PointSet";
      rewriting_.replace(tag.name, own.endName);
    } else {
      turn(tag, own);
    }
    if (isOneOf(kOfPoints, tag.name) && !isUsed && wordsIn(attribute("point")).empty())
      rewriting_.replace(tag.inside.substr(0, 0), " point=\"0 0 0 0 0 0 0 0 0\"");  // Assimp ends on none
  }

  static bool hasNoFace(const XmlTag& tag) {
    return std::any_of(std::begin(kFaceLists), std::end(kFaceLists), [&](const auto& list) {
      return list.first == tag.name && wordsIn(attributeIn(tag.inside, list.second)).empty();
    });
  }

  /// Assimp shears and scales by an axis whose length is not 1.
  void takeRotations(const XmlTag& tag) {
    std::string_view fields[] = {"rotation", "scaleOrientation"};
    std::string_view texts[] = {attributeIn(tag.inside, fields[0]), attributeIn(tag.inside, fields[1])};
    if (texts[1].data() < texts[0].data()) std::swap(fields[0], fields[1]), std::swap(texts[0], texts[1]);
    for (int i = 0; i < 2; ++i) {
      if (texts[i].empty()) continue;
      const auto rotation = ofUnitAxis(texts[i]);
      if (rotation) {
        rewriting_.replace(texts[i], *rotation);
      } else if (fault_.empty()) {
        fault_ = "has a " + std::string(tag.name) + " whose " + std::string(fields[i]) + " is " + inQuotes(texts[i]) +
                 "; it is an axis, which has a length, and an angle";
      }
    }
  }

  void takeGeo(const XmlTag& tag, Open& own) {
    const std::string_view system = attributeIn(tag.inside, "geoSystem");
    if (system.find("GC") == system.npos && attributeIn(tag.inside, "USE").empty()) {
      fault_ = "has points in GeoCoordinate of geoSystem " + inQuotes(system.empty() ? "GD" : system) +
               ", which is not in metres along three axes; export it with \"GC\", or with Coordinate";
      return;
    }
    own.endName = "Coordinate";
    rewriting_.replace(tag.name, own.endName);
  }

  void takeMade(const XmlTag& tag, Open& own) {
    own.endName = "IndexedFaceSet";
    if (!attributeIn(tag.inside, "USE").empty()) {
      rewriting_.replace(tag.name, own.endName);
      return;
    }
    const auto made = facesOfX3dShape(tag.name, tag.inside);
    if (!made) {
      fault_ = made.error().reason;
      return;
    }
    const std::string_view definition = attributeIn(tag.inside, "DEF");
    std::string faces = "<" + std::string(own.endName);
    if (!definition.empty()) faces.append(" DEF=\"").append(definition).append("\"");
    faces += *made;
    if (endsItself(tag)) faces.append("</").append(own.endName).append(">");
    rewriting_.replace(rewriting_.whole(tag), faces);
  }

  /// Shapes of which Assimp looks at ccw="false" are left as they are: triangles by index, strips and fans.
  void turn(const XmlTag& tag, Open& own) {
    if (tag.name == "IndexedFaceSet") {
      takeFaces(tag);
    } else if (tag.name == "TriangleSet" && isClockwise(tag)) {
      own.endName = "IndexedTriangleSet";
      rewriting_.replace(tag.name, own.endName);
      if (attributeIn(tag.inside, "USE").empty()) indexTriangles(tag);
    } else if (tag.name == "TriangleStripSet") {
      own.endName = "IndexedTriangleStripSet";
      rewriting_.replace(tag.name, own.endName);
      if (attributeIn(tag.inside, "USE").empty()) indexStrips(tag);
    }
  }

  /// Assimp ends at a face without corners, and takes any negative number for the end of one.
  void takeFaces(const XmlTag& tag) {
    const std::string_view indices = attributeIn(tag.inside, "coordIndex");
    std::string_view before = "-1";
    bool hasEmpty = false;
    eachWord(indices, [&](std::string_view word) {
      const bool ends = word == "-1";
      hasEmpty = hasEmpty || (ends && before == word);
      before = word;
      if (ends || numberOf<std::uint32_t>(word) || !fault_.empty()) return;
      fault_ = "has an IndexedFaceSet whose coordIndex has " + inQuotes(word) +
               "; it has the numbers of points, from 0, and -1 after each face";
    });
    if (isClockwise(tag)) {
      if (!indices.empty()) rewriting_.replace(indices, reversed(indices));
    } else if (hasEmpty) {
      rewriting_.replace(indices, withoutEmpty(indices));
    }
  }

  void insertIndex(const XmlTag& tag, const std::string& index) {
    rewriting_.replace(tag.inside.substr(0, 0), " index=\"" + index + '"');
  }

  void indexTriangles(const XmlTag& tag) {
    const std::size_t points = points_[tag.begin];
    if (points == 0) {
      fault_ = "has a TriangleSet of ccw=\"false\" without points of its own; give it a Coordinate with a point list";
      return;
    }
    std::string index;
    for (std::size_t point = 0; point < points; ++point) index.append(std::to_string(point)).append(1, ' ');
    insertIndex(tag, index);
  }

  void indexStrips(const XmlTag& tag) {
    std::size_t next = 0;
    std::string index;
    for (const std::string_view word : wordsIn(attributeIn(tag.inside, "stripCount"))) {
      const auto count = numberOf<std::size_t>(word);
      if (!count || *count < 3 || *count > mostOfStrips_) {
        fault_ = "has a stripCount of " + inQuotes(word) +
                 (count && *count < 3 ? "; a strip has three points or more" : "; there is no room for so many points");
        return;
      }
      mostOfStrips_ -= *count;
      for (const std::size_t end = next + *count; next < end; ++next) index.append(std::to_string(next)).append(1, ' ');
      index += "-1 ";
    }
    insertIndex(tag, index);
  }
};

}  // namespace

Result<std::string> withGroupsInPlace(std::string file) {
  const auto isGroup = [&](const XmlTag& tag) {
    if (isOneOf(kGroups, tag.name)) return true;
    const auto as = x3dNodesReadAs().find(tag.name);
    return as != x3dNodesReadAs().end() && isOneOf(kGroups, as->second);
  };
  struct Open {
    std::string_view definition;
    std::size_t begin;  // in the text that is written
    bool isReplaced;
  };
  const std::size_t most = 64'000'000 + 4 * file.size();
  std::map<std::string_view, std::pair<std::size_t, std::size_t>> groups;
  std::vector<Open> open;
  std::string written;
  std::size_t taken = 0;
  bool fits = true;
  eachTag(file, [&](const XmlTag& tag) {
    const std::size_t end = static_cast<std::size_t>(tag.inside.data() + tag.inside.size() - file.data()) + 1;
    Open own{attributeIn(tag.inside, "DEF"), written.size() + tag.begin - taken, false};
    if (!tag.ends) {
      const auto used = groups.find(attributeIn(tag.inside, "USE"));
      own.isReplaced = used != groups.end() && isGroup(tag) && attributeIn(tag.inside, "containerField") != "proxy";
      if (own.isReplaced) {
        const auto [from, to] = used->second;
        fits = written.size() + (to - from) <= most;
        if (!fits) return false;
        written.append(file, taken, tag.begin - taken);
        written.append(std::string(written, from, to - from));
        taken = std::min(end, file.size());
      }
      open.push_back(own);
      if (!tag.inside.ends_with('/')) return true;
    }
    if (open.empty()) return true;
    own = open.back();
    open.pop_back();
    if (own.isReplaced) taken = std::min(end, file.size());
    if (own.definition.empty() || !isGroup(tag)) return true;
    written.append(file, taken, std::min(end, file.size()) - taken);
    taken = std::min(end, file.size());
    groups[own.definition] = {own.begin, written.size()};
    return true;
  });
  if (!fits) return refused("", "uses groups so often (USE) that they make many times its bytes");
  if (taken == 0) return file;
  return written.append(file, taken);
}

Result<X3dText> preparedX3d(std::string_view file) { return X3dPreparing(file).run(); }

}  // namespace haptics
