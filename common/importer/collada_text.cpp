#include "common/importer/collada_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/maths/vec.h"
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

/// Of an element's own id; empty: of another file.
std::string_view idIn(std::string_view url) {
  url.remove_prefix(std::min(url.find_first_not_of(" \t\r\n"), url.size()));
  url = url.substr(0, url.find_last_not_of(" \t\r\n") + 1);
  return url.starts_with('#') ? url.substr(1) : std::string_view();
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
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (rewriting_.isReplaced(tag)) return true;
      if (tag.ends) {
        if (tag.name == "visual_scene") isUnshown_ = false;
      } else {
        take(tag);
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

  XmlRewriting rewriting_;
  ColladaText prepared_;
  std::string fault_;
  std::set<std::string_view> meshes_, nodes_;
  std::map<std::string_view, Controller> controllers_;
  std::string_view scene_;
  bool isUnshown_ = false;    ///< In a visual_scene that is not shown.
  bool isUncounted_ = false;  ///< In a primitive without a count.
  std::string_view primitive_;
  /// Bytes of triangles: each corner of a fan is written three times.
  std::size_t mostOfFans_ = 64'000'000 + 4 * rewriting_.text().size();

  void collect() {
    std::string_view geometry, controller;
    eachTag(rewriting_.text(), [&](const XmlTag& tag) {
      if (tag.ends) return true;
      const std::string_view id = attributeIn(tag.inside, "id");
      if (tag.name == "geometry") geometry = id;
      if (tag.name == "controller") controller = id;
      if (tag.name == "mesh") meshes_.insert(geometry);
      if (tag.name == "node") nodes_.insert(id);
      if (tag.name == "skin" || tag.name == "morph") {
        controllers_[controller] = {idIn(attributeIn(tag.inside, "source")), tag.name == "morph"};
      }
      if (tag.name == "instance_visual_scene") scene_ = idIn(attributeIn(tag.inside, "url"));
      return true;
    });
  }

  void take(const XmlTag& tag) {
    if (isOneOf(kUnfeltOfCollada, tag.name)) {
      rewriting_.replaceElement(tag, "");
    } else if (tag.name == "visual_scene") {
      isUnshown_ = attributeIn(tag.inside, "id") != scene_ && !tag.inside.ends_with('/');
    } else if (tag.name == "instance_geometry" || tag.name == "instance_controller") {
      place(tag);
    } else if (tag.name == "instance_node") {
      const std::string_view id = idIn(attributeIn(tag.inside, "url"));
      if (!id.empty() && nodes_.contains(id)) return;
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
    } else if (tag.name == "trifans") {
      takeFans(tag);
    } else if (isOneOf(kPrimitives, tag.name)) {
      primitive_ = tag.name;
      isUncounted_ = numberOf<std::uint64_t>(attributeIn(tag.inside, "count")).value_or(0) == 0;
    } else if (tag.name == "p" && isUncounted_ && !wordsIn(textAfter(rewriting_.text(), tag)).empty()) {
      fault_ = "has <" + std::string(primitive_) +
               "> with indices and without a count; give it the number of its primitives";
    }
  }

  /// No id where controllers lead to one another in a ring.
  Source lastSource(std::string_view id) {
    std::vector<Controller*> passed;
    auto at = controllers_.find(id);
    for (; at != controllers_.end() && !at->second.last; at = controllers_.find(id)) {
      at->second.last.emplace();
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

  /// The mesh that an instance leads to, as it is stored.
  void place(const XmlTag& tag) {
    const std::string_view url = idIn(attributeIn(tag.inside, "url"));
    const Source source = tag.name == "instance_controller" ? lastSource(url) : Source{url};
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
    std::size_t stride = 1;
    std::string inputs, corners;
    std::uint64_t triangles = 0;
    eachTag(fans, [&](const XmlTag& tag) {
      if (tag.ends) return true;
      if (tag.name == "input") {
        const auto offset = numberOf<std::size_t>(attributeIn(tag.inside, "offset")).value_or(0);
        stride = std::max(stride, std::min(offset, fans.size()) + 1);
        inputs.append("<input").append(tag.inside).append(">").append(tag.inside.ends_with('/') ? "" : "</input>");
      } else if (tag.name == "p") {
        std::string first, before, corner;
        std::size_t words = 0;
        eachWord(textAfter(fans, tag), [&](std::string_view word) {
          corner.append(word).append(1, ' ');
          if (++words % stride != 0) return;
          if (words == stride) first = corner;
          if (words > 2 * stride && corners.size() <= mostOfFans_) {
            corners.append(first).append(before).append(corner);
            ++triangles;
          }
          before = std::exchange(corner, {});
        });
      }
      return true;
    });
    if (corners.size() > mostOfFans_) {
      fault_ = "has <trifans> that make many times the file's bytes as triangles; export triangles";
      return;
    }
    mostOfFans_ -= corners.size();
    rewriting_.replace(fans, "<triangles count=\"" + std::to_string(triangles) + "\">" + inputs + "<p>" + corners +
                                 "</p></triangles>");
  }
};

}  // namespace

Result<ColladaText> preparedCollada(std::string_view file) { return ColladaPreparing(file).run(); }

}  // namespace haptics
