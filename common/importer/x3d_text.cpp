#include "common/importer/x3d_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

// ISO/IEC 19775-1: nodes that have the fields of the one beside them, and are felt like it.
const std::map<std::string_view, std::string_view>& readAs() {
  static const std::map<std::string_view, std::string_view> names{{"Collision", "Group"},
                                                                  {"Anchor", "Group"},
                                                                  {"Billboard", "Group"},
                                                                  {"CADAssembly", "Group"},
                                                                  {"CADLayer", "Group"},
                                                                  {"CADFace", "Group"},
                                                                  {"PickableGroup", "Group"},
                                                                  {"HAnimSegment", "Group"},
                                                                  {"Layer", "Group"},
                                                                  {"LayerSet", "Group"},
                                                                  {"Viewport", "Group"},
                                                                  {"CADPart", "Transform"},
                                                                  {"HAnimHumanoid", "Transform"},
                                                                  {"HAnimJoint", "Transform"},
                                                                  {"HAnimSite", "Transform"},
                                                                  {"EspduTransform", "Transform"},
                                                                  {"CoordinateDouble", "Coordinate"},
                                                                  {"LOD", "Switch whichChoice=\"0\""},
                                                                  {"Inline", "Group"},
                                                                  {"IndexedLineSet", "PointSet"},
                                                                  {"LineSet", "PointSet"}};
  return names;
}

constexpr std::string_view kSkipped[] = {"Text",
                                         "PointSet",
                                         "Polypoint2D",
                                         "QuadSet",
                                         "IndexedQuadSet",
                                         "NurbsPatchSurface",
                                         "NurbsSweptSurface",
                                         "NurbsSwungSurface",
                                         "NurbsTrimmedSurface",
                                         "IndexedLineSet",
                                         "LineSet",
                                         "Inline",
                                         "ProtoInstance",
                                         "GeoElevationGrid",
                                         "GeoLocation",
                                         "GeoTransform",
                                         "GeoLOD",
                                         "ScreenGroup",
                                         "TransformSensor"};

// Of what cannot be felt and has to be right for Assimp, or is not known to it.
constexpr std::string_view kUnfeltOfX3d[] = {"Appearance",
                                             "Normal",
                                             "Color",
                                             "ColorRGBA",
                                             "TextureCoordinate",
                                             "Tangent",
                                             "MetadataBoolean",
                                             "MetadataDouble",
                                             "MetadataFloat",
                                             "MetadataInteger",
                                             "MetadataSet",
                                             "MetadataString",
                                             "Polypoint2D",
                                             "HAnimMotion",
                                             "EnvironmentLight",
                                             "TextureProjector",
                                             "TextureProjectorParallel",
                                             "ListenerPointSource",
                                             "SpatialSound"};

/// Numbers, and with them the corners of each face, the other way round.
std::string reversed(std::string_view numbers) {
  std::vector<std::string_view> words = wordsIn(numbers);
  if (!words.empty() && words.back() == "-1") words.pop_back();
  std::string text;
  for (auto word = words.rbegin(); word != words.rend(); ++word) text.append(*word).append(" ");
  return text;
}

