#include "common/importer/x3d_text.h"

#include <algorithm>
#include <map>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

// ISO/IEC 19775-1: nodes that have the fields of the one beside them, and are felt like it. FogCoordinate is passed over.
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
                                                                  {"LineSet", "PointSet"},
                                                                  {"Normal", "FogCoordinate"},
                                                                  {"Color", "FogCoordinate"},
                                                                  {"ColorRGBA", "FogCoordinate"},
                                                                  {"TextureCoordinate", "FogCoordinate"}};
  return names;
}

constexpr std::string_view kSkipped[] = {"Text",
                                         "PointSet",
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

/// Numbers, and with them the corners of each face, the other way round.
std::string reversed(std::string_view numbers) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = numbers.find_first_not_of(" ,\t\r\n", at)) != numbers.npos;) {
    const std::size_t end = std::min(numbers.find_first_of(" ,\t\r\n", at), numbers.size());
    words.push_back(numbers.substr(at, end - at));
    at = end;
  }
  if (!words.empty() && words.back() == "-1") words.pop_back();
  std::string text;
  for (auto word = words.rbegin(); word != words.rend(); ++word) text.append(*word).append(" ");
  return text;
}

template <std::size_t N>
bool isOneOf(const std::string_view (&those)[N], std::string_view name) {
  return std::find(std::begin(those), std::end(those), name) != std::end(those);
}

}  // namespace

Result<X3dText> preparedX3d(std::string_view file) {
  X3dText prepared;
  std::string fault;
  std::size_t taken = 0;
  const auto replace = [&](std::string_view part, std::string_view by) {
    const auto at = static_cast<std::size_t>(part.data() - file.data());
    prepared.text.append(file.substr(taken, at - taken)).append(by);
    taken = at + part.size();
  };
  eachTag(file, [&](const XmlTag& tag) {
    if (tag.name == "unit" && attributeIn(tag.inside, "category") == "length") {
      prepared.unit = attributeIn(tag.inside, "conversionFactor");
    }
    if (attributeIn(tag.inside, "ccw") == "false") {
      const bool isOfFaces = tag.name == "IndexedFaceSet";
      const std::string_view indices = attributeIn(tag.inside, isOfFaces ? "coordIndex" : "index");
      if (!isOfFaces && tag.name != "IndexedTriangleSet") {
        fault = "has ccw=\"false\" in " + inQuotes(tag.name) + ", where it is not read";
      } else if (!indices.empty()) {
        replace(indices, reversed(indices));
      }
    }
    prepared.skipped += !tag.ends && isOneOf(kSkipped, tag.name) ? 1 : 0;
    if (const auto as = readAs().find(tag.name); as != readAs().end()) {
      replace(tag.name, tag.ends ? as->second.substr(0, as->second.find(' ')) : as->second);
    }
    return fault.empty();
  });
  if (!fault.empty()) return refused("", fault);
  prepared.text.append(file.substr(taken));
  return prepared;
}

}  // namespace haptics
