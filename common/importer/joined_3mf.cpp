#include "common/importer/joined_3mf.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

struct Replacement {
  std::string_view old;  // in the text
  std::string with;
};

/// @param replacements  In the text's order, none in another.
void append(std::string& to, std::string_view text, const std::vector<Replacement>& replacements) {
  for (const auto& [old, with] : replacements) {
    const auto before = static_cast<std::size_t>(old.data() - text.data());
    to.append(text.substr(0, before)).append(with);
    text.remove_prefix(before + old.size());
  }
  to.append(text);
}

class Joining {
 public:
  explicit Joining(const std::vector<Model3mf>& models) : models_(models), unit_(unitOf(models.front().text)) {
    eachTag(models.front().text, [&](const XmlTag& tag) {
      const std::string_view id = attributeIn(tag.inside, "id");
      std::size_t number = 0;
      std::from_chars(id.data(), id.data() + id.size(), number);
      if (number < kMaxNumber) next_ = std::max(next_, number + 1);
      return true;
    });
  }

  [[nodiscard]] Result<std::string> join() {
    const std::string& root = models_.front().text;
    auto replacements = replacementsIn(0);
    std::vector<std::string> ofModels;
    for (std::size_t i = 0; !error_ && i < named_.size(); ++i) ofModels.push_back(objectsOf(named_[i]));
    if (error_) return tl::unexpected(*error_);
    std::string objects;
    for (auto each = ofModels.rbegin(); each != ofModels.rend(); ++each)
      objects += *each;  // parts before what has them
    eachTag(root, [&](const XmlTag& tag) {
      if (tag.ends || tag.name != "resources") return true;
      const std::size_t end = static_cast<std::size_t>(tag.inside.data() + tag.inside.size() - root.data());
      if (end >= root.size()) return false;
      if (!tag.inside.ends_with('/')) {
        replacements.push_back({std::string_view(root).substr(end + 1, 0), objects});
      } else {
        const std::size_t name = tag.begin + 1;
        const std::string whole = root.substr(name, tag.at + tag.name.size() - name);
        replacements.push_back({std::string_view(root).substr(end - 1, 2), ">" + objects + "</" + whole + ">"});
      }
      return false;
    });
    std::ranges::stable_sort(replacements, {}, [](const Replacement& each) { return each.old.data(); });
    std::string all;
    append(all, root, replacements);
    return all;
  }

 private:
  static constexpr std::size_t kMaxNumber = 2'147'483'647;  // ST_ResourceID of 3MF Core 1.3

  const std::vector<Model3mf>& models_;
  std::string unit_;
  std::size_t next_ = 1;
  std::map<std::pair<std::size_t, std::string>, std::size_t> numbers_;  // of models' objects
  std::vector<std::size_t> named_;                                      // models, as they are come upon
  std::optional<Error> error_;

  [[nodiscard]] static std::string unitOf(std::string_view text) {
    std::string unit;
    eachTag(text, [&](const XmlTag& tag) {
      if (tag.name != "model") return true;
      unit = attributeIn(tag.inside, "unit");
      return false;
    });
    return unit.empty() ? "millimeter" : unit;
  }

  [[nodiscard]] std::string numberOf(std::size_t model, std::string_view id) {
    const auto [at, isNew] = numbers_.try_emplace({model, std::string(id)}, next_);
    next_ += isNew ? 1 : 0;
    return std::to_string(at->second);
  }

  /// The model at a path; where there is none, the one that names it, and an error.
  [[nodiscard]] std::size_t modelAt(std::string_view path, std::size_t from) {
    if (path.starts_with('/')) path.remove_prefix(1);
    const auto at = std::ranges::find_if(models_, [&](const Model3mf& each) { return isOnePath(each.name, path); });
    if (at == models_.end()) {
      error_ = Error{"", "names an object of " + inQuotes(path) + ", a model that its archive does not have"};
      return from;
    }
    const auto found = static_cast<std::size_t>(at - models_.begin());
    if (found == 0 || std::ranges::find(named_, found) != named_.end()) return found;
    named_.push_back(found);
    if (const std::string unit = unitOf(at->text); unit != unit_)
      error_ = Error{"", "has models in " + inQuotes(unit_) + " and in " + inQuotes(unit) + "; one unit is read"};
    return found;
  }

  /// Of the numbers of objects that are others in the whole.
  [[nodiscard]] std::vector<Replacement> replacementsIn(std::size_t model) {
    std::vector<Replacement> all;
    const auto renumber = [&](std::string_view id, std::size_t of) {
      if (!id.empty() && of != 0) all.push_back({id, numberOf(of, id)});
    };
    eachTag(models_[model].text, [&](const XmlTag& tag) {
      if (tag.ends) return true;
      if (tag.name == "component" || tag.name == "item") {
        const std::string_view path = attributeIn(tag.inside, ":path");
        renumber(attributeIn(tag.inside, "objectid"), path.empty() ? model : modelAt(path, model));
      } else if (model != 0 && (tag.name == "object" || tag.name == "triangle")) {
        std::vector<Replacement> own;
        if (const std::string_view pid = attributeIn(tag.inside, "pid"); !pid.empty()) own.push_back({pid, "0"});
        const std::string_view id = tag.name == "object" ? attributeIn(tag.inside, "id") : std::string_view();
        if (!id.empty()) own.push_back({id, numberOf(model, id)});
        std::ranges::sort(own, {}, [](const Replacement& each) { return each.old.data(); });
        std::ranges::move(own, std::back_inserter(all));
      }
      return !error_;
    });
    return all;
  }

  [[nodiscard]] std::string objectsOf(std::size_t model) {
    const std::string& text = models_[model].text;
    const auto replacements = replacementsIn(model);
    std::string objects;
    std::size_t begin = text.npos;
    auto next = replacements.begin();
    eachTag(text, [&](const XmlTag& tag) {
      if (tag.name != "object") return true;
      if (!tag.ends) begin = tag.begin;
      if ((!tag.ends && !tag.inside.ends_with('/')) || begin == text.npos) return true;
      const std::string_view object(
          text.data() + begin,
          static_cast<std::size_t>(tag.inside.data() + tag.inside.size() + 1 - text.data()) - begin);
      const auto isBefore = [&](const Replacement& each) { return each.old.data() < object.data(); };
      const auto isIn = [&](const Replacement& each) { return each.old.data() < object.data() + object.size(); };
      next = std::find_if_not(next, replacements.end(), isBefore);
      const auto end = std::find_if_not(next, replacements.end(), isIn);
      append(objects, object, std::vector<Replacement>(next, end));
      begin = text.npos;
      return true;
    });
    return objects;
  }
};

}  // namespace

bool isOnePath(std::string_view a, std::string_view b) { return inLowerCase(a) == inLowerCase(b); }

Result<std::string> joined(std::vector<Model3mf> models) {
  if (models.size() == 1) return std::move(models.front().text);
  return Joining(models).join();
}

}  // namespace haptics