/// A Cone or Cylinder around the y axis: Assimp has the ends of both in other places, and every second face turned over.
std::string roundFaces(double topRadius, double bottomRadius, double height, bool side, bool top, bool bottom) {
  constexpr int kSides = 64;
  std::string faces, points;
  const auto corner = [&](int i) { return ' ' + std::to_string(i % (2 * kSides)); };
  for (int i = 0; i < kSides && side; ++i) {  // below, above, below, above, ...
    faces += corner(2 * i) + corner(2 * i + 2) + (topRadius > 0 ? corner(2 * i + 3) : "") + corner(2 * i + 1) + " -1";
  }
  for (int i = kSides; i-- > 0 && bottom;) faces += corner(2 * i) + (i == 0 ? " -1" : "");
  for (int i = 0; i < kSides && top; ++i) faces += corner(2 * i + 1) + (i == kSides - 1 ? " -1" : "");
  for (int i = 0; i < kSides; ++i) {
    const double angle = -2 * std::numbers::pi * i / kSides;
    for (const auto& [radius, y] : {std::pair{bottomRadius, -height / 2}, {topRadius, height / 2}}) {
      for (const double number : {radius * std::cos(angle), y, radius * std::sin(angle)}) {
        char text[32];
        points.append(text, std::to_chars(text, text + sizeof text, number).ptr).append(1, ' ');
      }
    }
  }
  return " coordIndex=\"" + faces + "\"><Coordinate point=\"" + points + "\"/>";
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
    std::string_view endName = {};    ///< Instead of its own; empty: its own.
    std::string_view after = {};      ///< Goes after its end.
    std::optional<long> chosen = {};  ///< Of a choice: the child that is shown.
    long children = 0;
    bool isHidden = false;
  };

  XmlRewriting rewriting_;
  X3dText prepared_;
  std::string fault_;
  std::vector<Open> open_;
  std::map<std::size_t, std::size_t> points_;  ///< Of clockwise TriangleSets, by where each begins.
  std::size_t mostOfStrips_ = rewriting_.text().size();

  [[nodiscard]] static bool endsItself(const XmlTag& tag) { return tag.inside.ends_with('/'); }

  static bool isClockwise(const XmlTag& tag) { return attributeIn(tag.inside, "ccw") == "false"; }

  void countPoints() {
    constexpr std::string_view kOfPoints[] = {"Coordinate", "CoordinateDouble", "GeoCoordinate"};
    std::vector<std::size_t*> open;  // what counts the points of each
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (tag.ends) {
        if (!open.empty()) open.pop_back();
        return true;
      }
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
    prepared_.skipped += isOneOf(kSkipped, tag.name) ? 1 : 0;
    if (isOneOf(kUnfeltOfX3d, tag.name)) {
      rewriting_.replaceElement(tag, "");
      return;
    }
    Open own;
    if (!open_.empty()) {
      Open& parent = open_.back();
      own.isHidden = parent.isHidden || (parent.chosen && *parent.chosen != parent.children);
      ++parent.children;
    }
    take(tag, own);
    open_.push_back(own);
    if (endsItself(tag)) end(tag);
  }

  void end(const XmlTag& tag) {
    if (open_.empty()) return;
    const Open own = open_.back();
    open_.pop_back();
    if (tag.ends && !own.endName.empty()) rewriting_.replace(tag.name, own.endName);
    if (!own.after.empty()) rewriting_.insertAfter(tag, own.after);
  }

  void take(const XmlTag& tag, Open& own) {
    const auto attribute = [&](std::string_view name) { return attributeIn(tag.inside, name); };
    if (tag.name == "unit" && attribute("category") == "length") prepared_.unit = attribute("conversionFactor");
    const bool isUsed = !attribute("USE").empty();
    if (attribute("visible") == "false" && !isUsed) {
      rewriting_.insertBefore(tag, "<Switch whichChoice=\"-1\">");
      own.after = "</Switch>";
      own.isHidden = true;
    }
    if (tag.name == "Switch" || tag.name == "LOD") {
      own.chosen = tag.name == "LOD" ? 0 : numberOf<long>(attribute("whichChoice")).value_or(-1);
    }
    prepared_.unshown += tag.name == "Shape" && own.isHidden ? 1 : 0;
    if (tag.name == "GeoCoordinate") {
      takeGeo(tag, own);
    } else if (tag.name == "Cone" || tag.name == "Cylinder") {
      takeRound(tag, own);
    } else if (const auto as = readAs().find(tag.name); as != readAs().end()) {
      rewriting_.replace(tag.name, as->second);
      own.endName = as->second.substr(0, as->second.find(' '));
    } else {
      turn(tag, own);
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

  void takeRound(const XmlTag& tag, Open& own) {
    own.endName = "IndexedFaceSet";
    if (!attributeIn(tag.inside, "USE").empty()) {
      rewriting_.replace(tag.name, own.endName);
      return;
    }
    const auto length = [&](std::string_view name, double instead) {
      const auto words = wordsIn(attributeIn(tag.inside, name));
      const auto value = words.empty() ? instead : numberOf<double>(words.front());
      if (value && *value >= 0 && std::isfinite(*value)) return *value;
      fault_ = "has a " + std::string(tag.name) + " whose " + std::string(name) + " is " +
               inQuotes(attributeIn(tag.inside, name)) + "; it is a number from 0";
      return 0.0;
    };
    const auto has = [&](std::string_view part) { return attributeIn(tag.inside, part) != "false"; };
    const bool isCone = tag.name == "Cone";
    const double radius = length(isCone ? "bottomRadius" : "radius", 1), height = length("height", 2);
    const std::string_view definition = attributeIn(tag.inside, "DEF");
    std::string faces = "<" + std::string(own.endName);
    if (!definition.empty()) faces.append(" DEF=\"").append(definition).append("\"");
    faces += roundFaces(isCone ? 0 : radius, radius, height, has("side"), !isCone && has("top"), has("bottom"));
    if (endsItself(tag)) faces.append("</").append(own.endName).append(">");
    rewriting_.replace(rewriting_.whole(tag), faces);
  }

  /// Shapes of which Assimp looks at ccw="false" are left as they are: triangles by index, strips and fans, elevation grids.
  void turn(const XmlTag& tag, Open& own) {
    if (tag.name == "IndexedFaceSet" && isClockwise(tag)) {
      const std::string_view indices = attributeIn(tag.inside, "coordIndex");
      if (!indices.empty()) rewriting_.replace(indices, reversed(indices));
    } else if (tag.name == "TriangleSet" && isClockwise(tag)) {
      own.endName = "IndexedTriangleSet";
      rewriting_.replace(tag.name, own.endName);
      if (attributeIn(tag.inside, "USE").empty()) indexTriangles(tag);
    } else if (tag.name == "TriangleStripSet") {
      own.endName = "IndexedTriangleStripSet";
      rewriting_.replace(tag.name, own.endName);
      if (attributeIn(tag.inside, "USE").empty()) indexStrips(tag);
    } else if (tag.name == "Extrusion" && attributeIn(tag.inside, "USE").empty()) {
      turnExtrusion(tag);
    }
  }

  /// Assimp's sides look inwards unless ccw is "false"; its ends never change, and the first one is turned over.
  void turnExtrusion(const XmlTag& tag) {
    if (!isClockwise(tag)) {
      const std::string_view own = attributeIn(tag.inside, "ccw");
      rewriting_.replace(own.empty() ? tag.inside.substr(0, 0) : own, own.empty() ? " ccw=\"false\"" : "false");
      return;
    }
    const std::string_view section = attributeIn(tag.inside, "crossSection");
    std::vector<std::string_view> words = wordsIn(section.empty() ? "1 1 1 -1 -1 -1 -1 1 1 1" : section);
    std::string turned;
    for (std::size_t at = words.size() / 2; at-- > 0;) {
      turned.append(words[2 * at]).append(1, ' ').append(words[2 * at + 1]).append(1, ' ');
    }
    if (section.empty()) {
      rewriting_.replace(tag.inside.substr(0, 0), " crossSection=\"" + turned + '"');
    } else {
      rewriting_.replace(section, turned);
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
      if (!count || *count > mostOfStrips_) {
        fault_ = "has a stripCount of " + inQuotes(word) + "; there is no room for so many points";
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

Result<X3dText> preparedX3d(std::string_view file) { return X3dPreparing(file).run(); }

}  // namespace haptics
