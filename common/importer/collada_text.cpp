#include "common/importer/collada_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/gltf_numbers.h"
#include "common/importer/xml_text.h"
#include "common/maths/vec.h"
#include "common/mesh/polygon_soup.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

constexpr std::string_view kUnfeltOfCollada[] = {
    "library_controllers",    "library_effects",      "library_materials",      "library_images",
    "library_lights",         "library_cameras",      "library_physics_models", "library_physics_materials",
    "library_physics_scenes", "library_force_fields", "instance_camera",        "instance_light",
    "instance_physics_scene"};
constexpr std::string_view kPrimitives[] = {"triangles", "trifans", "tristrips", "polylist",
                                            "polygons",  "lines",   "linestrips"};

// What places a node, and its numbers.
struct Placing {
  std::string_view element;
  std::size_t count;
};
constexpr Placing kPlacing[] = {{"translate", 3}, {"scale", 3}, {"matrix", 16}, {"lookat", 9}};

/// Of an element's own id; empty: of another file.
std::string_view idIn(std::string_view url) {
  url.remove_prefix(std::min(url.find_first_not_of(" \t\r\n"), url.size()));
  url = url.substr(0, url.find_last_not_of(" \t\r\n") + 1);
  return url.starts_with('#') ? url.substr(1) : std::string_view();
}

/// What Assimp reads of an attribute as a whole number.
std::size_t countIn(std::string_view attribute, std::size_t instead) {
  attribute.remove_prefix(std::min(attribute.find_first_not_of(" \t\r\n+"), attribute.size()));
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(attribute.data(), attribute.data() + attribute.size(), value);
  return error == std::errc() ? value : instead;
}

/// The text up to the next tag.
std::string_view textAfter(std::string_view text, const XmlTag& tag) {
  const auto from = static_cast<std::size_t>(tag.inside.data() + tag.inside.size() - text.data()) + 1;
  if (from >= text.size()) return {};
  return text.substr(from, text.find('<', from) - from);
}

/// COLLADA 1.4.1, as RiSkew: points along the first axis go towards the second by the angle. Row by row; nothing: they cannot.
std::optional<std::string> skewed(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : wordsIn(text)) {
    const auto number = numberOf<double>(word);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  if (numbers.size() != 7) return std::nullopt;
  const Vec3 from = glm::normalize(Vec3(numbers[1], numbers[2], numbers[3]));
  const Vec3 along = glm::normalize(Vec3(numbers[4], numbers[5], numbers[6]));
  const double cosine = glm::dot(from, along), sine = glm::length(from - cosine * along);
  const double angle = std::atan2(sine, cosine), left = angle - numbers[0] * std::numbers::pi / 180;
  if (!(sine > 0) || !(left > 0) || !(left < std::numbers::pi)) return std::nullopt;
  const double shear = std::cos(left) / std::sin(left) - cosine / sine;
  const Vec3 across = (from - cosine * along) / sine;
  std::string matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double number = (row == column ? 1 : 0) + shear * along[row] * across[column];
      char word[32];
      matrix.append(word, std::to_chars(word, word + sizeof word, number).ptr).append(1, ' ');
    }
    matrix += "0 ";
  }
  return matrix + "0 0 0 1";
}

class ColladaPreparing {
 public:
  explicit ColladaPreparing(std::string_view text) : rewriting_(text) {}

