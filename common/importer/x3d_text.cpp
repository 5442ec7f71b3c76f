#include "common/importer/x3d_text.h"

#include <algorithm>
#include <map>

#include "common/importer/xml_text.h"

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

constexpr std::string_view kFaces[] = {"IndexedFaceSet",        "IndexedTriangleSet", "IndexedTriangleStripSet",
                                       "IndexedTriangleFanSet", "TriangleSet",        "TriangleStripSet",
                                       "TriangleFanSet",        "ElevationGrid",      "Extrusion"};
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

template <std::size_t N>
bool isOneOf(const std::string_view (&those)[N], std::string_view name) {
  return std::find(std::begin(those), std::end(those), name) != std::end(those);
}

}  // namespace

Result<X3dText> preparedX3d(std::string_view file) {
  X3dText prepared;
  std::size_t taken = 0, shapes = 0, clockwise = 0;
  eachTag(file, [&](const XmlTag& tag) {
    if (tag.name == "unit" && attributeIn(tag.inside, "category") == "length") {
      prepared.unit = attributeIn(tag.inside, "conversionFactor");
    }
    if (!tag.ends && isOneOf(kFaces, tag.name)) {
      ++shapes;
      clockwise += attributeIn(tag.inside, "ccw") == "false" ? 1 : 0;
    }
    prepared.skipped += !tag.ends && isOneOf(kSkipped, tag.name) ? 1 : 0;
    if (const auto as = readAs().find(tag.name); as != readAs().end()) {
      prepared.text.append(file.substr(taken, tag.at - taken));
      prepared.text.append(tag.ends ? as->second.substr(0, as->second.find(' ')) : as->second);
      taken = tag.at + tag.name.size();
    }
    return true;
  });
  if (clockwise > 0 && clockwise < shapes) {
    return refused("", "has ccw=\"false\" in " + std::to_string(clockwise) + " of " + std::to_string(shapes) +
                           " shapes, and its reader does not tell them apart; give all of them one order");
  }
  prepared.isClockwise = clockwise > 0;
  prepared.text.append(file.substr(taken));
  return prepared;
}

}  // namespace haptics
