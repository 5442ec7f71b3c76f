#include "common/importer/model_3mf.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

class Checking {
 public:
  explicit Checking(std::string_view text) : text_(text) {}

  Result<void> run() {
    eachTag(text_, [&](const XmlTag& tag) {
      if (!tag.ends) take(tag);
      return fault_.empty();
    });
    for (const auto& [element, id] : named_) {
      if (fault_.empty() && !objects_.contains(id))
        fault_ = "has " + element + " of the object of id " + inQuotes(id) + ", which is not there (objectid)";
    }
    for (auto& [id, object] : objects_) {
      if (fault_.empty() && isInItself(object))
        fault_ = "has an object of id " + inQuotes(id) + " that is a part of itself";
    }
    if (fault_.empty()) return {};
    return refused("", fault_);
  }

 private:
  struct Object {
    std::vector<std::string_view> parts;
    enum class Search { kNotBegun, kBegun, kDone } search = Search::kNotBegun;
  };

  std::string_view text_;
  std::string fault_;
  std::map<std::string_view, Object> objects_;
  std::vector<std::pair<std::string, std::string_view>> named_;  ///< By items and components: an element, an object.
  std::string_view object_;                                      ///< The last that began.
  std::size_t vertices_ = 0, triangles_ = 0;

  void take(const XmlTag& tag) {
    if (tag.name == "vertex") {
      for (const char* axis : {"x", "y", "z"}) {
        const std::string_view text = attributeIn(tag.inside, axis);
        if (!asNumber(trimmedOf(text))) return fail("vertex", vertices_, axis, text, "is a number");
      }
      ++vertices_;
    } else if (tag.name == "triangle") {
      for (const char* corner : {"v1", "v2", "v3"}) {
        const std::string_view text = attributeIn(tag.inside, corner);
        if (!numberOf<std::uint64_t>(trimmedOf(text)))
          return fail("triangle", triangles_, corner, text, "is the number of a vertex, from 0");
      }
      ++triangles_;
    } else if (tag.name == "object") {
      object_ = attributeIn(tag.inside, "id");
      vertices_ = triangles_ = 0;
      if (!objects_.try_emplace(object_).second) fault_ = "has two objects of id " + inQuotes(object_);
    } else if (tag.name == "component") {
      objects_[object_].parts.push_back(attributeIn(tag.inside, "objectid"));
      named_.emplace_back("a <component>", attributeIn(tag.inside, "objectid"));
      checkTransform(tag);
    } else if (tag.name == "item") {
      named_.emplace_back("an <item>", attributeIn(tag.inside, "objectid"));
      checkTransform(tag);
    } else if (tag.name == "model") {
      const std::string_view unit = attributeIn(tag.inside, "unit");
      if (unitOf3mf(unit)) return;
      fault_ = "has the unit " + inQuotes(unit) + "; 3MF has micron, millimeter, centimeter, inch, foot and meter";
    }
  }

  static std::string_view trimmedOf(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    return text.substr(0, text.find_last_not_of(kBlanks) + 1);
  }

  void fail(const char* element, std::size_t number, const char* attribute, std::string_view text, const char* right) {
    fault_ = std::string("has a ") + element + ' ' + std::to_string(number) + " (from 0) in the object of id " +
             inQuotes(object_) + " whose " + attribute + " is " + inQuotes(text) + "; it " + right;
  }

  void checkTransform(const XmlTag& tag) {
    const std::string_view text = attributeIn(tag.inside, "transform");
    const auto words = wordsIn(text);
    bool holds = words.empty() || (words.size() == 12 && text.find(',') == text.npos);
    for (const std::string_view word : words) holds = holds && std::isfinite(numberOf<double>(word).value_or(NAN));
    if (holds) return;
    fault_ = "has an <" + std::string(tag.name) + "> of object " + inQuotes(attributeIn(tag.inside, "objectid")) +
             " whose transform is " + inQuotes(text) + "; it is twelve numbers between blanks";
  }

  /// XML is not nested deeper than kDeepestNesting; objects may be.
  bool isInItself(Object& from) {
    std::vector<std::pair<Object*, std::size_t>> path{{&from, 0}};
    while (!path.empty()) {
      auto& [object, next] = path.back();
      if (object->search == Object::Search::kDone || next == object->parts.size()) {
        object->search = Object::Search::kDone;
        path.pop_back();
        continue;
      }
      if (next == 0) object->search = Object::Search::kBegun;
      const auto part = objects_.find(object->parts[next++]);
      if (part == objects_.end()) continue;
      if (part->second.search == Object::Search::kBegun) return true;
      if (part->second.search == Object::Search::kNotBegun) path.emplace_back(&part->second, 0);
    }
    return false;
  }
};

}  // namespace

Result<void> checkModel3mf(std::string_view text) { return Checking(text).run(); }

std::optional<double> unitOf3mf(std::string_view word) {
  const std::string lower = inLowerCase(word);
  if (lower.empty() || lower == "mm") return 1e-3;
  for (const auto& [name, unit_m] : {std::pair{"micron", 1e-6},
                                     {"millimeter", 1e-3},
                                     {"centimeter", 1e-2},
                                     {"inch", 0.0254},
                                     {"foot", 0.3048},
                                     {"meter", 1.0}}) {
    if (lower == name) return unit_m;
  }
  return std::nullopt;
}

}  // namespace haptics