  Result<ColladaText> run() {
    collect();
    if (scene_.empty() && !meshes_.empty()) {
      return refused("", "shows none of its scenes: it has no <scene> with an <instance_visual_scene>");
    }
    if (!scene_.empty() && !scenes_.contains(asKnown(scene_, scenes_)))
      return refused("", "shows the scene " + inQuotes(scene_) + " (instance_visual_scene), which is not there");
    if (!fault_.empty()) return refused("", fault_);
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (tag.ends && !open_.empty()) open_.pop_back();
      const bool begins = !tag.ends && !tag.inside.ends_with('/');
      if (rewriting_.isReplaced(tag)) {
        if (begins) open_.push_back(tag.name);
        return true;
      }
      if (tag.ends) {
        if (tag.name == "visual_scene") isUnshown_ = false;
        if (tag.name == "vertices") isOfVertices_ = false;
        if (isOneOf(kPrimitives, tag.name)) corners_.reset();
        if (isOfConvex_ && tag.name == "convex_mesh") {
          rewriting_.replace(tag.name, "mesh");
          isOfConvex_ = false;
        }
      } else {
        take(tag);
        if (begins) open_.push_back(tag.name);
      }
      return fault_.empty();
    });
    if (!fault_.empty()) return refused("", fault_);
    prepared_.text = rewriting_.end();
    return std::move(prepared_);
  }

 private:
  /// What a controller leads to, by others or not.
  struct Source {
    std::string_view id;
    std::uint64_t skins = 0, morphs = 0;
  };
  struct Controller {
    std::string_view source;
    bool isMorph = false;
    std::optional<Source> last = {};  ///< Once it has been looked for.
  };

  struct Array {
    std::size_t count = 0;
    std::string_view numbers = {};
  };
  /// What an accessor reads.
  struct Accessor {
    std::string_view array = {};
    std::size_t count = 0, offset = 0, stride = 1;
    std::size_t params = 0, last = 0;      ///< The last of those that are a coordinate.
    std::size_t xyz[3] = {};               ///< Which param each coordinate is.
    bool isNamed = false;                  ///< One of them at least.
    std::optional<std::size_t> room = {};  ///< Points, once they have been counted.
  };
  /// Which words of a primitive's indices are corners.
  struct Corners {
    std::size_t stride = 1, offset = 0;  ///< In a corner's words.
    std::size_t begin = 0;               ///< Of the input that names the points, in the text.
    std::string_view semantic = {}, source = {};
    std::string_view positions = {};                             ///< The <source> of the points.
    std::size_t room = std::numeric_limits<std::size_t>::max();  ///< Points.
  };

  /// The numbers of a source that has points.
  struct Points {
    std::vector<std::string_view> words = {};
    Accessor accessor = {};

    /// What is no number, Assimp says.
    [[nodiscard]] Vec3 at(std::size_t point) const {
      Vec3 place(0);
      for (int i = 0; i < 3; ++i) {
        const std::size_t word = accessor.offset + point * accessor.stride + accessor.xyz[i];
        if (word < words.size()) place[i] = numberOf<double>(words[word]).value_or(0);
      }
      return place;
    }
  };

  XmlRewriting rewriting_;
  ColladaText prepared_;
  std::map<std::string_view, Array> arrays_;
  std::map<std::string_view, Accessor> accessors_;            ///< By the id of their source.
  std::map<std::string_view, std::string_view> positionsOf_;  ///< The source, by the id of <vertices>.
  std::optional<Corners> corners_;                            ///< Of the primitive that has begun.
  /// Sources of points whose coordinates have no names: they are the first three.
  std::set<std::string_view> unnamed_;
  std::string_view source_;
  bool isOfVertices_ = false, isOfConvex_ = false;

  /// A mesh that says of itself that it is convex, which Assimp leaves out; one that another one's hull is to be made of is not read.
  static bool isConvexMesh(const XmlTag& tag) {
    return tag.name == "convex_mesh" && !tag.inside.ends_with('/') && attributeIn(tag.inside, "convex_hull_of").empty();
  }
  std::string fault_;
  std::set<std::string_view> meshes_, nodes_, scenes_;
  std::vector<std::string_view> open_;  ///< Elements.
  std::map<std::string_view, Controller> controllers_;
  std::string_view scene_;
  bool isUnshown_ = false;    ///< In a visual_scene that is not shown.
  bool isUncounted_ = false;  ///< In a primitive without a count.
  std::string_view primitive_;
  /// Bytes of triangles: each corner of a fan is written three times.
  std::size_t mostOfHoles_ = 200'000'000;      ///< Holes times corners: a second.
  std::map<std::string_view, Points> points_;  ///< Of sources whose polygons have holes.
  std::size_t mostOfFans_ = 64'000'000 + 4 * rewriting_.text().size();

  void collect() {
    std::string_view geometry, controller, source, vertices;
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (tag.ends && tag.name == "vertices") vertices = {};
      if (tag.ends) return true;
      const std::string_view id = attributeIn(tag.inside, "id");
      if (tag.name == "source") source = id;
      if (tag.name == "vertices" && !tag.inside.ends_with('/')) vertices = id;
      if (tag.name == "float_array") {
        arrays_[id] = {countIn(attributeIn(tag.inside, "count"), 0), textAfter(rewriting_.text(), tag)};
      } else if (tag.name == "Name_array" || tag.name == "IDREF_array") {
        arrays_[id] = {};
      } else if (tag.name == "accessor") {
        accessors_[source] = {.array = idIn(attributeIn(tag.inside, "source")),
                              .count = countIn(attributeIn(tag.inside, "count"), 0),
                              .offset = countIn(attributeIn(tag.inside, "offset"), 0),
                              .stride = countIn(attributeIn(tag.inside, "stride"), 1)};
      } else if (tag.name == "param") {
        const std::string_view name = attributeIn(tag.inside, "name");
        Accessor& accessor = accessors_[source];
        if (name == "X" || name == "Y" || name == "Z") {
          accessor.isNamed = true;
          accessor.last = std::max(accessor.last, accessor.params);
          accessor.xyz[name[0] - 'X'] = accessor.params;
        }
        ++accessor.params;
      } else if (tag.name == "input" && !vertices.empty() && attributeIn(tag.inside, "semantic") == "POSITION") {
        positionsOf_[vertices] = idIn(attributeIn(tag.inside, "source"));
      }
      if (tag.name == "geometry") geometry = id;
      if (tag.name == "controller") controller = id;
      if (tag.name == "mesh" || isConvexMesh(tag)) meshes_.insert(geometry);
      if (tag.name == "node") nodes_.insert(id);
      if (tag.name == "visual_scene") scenes_.insert(id);
      if (tag.name == "skin" || tag.name == "morph") {
        controllers_[controller] = {idIn(attributeIn(tag.inside, "source")), tag.name == "morph"};
      }
      if (tag.name == "instance_visual_scene") scene_ = idIn(attributeIn(tag.inside, "url"));
      return true;
    });
    for (const auto& [id, positions] : positionsOf_) {
      const auto accessor = accessors_.find(positions);
      if (accessor == accessors_.end() && fault_.empty()) {
        fault_ = "has <vertices> of the id " + inQuotes(id) + " whose POSITION is the <source> " + inQuotes(positions) +
                 ", which is not there";
      }
      if (accessor == accessors_.end() || accessor->second.isNamed || accessor->second.stride < 3) continue;
      std::iota(std::begin(accessor->second.xyz), std::end(accessor->second.xyz), std::size_t{0});
      accessor->second.last = 2;
      unnamed_.insert(positions);
    }
  }

  void take(const XmlTag& tag) {
    if (isOneOf(kUnfeltOfCollada, tag.name)) {
      rewriting_.replaceElement(tag, "");
    } else if (tag.name == "visual_scene") {
      isUnshown_ = attributeIn(tag.inside, "id") != scene_ && !tag.inside.ends_with('/');
    } else if (tag.name == "instance_geometry" || tag.name == "instance_controller") {
      place(tag);
    } else if (tag.name == "instance_node") {
      const std::string_view written = idIn(attributeIn(tag.inside, "url")), id = asKnown(written, nodes_);
      if (!id.empty() && nodes_.contains(id)) {
        if (id != written) rewriting_.replaceElement(tag, "<instance_node url=\"#" + std::string(id) + "\"/>");
        return;
      }
      ++prepared_.skipped;
      rewriting_.replaceElement(tag, "");
    } else if (tag.name == "skew") {
      const auto matrix = skewed(textAfter(rewriting_.text(), tag));
      if (matrix) {
        rewriting_.replaceElement(tag, "<matrix>" + *matrix + "</matrix>");
      } else {
        fault_ = "has a <skew> of " + inQuotes(textAfter(rewriting_.text(), tag)) +
                 "; it is an angle in degrees, less than that between the two axes that follow it";
      }
    } else if (tag.name == "unit") {
      if (prepared_.unit.empty()) prepared_.unit = attributeIn(tag.inside, "meter");
      rewriting_.replaceElement(tag, "");
    } else if (tag.name == "rotate") {
      const std::string_view text = textAfter(rewriting_.text(), tag);
      std::string points(text);  // some write decimal commas, which Assimp takes for points
      std::size_t words = 0;
      for (TextScan scan(text); !scan.word().empty();) ++words;
      if (words == 4) std::ranges::replace(points, ',', '.');
      const auto rotation = ofUnitAxis(points);
      if (rotation) {
        rewriting_.replace(text, *rotation);
      } else {
        fault_ = "has a <rotate> of " + inQuotes(text) + "; it is an axis, which has a length, and an angle";
      }
    } else if (const auto* placing = std::ranges::find(kPlacing, tag.name, &Placing::element);
               placing != std::end(kPlacing) && !open_.empty() && open_.back() == "node") {
      checkPlacing(tag, placing->count);
    } else if (isConvexMesh(tag)) {
      isOfConvex_ = true;
      rewriting_.replace(tag.name, "mesh");
    } else if (tag.name == "source") {
      source_ = attributeIn(tag.inside, "id");
    } else if (tag.name == "accessor" && unnamed_.contains(source_)) {
      const Accessor& accessor = accessors_[source_];
      rewriting_.replaceElement(
          tag, "<accessor source=\"#" + std::string(accessor.array) + "\" count=\"" + std::to_string(accessor.count) +
                   "\" offset=\"" + std::to_string(accessor.offset) + "\" stride=\"" + std::to_string(accessor.stride) +
                   "\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
                   "type=\"float\"/></accessor>");
    } else if (tag.name == "vertices") {
      isOfVertices_ = positionsOf_.contains(attributeIn(tag.inside, "id")) && !tag.inside.ends_with('/');
    } else if (tag.name == "input" && isOfVertices_) {
      if (attributeIn(tag.inside, "semantic") != "POSITION") rewriting_.replaceElement(tag, "");
    } else if (tag.name == "input" && corners_) {
      rewriting_.replaceElement(tag, tag.begin == corners_->begin ? inputOf(*corners_) : "");
    } else if (tag.name == "trifans") {
      takeFans(tag);
    } else if (isOneOf(kPrimitives, tag.name)) {
      primitive_ = tag.name;
      if (!tag.inside.ends_with('/')) corners_ = cornersOf(tag);
      isUncounted_ = numberOf<std::uint64_t>(attributeIn(tag.inside, "count")).value_or(0) == 0;
    } else if (tag.name == "ph" && corners_) {
      takeHoles(tag);
    } else if (tag.name == "p" && isUncounted_ && !wordsIn(textAfter(rewriting_.text(), tag)).empty()) {
      fault_ = uncounted();
    } else if (tag.name == "p" && corners_) {
      takeIndices(textAfter(rewriting_.text(), tag));
    }
  }

  void checkPlacing(const XmlTag& tag, std::size_t count) {
    const std::string_view text = textAfter(rewriting_.text(), tag);
    std::string points(text);  // in place of decimal commas, of which Assimp knows
    std::size_t words = 0;
    for (TextScan scan(text); !scan.word().empty();) ++words;
    if (words == count) std::ranges::replace(points, ',', '.');
    const auto numbers = wordsIn(points);
    const bool areNumbers = std::ranges::all_of(numbers, [](auto word) { return numberOf<double>(word).has_value(); });
    if (areNumbers && numbers.size() == count) return;
    fault_ =
        "has a <" + std::string(tag.name) + "> of " + inQuotes(text) + "; it is " + std::to_string(count) + " numbers";
  }

  /// By the inputs at a primitive's beginning; nothing: none of them is of points.
  std::optional<Corners> cornersOf(const XmlTag& primitive) {
    Corners corners;
    bool found = false;
    const std::string_view text = rewriting_.text();
    const auto from = static_cast<std::size_t>(primitive.inside.data() + primitive.inside.size() - text.data());
    eachTag(text.substr(from), [&](const XmlTag& tag) {
      if (tag.name != "input") return false;
      if (tag.ends) return true;
      const std::size_t offset = std::min(countIn(attributeIn(tag.inside, "offset"), 0), text.size());
      const std::string_view semantic = attributeIn(tag.inside, "semantic");
      corners.stride = std::max(corners.stride, offset + 1);
      if (found || (semantic != "VERTEX" && semantic != "POSITION")) return true;
      found = true;
      corners.semantic = semantic;
      corners.source = idIn(attributeIn(tag.inside, "source"));
      corners.offset = offset;
      corners.begin = from + tag.begin;
      return true;
    });
    if (!found) return std::nullopt;
    const auto positions = positionsOf_.find(corners.source);
    const bool isByVertices = corners.semantic == "VERTEX" && positions != positionsOf_.end();
    corners.positions = isByVertices ? positions->second : corners.source;
    const auto accessor = accessors_.find(corners.positions);
    if (accessor != accessors_.end()) corners.room = roomOf(accessor->first, accessor->second);
    return corners;
  }

  static std::string inputOf(const Corners& corners) {
    return "<input semantic=\"" + std::string(corners.semantic) + "\" source=\"#" + std::string(corners.source) +
           "\" offset=\"0\"/>";
  }

  /// How many points there are. More than the numbers are for is nobody's point: Assimp would read beyond them.
  std::size_t roomOf(std::string_view source, Accessor& accessor) {
    if (accessor.room) return *accessor.room;
    const auto array = arrays_.find(accessor.array);
    if (array == arrays_.end()) {
      fault_ = "has a <source> of the id " + inQuotes(source) + " whose <accessor> reads the array " +
               inQuotes(accessor.array) + ", which is not there";
      return 0;
    }
    const std::size_t before = accessor.offset + accessor.last, numbers = array->second.count;
    std::size_t room = numbers > before ? (numbers - before - 1) / std::max<std::size_t>(accessor.stride, 1) + 1 : 0;
    if (accessor.stride == 0 && room > 0) room = accessor.count;
    accessor.room = std::min(room, accessor.count);
    std::size_t words = 0;
    eachWord(array->second.numbers, [&](std::string_view word) {
      if (++words > numbers || numberOf<double>(word) || !fault_.empty()) return;
      fault_ = "has a <float_array> with " + inQuotes(word) + " where a number should be, in the <source> " +
               inQuotes(source);
    });
    if (words < numbers && fault_.empty()) {
      fault_ = "has a <float_array> of count " + std::to_string(numbers) + " with " + std::to_string(words) +
               " numbers, in the <source> " + inQuotes(source);
    }
    return *accessor.room;
  }

  /// The corners alone, in Assimp's place of them.
  void takeIndices(std::string_view indices) {
    std::string kept;
    const std::size_t words = eachCorner(indices, *corners_, [&](std::string_view word) {
      if (corners_->stride > 1) kept.append(word).append(1, ' ');
    });
    if (primitive_ != "lines" && primitive_ != "linestrips") checkCount(words, "p");
    if (corners_->stride > 1) rewriting_.replace(indices, kept);
  }

  void checkCount(std::size_t words, std::string_view element) {
    if (words % corners_->stride == 0 || !fault_.empty()) return;
    fault_ = "has <" + std::string(primitive_) + "> with " + std::to_string(words) + " indices in a <" +
             std::string(element) + ">, which is no multiple of " + std::to_string(corners_->stride) +
             ", as many as its inputs take";
  }

  [[nodiscard]] std::string uncounted() const {
    return "has <" + std::string(primitive_) +
           "> with indices and without a count; give it the number of its primitives";
  }

  const Points& pointsOf(std::string_view source) {
    const auto [at, isNew] = points_.try_emplace(source);
    const auto accessor = accessors_.find(source);
    if (!isNew || accessor == accessors_.end()) return at->second;
    at->second.accessor = accessor->second;
    const auto array = arrays_.find(accessor->second.array);
    if (array != arrays_.end()) at->second.words = wordsIn(array->second.numbers);
    return at->second;
  }

  /// A polygon of which Assimp knows no holes becomes one outline.
  void takeHoles(const XmlTag& begin) {
    const std::string_view polygon = rewriting_.element(begin);
    const Points& points = pointsOf(corners_->positions);
    std::vector<std::string_view> words;  // of corners
    std::vector<Vec3> places;
    std::vector<std::vector<std::uint32_t>> outlines;  // the polygon's first
    eachTag(polygon, [&](const XmlTag& tag) {
      if (tag.ends || (tag.name != "p" && tag.name != "h")) return true;
      if ((tag.name == "p") != outlines.empty() && fault_.empty())
        fault_ = "has a <ph> that is not one <p> and then its <h>";
      outlines.emplace_back();
      const auto indices = eachCorner(textAfter(polygon, tag), *corners_, [&](std::string_view corner) {
        outlines.back().push_back(static_cast<std::uint32_t>(words.size()));
        words.push_back(corner);
        places.push_back(points.at(numberOf<std::size_t>(corner).value_or(0)));
      });
      checkCount(indices, tag.name);
      return fault_.empty();
    });
    if (isUncounted_ && !words.empty() && fault_.empty()) fault_ = uncounted();
    if (!fault_.empty()) return;
    const std::size_t holes = outlines.empty() ? 0 : outlines.size() - 1, steps = holes * words.size();
    if (steps > mostOfHoles_) {
      fault_ = "has polygons with so many holes (<h>) that joining them takes too long; export triangles";
      return;
    }
    mostOfHoles_ -= steps;
    std::string corners;
    if (!outlines.empty()) {
      for (const std::uint32_t corner : joinedOutline(outlines[0], {outlines.begin() + 1, outlines.end()}, places))
        corners.append(words[corner]).append(1, ' ');
    }
    rewriting_.replace(polygon, "<p>" + corners + "</p>");
  }

  /// Calls `take` with the index of each corner's point. The number of words.
  template <class Take>
  std::size_t eachCorner(std::string_view indices, const Corners& corners, const Take& take) {
    std::size_t words = 0;
    eachWord(indices, [&](std::string_view word) {
      if (words++ % corners.stride != corners.offset || !fault_.empty()) return;
      const auto index = numberOf<std::size_t>(word);
      if (index && *index < corners.room) return take(word);
      fault_ = "has <" + std::string(primitive_) + "> that names vertex " + inQuotes(word);
      if (corners.room != std::numeric_limits<std::size_t>::max()) {
        fault_ +=
            ", from 0; the count, offset and stride of its <accessor> and the count of its <float_array> leave room "
            "for " +
            std::to_string(corners.room);
      }
    });
    return words;
  }

  /// No id where controllers lead to one another in a ring.
  Source lastSource(std::string_view id) {
    std::vector<Controller*> passed;
    auto at = controllers_.find(id);
    for (; at != controllers_.end() && !at->second.last; at = controllers_.find(id)) {
      at->second.last = Source{};
      passed.push_back(&at->second);
      id = at->second.source;
    }
    Source last = at == controllers_.end() ? Source{id} : *at->second.last;
    for (auto controller = passed.rbegin(); controller != passed.rend(); ++controller) {
      ++((*controller)->isMorph ? last.morphs : last.skins);
      (*controller)->last = last;
    }
    return last;
  }

  /// As the file's ids have it, which a url may spell with percents.
  static std::string_view asKnown(std::string_view id, const std::set<std::string_view>& ids) {
    if (ids.contains(id)) return id;
    const auto other = ids.find(withoutPercents(std::string(id)));
    return other != ids.end() ? *other : id;
  }

  /// The mesh that an instance leads to, as it is stored.
  void place(const XmlTag& tag) {
    const std::string_view url = idIn(attributeIn(tag.inside, "url"));
    const Source source = tag.name == "instance_controller" ? lastSource(url) : Source{asKnown(url, meshes_)};
    if (source.id.empty() || !meshes_.contains(source.id)) {
      ++prepared_.skipped;
      rewriting_.replaceElement(tag, "");
      return;
    }
    LeftOut& left = prepared_.leftOut;
    left.skins += source.skins;
    left.morphs += source.morphs;
    left.unshown += isUnshown_ ? 1 : 0;
    rewriting_.replaceElement(tag, "<instance_geometry url=\"#" + std::string(source.id) + "\"/>");
  }

  void takeFans(const XmlTag& begin) {
    const std::string_view fans = rewriting_.element(begin);
    primitive_ = begin.name;
    const auto inputs = cornersOf(begin);
    if (!inputs) {
      fault_ = "has <trifans> without an <input> of semantic VERTEX";
      return;
    }
    std::string corners;
    std::uint64_t triangles = 0;
    eachTag(fans, [&](const XmlTag& tag) {
      if (tag.ends || tag.name != "p") return true;
      std::string_view first, before;
      eachCorner(textAfter(fans, tag), *inputs, [&](std::string_view corner) {
        if (!before.empty() && corners.size() <= mostOfFans_) {
          for (const std::string_view each : {first, before, corner}) corners.append(each).append(1, ' ');
          ++triangles;
        }
        if (first.empty()) {
          first = corner;
        } else {
          before = corner;
        }
      });
      return true;
    });
    if (corners.size() > mostOfFans_) {
      fault_ = "has <trifans> that make many times the file's bytes as triangles; export triangles";
      return;
    }
    mostOfFans_ -= corners.size();
    rewriting_.replace(fans, "<triangles count=\"" + std::to_string(triangles) + "\">" + inputOf(*inputs) + "<p>" +
                                 corners + "</p></triangles>");
  }
};

}  // namespace

Result<ColladaText> preparedCollada(std::string_view file) { return ColladaPreparing(file).run(); }

}  // namespace haptics
